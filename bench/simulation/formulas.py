"""Formulas of recorded quantities that no name fits: what a simulation file holds of them, and their values.

A formula is a sum of parts, each a coefficient times a factor times an expression of the quantities ``x1``, ``x2`` …
and constants. Outside what was recorded a quantity counts as at the edge of it: nothing was seen there.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from bench.errors import ConfigurationError
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import factor, quantity, require_known

FUNCTIONS: dict[str, Any] = {"exp": np.exp, "tanh": np.tanh, "sin": np.sin, "cos": np.cos, "abs": np.abs}
"""functions that an expression may have"""
_OPERATORS: dict[type[ast.operator], Any] = {
    ast.Add: np.add, ast.Sub: np.subtract, ast.Mult: np.multiply, ast.Div: np.divide, ast.Pow: np.power,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Formula:
    """A formula without its coefficients.

    ``over``: the quantities ``x1``, ``x2`` …; ``within``: range of each that was recorded; ``parts``: the factor
    (:mod:`bench.simulation.quantities`) and the expression of each part; ``constants``: symbol and value.
    """

    over: tuple[str, ...]
    within: tuple[tuple[float, float], ...]
    parts: tuple[tuple[str, str], ...]
    constants: tuple[tuple[str, float], ...] = ()

    @property
    def coefficients(self) -> tuple[str, ...]:
        """Symbols of the coefficients, one a part."""
        return tuple(f"c{k + 1}" for k in range(len(self.parts)))

    def columns(self, frame: Frame) -> FloatArray:
        """Regressors (n, parts) on the rows of a frame."""
        parts = self.parts_at([quantity(name, frame) for name in self.over])
        times = [factor(times, frame) for times, _ in self.parts]
        return np.column_stack([np.broadcast_to(t * p, (frame.size,)) for t, p in zip(times, parts, strict=True)])

    def parts_at(self, values: list[Any]) -> list[Any]:
        """Expressions of the parts, without their factors, for values of the quantities."""
        known: dict[str, Any] = dict(self.constants)
        for number, (value, (low, high)) in enumerate(zip(values, self.within, strict=True)):
            known[f"x{number + 1}"] = np.clip(value, low, high)
        return [evaluated(text, known) for _, text in self.parts]

    def to_json(self) -> dict[str, Any]:
        """A row of a simulation file, but for effect, channels and parameters."""
        return {
            "form": "formula",
            "over": list(self.over),
            "within": [list(ends) for ends in self.within],
            "parts": [{"times": times, "text": text} for times, text in self.parts],
        }


def evaluated(text: str, known: Mapping[str, Any]) -> Any:
    """Value of an expression. Raises ConfigurationError for a name or an operation that no formula has."""

    def value(node: ast.expr) -> Any:
        if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            return float(node.value)
        if isinstance(node, ast.Name) and node.id in known:
            return known[node.id]
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            return -value(node.operand)
        if isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
            return _OPERATORS[type(node.op)](value(node.left), value(node.right))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS:
            return FUNCTIONS[node.func.id](*(value(a) for a in node.args))
        raise ConfigurationError(
            f"the formula '{text}' has '{ast.unparse(node)}'; it should be made of {', '.join(known)}, + - * / ** and "
            f"{', '.join(FUNCTIONS)}"
        )

    # a formula that is tried may divide by nothing: what is no number is seen by whoever tries it
    with np.errstate(all="ignore"):
        return value(_parsed(text))


@lru_cache(512)
def _parsed(text: str) -> ast.expr:
    try:
        return ast.parse(text, mode="eval").body
    except SyntaxError as error:
        raise ConfigurationError(f"the formula '{text}' cannot be read: {error.msg}") from error


def nodes(text: str) -> int:
    """Number of nodes of an expression's tree: quantities, constants, operations."""
    counted = (ast.Constant, ast.Name, ast.BinOp, ast.Call)
    # a function's name is no node beside its call
    return sum(isinstance(n, counted) for n in ast.walk(_parsed(text))) - sum(
        isinstance(n, ast.Call) for n in ast.walk(_parsed(text))
    )


def from_json(row: Mapping[str, Any], where: str) -> tuple[Formula, FloatArray]:
    """Read a row with its parameters as numbers by symbol: the formula and its coefficients (parts,).

    Raises ConfigurationError, which begins with ``where``, for what is wrong with it.
    """
    try:
        over = tuple(str(name) for name in row["over"])
        within = tuple((float(low), float(high)) for low, high in row["within"])
        parts = tuple((str(part.get("times", "1")), str(part["text"])) for part in row["parts"])
        values = {str(symbol): float(value) for symbol, value in row["parameters"].items()}
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise ConfigurationError(
            f"{where}: a formula should have over, within, parts and parameters ({error!r})"
        ) from error
    if len(over) != len(within) or not parts or any(low > high for low, high in within):
        raise ConfigurationError(f"{where}: a formula should have a part, and a range for each of its quantities")
    require_known(over, [times for times, _ in parts], where)
    plain = Formula(over, within, parts)
    missing = [symbol for symbol in plain.coefficients if symbol not in values]
    if missing:
        raise ConfigurationError(f"{where}: the formula has no {', '.join(missing)}, one coefficient for each part")
    constants = tuple((s, v) for s, v in values.items() if s not in plain.coefficients)
    out = Formula(over, within, parts, constants)
    out.parts_at([0.5 * (low + high) for low, high in within])  # says what cannot be read
    return out, np.array([values[symbol] for symbol in plain.coefficients])
