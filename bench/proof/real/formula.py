"""Formulas of recorded quantities, as an expert writes them: arithmetic, a few functions, nothing else."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping

import numpy as np

from bench.errors import ConfigurationError
from bench.simulation.frame import FloatArray


def dahl(angle: FloatArray, distance: FloatArray) -> FloatArray:
    """State of Dahl's model (dz = (1 - z*sgn(dx))*dx/s) driven by an angle or a path (n,); begins at 0."""
    out = np.zeros(angle.size)
    shares = np.diff(angle) / float(distance)
    z = 0.0
    for k, share in enumerate(shares.tolist()):
        side = np.sign(share)
        z = side + (z - side) * np.exp(-abs(share))
        out[k + 1] = z
    return out


FUNCTIONS: Mapping[str, Callable[..., FloatArray]] = {
    "abs": np.abs,
    "sign": np.sign,
    "sin": np.sin,
    "cos": np.cos,
    "exp": np.exp,
    "tanh": np.tanh,
    "arctan": np.arctan,
    "sqrt": np.sqrt,
    "log": np.log,
    "maximum": np.maximum,
    "minimum": np.minimum,
    "dahl": dahl,
}
_BINARY: Mapping[type[ast.operator], Callable[[FloatArray, FloatArray], FloatArray]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}


def evaluate(formula: str, quantities: Mapping[str, FloatArray]) -> FloatArray:
    """Values of a formula, of one length with the quantities.

    Raises
    ------
    ConfigurationError
        It is no formula, or names what is not there.
    """
    try:
        tree = ast.parse(formula, mode="eval").body
    except SyntaxError as error:
        raise ConfigurationError(f"'{formula}' is no formula ({error.msg})") from error
    size = next(iter(quantities.values())).size
    return np.broadcast_to(np.asarray(_value(tree, formula, quantities), dtype=np.float64), (size,)).copy()


def _value(node: ast.expr, formula: str, known: Mapping[str, FloatArray]) -> FloatArray:
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return np.asarray(float(node.value))
    if isinstance(node, ast.Name) and node.id in known:
        return known[node.id]
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -_value(node.operand, formula, known)
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return _BINARY[type(node.op)](_value(node.left, formula, known), _value(node.right, formula, known))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS:
        return FUNCTIONS[node.func.id](*(_value(argument, formula, known) for argument in node.args))
    text = ast.unparse(node)
    names = ", ".join([*known, *(f"{name}()" for name in FUNCTIONS)])
    raise ConfigurationError(
        f"'{formula}': '{text}' is not known; a formula is made of numbers, + - * / ** and {names}"
    )
