"""Shapes of short formulas that follow a table: symbolic regression by Operon.

B. Burlacu, G. Kronberger, M. Kommenda, Operon C++: an efficient genetic programming framework for symbolic regression,
GECCO 2020, by its Python package. Shapes only: constants are fitted, and everything is judged, where the search judges.
"""

from __future__ import annotations

import importlib.util
import warnings

import numpy as np

from bench.mismatch.unnamed import formula_algebra as algebra
from bench.simulation.frame import FloatArray

CELLS = 160
"""means of neighbouring rows through which shapes are looked for"""
LENGTH = 14
"""nodes of the longest tree"""
POPULATION, GENERATIONS, TUNED = 200, 50, 3
"""trees in a generation, generations, steps by which each tree's numbers are improved"""
SYMBOLS = "add,sub,mul,div,exp,tanh,sin,square,abs,constant,variable"
MOST_SHAPES = 10
WAVES = (2.0, 4.0, 8.0)
"""rad over the range of a quantity, from which a wave's fit begins"""


def available() -> bool:
    """Whether Operon is installed."""
    return importlib.util.find_spec("pyoperon") is not None


def straight(number: int) -> list[algebra.Sum]:
    """The shape of a straight line over each of ``number`` quantities."""
    line: algebra.Sum = {algebra.ONE: 1.0}
    for i in range(number):
        line = algebra.plus(line, algebra.quantity(i))
    return [line]


def elementary() -> list[algebra.Sum]:
    """Laws of one quantity that physics is full of, each beside a straight line: powers, saturation, decay, a
    hyperbola, a peak, a wave; what rises to a largest value and falls again, as the torque of an eddy-current brake
    over its speed (Kloss) and a loss over frequency (Debye). Constants begin at the middle of the range.
    """
    x, line = algebra.quantity(0), straight(1)[0]
    third = algebra.times({algebra.ONE: 3.0}, x)
    made = [
        algebra.times(x, x),
        algebra.times(x, algebra.times(x, x)),
        algebra.function("exp", algebra.times({algebra.ONE: -1.0}, third)),
        algebra.function("tanh", third),
        algebra.function("inv", algebra.plus({algebra.ONE: 1.0}, third)),
    ]
    square = algebra.times({algebra.ONE: 9.0}, algebra.times(x, x))
    made.append(algebra.times(x, algebra.function("inv", algebra.plus({algebra.ONE: 1.0}, square))))
    peak = algebra.plus(algebra.times({algebra.ONE: -9.0}, algebra.times(x, x)), algebra.times({algebra.ONE: 9.0}, x))
    made.append(algebra.function("exp", peak))
    made += [
        algebra.function("sin", algebra.plus({algebra.ONE: 0.5}, algebra.times({algebra.ONE: k}, x))) for k in WAVES
    ]
    return [algebra.plus(line, shape) for shape in made]


def shapes(values: FloatArray, target: FloatArray, weight: FloatArray, seed: int) -> list[algebra.Sum]:
    """Shapes that follow a ``target`` (n,) of quantities (n, q) of the order of one, the shortest first.

    ``weight`` (n,): of each row. The same numbers give the same shapes.
    """
    x, y = cells(values, target, weight)
    spread = float(np.std(y))
    if spread <= 0.0 or y.size < 3 * LENGTH:
        return []
    from pyoperon.sklearn import SymbolicRegressor

    found = SymbolicRegressor(
        allowed_symbols=SYMBOLS,
        objectives=["r2", "length"],
        max_length=LENGTH,
        max_depth=6,
        population_size=POPULATION,
        generations=GENERATIONS,
        max_evaluations=POPULATION * GENERATIONS * 50,
        optimizer_iterations=TUNED,
        tournament_size=3,
        n_threads=1,
        random_state=seed + 1,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found.fit(x, y / spread)
    positive = frozenset(np.flatnonzero(values.min(axis=0) >= 0.0).tolist())
    front = sorted(found.pareto_front_, key=lambda one: float(one["objective_values"][1]))
    out: dict[tuple[object, ...], algebra.Sum] = {}
    for one in front:
        try:
            shape = algebra.parsed(found.get_model_string(one["tree"], 10), positive)
        except (algebra.TooLong, OverflowError, ZeroDivisionError):
            continue
        key = algebra.structure(shape)
        if key:
            out.setdefault(key, shape)
    found_ones = list(out.values())[:MOST_SHAPES]
    return found_ones + (elementary() if values.shape[1] == 1 else [])


def cells(values: FloatArray, target: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weighted means (cells, q) and (cells,) of rows that lie close together, cut in halves along each quantity in
    turn.
    """
    kept = (weight > 0.0) & np.isfinite(values).all(axis=1) & np.isfinite(target)
    x, y, w = values[kept], target[kept], weight[kept]
    groups = [np.arange(y.size)]
    axis = 0
    while groups and 2 * len(groups) <= CELLS and min(g.size for g in groups) >= 4:
        halves = []
        for cell in groups:
            order = cell[np.argsort(x[cell, axis % x.shape[1]], kind="stable")]
            middle = int(np.searchsorted(np.cumsum(w[order]), 0.5 * w[order].sum())) + 1
            middle = min(max(middle, 1), order.size - 1)
            halves += [order[:middle], order[middle:]]
        groups, axis = halves, axis + 1
    if y.size == 0:
        return x, y
    share = [w[g] / w[g].sum() for g in groups]
    return (
        np.array([s @ x[g] for g, s in zip(groups, share, strict=True)]),
        np.array([s @ y[g] for g, s in zip(groups, share, strict=True)]),
    )
