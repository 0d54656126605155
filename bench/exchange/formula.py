"""Formulas recorded while the code of a term runs, so that an export computes exactly what the analysis does.

A :class:`Written` stands for one number of a sample. NumPy's functions on it give another one that knows its operation
and arguments; equal formulas are one object. An operation that cannot be exported raises an error.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from bench.errors import ConfigurationError
from bench.simulation.tables import Grid

Value = Any
"""a number, or a Written"""

UFUNCS: dict[Any, str] = {
    np.add: "add", np.subtract: "sub", np.multiply: "mul", np.divide: "div", np.power: "pow", np.negative: "neg",
    np.absolute: "abs", np.sign: "sign", np.sin: "sin", np.cos: "cos", np.exp: "exp", np.tanh: "tanh",
    np.arctan: "atan", np.arcsinh: "asinh", np.log: "log", np.log1p: "log1p", np.log10: "log10", np.sqrt: "sqrt",
    np.maximum: "max", np.minimum: "min", np.remainder: "mod", np.greater: "gt", np.greater_equal: "ge",
    np.less: "lt", np.less_equal: "le", np.equal: "eq", np.not_equal: "ne", np.square: "square",
}  # fmt: skip
_EVALUATED: dict[str, Callable[..., float]] = {name: lambda *a, f=f: float(f(*a)) for f, name in UFUNCS.items()}


class Written(NDArrayOperatorsMixin):
    """One number of a sample: ``op`` of ``args``; ``extra`` are constants that belong to it.

    ``op`` is a name of :data:`UFUNCS`, ``const``, ``input``, ``parameter``, ``where``, ``table``, or a state.
    """

    __hash__ = object.__hash__

    def __init__(self, op: str, args: tuple[Written, ...] = (), extra: tuple[Any, ...] = ()) -> None:
        self.op, self.args, self.extra = op, args, extra

    @property
    def size(self) -> int:
        """One number."""
        return 1

    @property
    def real(self) -> Written:
        """Itself: complex numbers are not written."""
        return self

    def __bool__(self) -> bool:
        raise ConfigurationError("a decision that hangs on a sample cannot be written as a formula")

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **kwargs: Any) -> Any:
        if method != "__call__" or kwargs or ufunc not in UFUNCS:
            return NotImplemented
        return make(UFUNCS[ufunc], *inputs)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        del types
        if function not in _FUNCTIONS:
            return NotImplemented
        return _FUNCTIONS[function](*args, **kwargs)

    def astype(self, *_: Any) -> Written:
        """The same number; a comparison is 1 where it holds, else 0."""
        return where(self, 1.0, 0.0) if self.op in _COMPARISONS else self

    def __getitem__(self, key: Any) -> Written:
        return self

    def remembered(self, kind: str, *constants: float, beside: Sequence[Value] = ()) -> Written:
        """A state that is carried from sample to sample; each is one of its own unless kind, this input and those
        ``beside`` it are the same.
        """
        return node(kind, (self, *(lift(value) for value in beside)), constants)


_COMPARISONS = ("gt", "ge", "lt", "le", "eq", "ne")
_known: dict[tuple[Any, ...], Written] = {}


def node(op: str, args: tuple[Written, ...] = (), extra: tuple[Any, ...] = ()) -> Written:
    """The formula of an operation, the same object for the same formula."""
    key = (op, tuple(id(a) for a in args), extra)
    if key not in _known:
        _known[key] = Written(op, args, extra)
    return _known[key]


def const(value: float) -> Written:
    """A constant."""
    return node("const", (), (float(value),))


def reference(kind: str, name: str) -> Written:
    """Reference to an ``input`` or a ``parameter`` by its name."""
    return node(kind, (), (name,))


def lift(value: Value) -> Written:
    """Convert a number to a formula; a formula stays as it is."""
    if isinstance(value, Written):
        return value
    array = np.asarray(value)
    if array.dtype == object and array.size == 1:
        return lift(array.reshape(-1)[0])
    if array.size != 1 or array.dtype.kind not in "fiub":
        raise ConfigurationError(f"{type(value).__name__} of shape {array.shape} cannot be written as a formula")
    return const(float(array.reshape(-1)[0]))


def make(op: str, *values: Value) -> Written:
    """Apply an operation to values; where all of them are numbers it is evaluated at once."""
    args = tuple(lift(v) for v in values)
    if all(a.op == "const" for a in args):
        return const(_EVALUATED[op](*(a.extra[0] for a in args)))
    first, second = args[0], args[-1]
    if op in ("add", "sub") and _is_constant(second, 0.0):
        return first
    if op == "add" and _is_constant(first, 0.0):
        return second
    if op == "mul" and (_is_constant(first, 0.0) or _is_constant(second, 0.0)):
        return const(0.0)
    if op in ("mul", "div") and _is_constant(second, 1.0):
        return first
    if op == "mul" and _is_constant(first, 1.0):
        return second
    if op == "square" or (op == "pow" and second.op == "const" and second.extra[0] == 2.0):
        return node("mul", (first, first))
    return node(op, args)


def _is_constant(expression: Written, value: float) -> bool:
    return expression.op == "const" and bool(expression.extra[0] == value)


def where(condition: Value, yes: Value, no: Value) -> Written:
    """Choose between two values by a condition."""
    chosen = lift(condition)
    if chosen.op == "const":
        return lift(yes if chosen.extra[0] else no)
    return node("where", (chosen, lift(yes), lift(no)))


def table(grid: Grid, values: np.ndarray[Any, Any], places: Sequence[Value]) -> Written:
    """A table at some places: linear between its knots, constant beyond the outermost."""
    return node("table", tuple(lift(p) for p in places), (grid.knots, tuple(float(v) for v in np.ravel(values))))


def _clip(x: Value, low: Value = None, high: Value = None) -> Written:
    out = lift(x)
    out = out if low is None else make("max", out, low)
    return out if high is None else make("min", out, high)


class Columns(tuple[Written, ...]):
    """Columns of a regressor, one formula each."""

    __slots__ = ()


def columns_of(value: Any) -> list[Written]:
    """Columns of a regressor, one formula each."""
    if isinstance(value, Columns):
        return list(value)
    return [lift(v) for v in np.asarray(value).reshape(-1)]


_FUNCTIONS: dict[Any, Callable[..., Any]] = {
    np.where: where,
    np.clip: _clip,
    np.column_stack: lambda parts: Columns(lift(p) for p in parts),
    np.asarray: lambda x, *_, **__: x,
}


def in_evaluation_order(results: Sequence[Written]) -> list[Written]:
    """All formulas that ``results`` depend on, each after its arguments (topological order)."""
    out: list[Written] = []
    seen: set[int] = set()
    stack = [(r, False) for r in reversed(results)]
    while stack:
        expression, ready = stack.pop()
        if id(expression) in seen:
            continue
        if ready:
            seen.add(id(expression))
            out.append(expression)
            continue
        stack.append((expression, True))
        stack += [(a, False) for a in reversed(expression.args) if id(a) not in seen]
    return out


def total(parts: Sequence[Value]) -> Written:
    """Sum of some values."""
    out = const(0.0)
    for part in parts:
        out = make("add", out, part)
    return out


PI = math.pi
