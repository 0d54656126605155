"""Sums of products: the shape in which proposed expressions are compared, shortened and given units.

An expression becomes a sum of coefficients times products of powers of atoms: a quantity, its size, or a function of
such a sum of quantities. What nests functions, or runs to more parts than anybody reads, is dropped.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable

Atom = tuple[object, ...]
"""``("x", i)``, ``("abs", i)``, or ``("f", name, sum)`` with the sum as sorted pairs"""
Monomial = tuple[tuple[Atom, int], ...]
Sum = dict[Monomial, float]
ONE: Monomial = ()
MOST_PARTS = 8
MOST_POWER = 4
SLIGHT = 1e-5
"""of the largest coefficient, where quantities are of the order of one"""
FUNCTIONS = ("exp", "tanh", "sin", "cos", "inv")


class TooLong(Exception):
    """The expression is none that a formula may have."""


def quantity(i: int) -> Sum:
    """The quantity of number ``i``."""
    return {((("x", i), 1),): 1.0}


def parsed(text: str, positive: frozenset[int] = frozenset()) -> Sum:
    """An expression of ``X1``, ``X2`` … as a sum; ``positive``: numbers of quantities that never are below nothing.

    Raises TooLong where it is none of a short formula.
    """

    def value(node: ast.expr) -> Sum:
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            return {ONE: float(node.value)}
        if isinstance(node, ast.Name):
            return quantity(int(node.id[1:]) - 1)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return times({ONE: -1.0}, value(node.operand))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            return function(node.func.id, value(node.args[0]), positive)
        if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
            return _OPERATIONS[type(node.op)](value(node.left), value(node.right))
        raise TooLong(ast.unparse(node))

    return tidy(value(ast.parse(text.replace("^", "**"), mode="eval").body))


def plus(a: Sum, b: Sum) -> Sum:
    """a + b."""
    out = dict(a)
    for monomial, coefficient in b.items():
        out[monomial] = out.get(monomial, 0.0) + coefficient
    return out


def times(a: Sum, b: Sum) -> Sum:
    """a * b, multiplied out."""
    out: Sum = {}
    for first, p in a.items():
        for second, q in b.items():
            joined = _joined(first, second)
            out[joined] = out.get(joined, 0.0) + p * q
    if len(out) > MOST_PARTS:
        raise TooLong("too many parts")
    return out


def _joined(a: Monomial, b: Monomial) -> Monomial:
    powers: dict[Atom, int] = {}
    inside: Sum = {}
    for atom, power in (*a, *b):
        if atom[:2] == ("f", "exp"):  # exponents add up
            inside = plus(inside, {m: power * v for m, v in _sum(atom).items()})
        else:
            powers[atom] = powers.get(atom, 0) + power
    if any(abs(p) > MOST_POWER or (k[0] == "f" and p < 0) for k, p in powers.items()):
        raise TooLong("too high a power, or a pole")
    for atom in [k for k, p in powers.items() if k[0] == "abs" and p % 2 == 0]:
        powers[("x", atom[1])] = powers.get(("x", atom[1]), 0) + powers.pop(atom)
    inside = tidy(inside)
    if inside:
        powers[_atom("exp", inside)] = 1
    return tuple(sorted(((k, p) for k, p in powers.items() if p), key=repr))


def over(a: Sum, b: Sum) -> Sum:
    """a / b."""
    b = tidy(b)
    if len(b) == 1:
        (monomial, coefficient), *_ = b.items()
        return times(a, {_joined((), tuple((atom, -power) for atom, power in monomial)): 1.0 / coefficient})
    return times(a, function("inv", b))


def power(a: Sum, b: Sum) -> Sum:
    """a to a whole power."""
    exponent = b.get(ONE, 0.0) if set(b) <= {ONE} else 0.5
    if exponent not in (1.0, 2.0, 3.0, 4.0):
        raise TooLong("no whole power")
    out = a
    for _ in range(int(exponent) - 1):
        out = times(out, a)
    return out


def tidy(a: Sum) -> Sum:
    """A sum without parts that come to nothing."""
    largest = max((abs(v) for v in a.values()), default=0.0)
    if not math.isfinite(largest):
        raise TooLong("no number")
    return {m: v for m, v in a.items() if abs(v) > SLIGHT * largest}


def function(name: str, a: Sum, positive: frozenset[int] = frozenset()) -> Sum:
    """A function of a sum, with what can be taken out of it outside; ``positive``: see :func:`parsed`."""
    a = tidy(a)
    if any(atom[0] == "f" for monomial in a for atom, _ in monomial):
        raise TooLong("a function of a function")
    constant, rest = a.get(ONE, 0.0), {m: v for m, v in a.items() if m != ONE}
    if not rest:
        return {ONE: _NUMBERS[name](constant)}
    if name == "abs":
        return _size(rest, constant, positive)
    if name == "exp":
        if abs(constant) > 50.0:
            raise TooLong("no number")
        return {((_atom(name, rest), 1),): math.exp(constant)}
    if name == "inv":
        if constant == 0.0:
            raise TooLong("a pole")
        return {((_atom(name, {m: v / constant for m, v in rest.items()}), 1),): 1.0 / constant}
    sign = 1.0 if rest[min(rest, key=repr)] > 0 else -1.0
    of_sign = {m: sign * v for m, v in rest.items()}
    if name == "sin":
        wave: Sum = {((_atom("sin", of_sign), 1),): sign * math.cos(constant)}
        return plus(wave, {((_atom("cos", of_sign), 1),): math.sin(constant)})
    if name == "tanh":
        return {((_atom("tanh", of_sign | ({ONE: sign * constant} if constant else {})), 1),): sign}
    raise TooLong(name)


def _atom(name: str, inner: Sum) -> Atom:
    return ("f", name, tuple(sorted(inner.items(), key=repr)))


def _sum(atom: Atom) -> Sum:
    """What stands inside a function."""
    return dict(atom[2])  # type: ignore[call-overload, no-any-return]


def _size(rest: Sum, constant: float, positive: frozenset[int]) -> Sum:
    (monomial, coefficient), *others = rest.items()
    if others or constant or len(monomial) != 1 or monomial[0][0][0] != "x" or monomial[0][1] != 1:
        raise TooLong("the size of a sum")
    number = monomial[0][0][1]
    return {((("x" if number in positive else "abs", number), 1),): abs(coefficient)}


def structure(a: Sum) -> tuple[object, ...]:
    """What of a sum is left without its numbers, for telling shapes apart."""

    def bare(monomial: Monomial) -> object:
        return tuple(
            (atom if atom[0] != "f" else (*atom[:2], tuple((bare(m), v > 0) for m, v in atom[2])), power)  # type: ignore[attr-defined]
            for atom, power in monomial
        )

    return tuple(sorted((bare(m) for m in a if m != ONE), key=repr))


_NUMBERS: dict[str, Callable[[float], float]] = {
    "exp": lambda v: math.exp(min(v, 50.0)), "tanh": math.tanh, "sin": math.sin, "abs": abs,
    "inv": lambda v: 1.0 / v if v else math.inf,
}  # fmt: skip
_OPERATIONS: dict[type[ast.operator], Callable[[Sum, Sum], Sum]] = {
    ast.Add: plus, ast.Sub: lambda a, b: plus(a, times({ONE: -1.0}, b)), ast.Mult: times, ast.Div: over,
    ast.Pow: power,
}  # fmt: skip
