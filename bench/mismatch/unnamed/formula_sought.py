"""Formulas to be tried in the place of a free function: proposed shapes with the quantities and units of a channel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from bench.mismatch.regression.model import ChannelModel, Chosen
from bench.mismatch.regression.regressors import Free
from bench.mismatch.unnamed import formula_proposed as proposed
from bench.mismatch.unnamed.formula_algebra import Sum
from bench.mismatch.unnamed.formula_parts import Constant, Quantities, parts_of
from bench.mismatch.unnamed.formula_regressor import PLAIN, Equation
from bench.mismatch.unnamed.formula_units import product, unit_of
from bench.simulation.formulas import Formula
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import factor, quantity
from bench.simulation.reading import unit_of_function
from bench.simulation.tables import Grid
from bench.simulation.terms import CHANNEL_UNITS, TEMPERATURE

STRAIGHT = 2
"""knots of a straight line"""
FACTOR_UNITS = {"w": "rad/s", "motor_torque": "N*m"}
"""factors that carry a unit; all others are of the order of one"""


def sought(
    model: ChannelModel, chosen: Chosen, free: Free, auxiliary: Mapping[str, str], seed: int
) -> Iterator[Equation]:
    """Formulas of what ``free`` is a function of, the shortest first, with constants to begin a fit with."""
    shapes = [_shapes(model, chosen, free, k, seed) for k in range(len(free.grids))]
    if any(not of_one for of_one in shapes):
        return
    # the parts of a function that differ by direction have shapes of like length
    for rank in range(max(len(of_one) for of_one in shapes)):
        yield _assembled(model, free, [of_one[min(rank, len(of_one) - 1)] for of_one in shapes], auxiliary)


def _plain(name: str) -> str:
    return PLAIN.get(name, name)


def _values(model: ChannelModel, grid: Grid) -> tuple[FloatArray, FloatArray]:
    """The quantities of a grid on the training rows (n, q), divided by their largest size; and that (q,)."""
    problem = model.problem
    raw = np.column_stack([quantity(_plain(name), problem.rows.frame)[problem.train] for name in grid.over])
    scale = np.abs(raw).max(axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    return raw / scale, scale


def _shapes(model: ChannelModel, chosen: Chosen, free: Free, number: int, seed: int) -> list[Sum]:
    """Shapes for one grid of a free function: of what the grid says and all that the model leaves."""
    grid = free.grids[number]
    if all(len(knots) == STRAIGHT for knots in grid.knots):
        return proposed.straight(len(grid.over))
    problem = model.problem
    frame, train = problem.rows.frame, problem.train
    before = sum(g.size for g in free.grids[:number])
    coefficients = free.values(model.fit.of(chosen.main.indices)[0])[before : before + grid.size]
    times = factor(grid.times, frame)[train]
    course = Grid(grid.over, "1", grid.knots).columns(frame)[train] @ coefficients
    values = _values(model, grid)[0]
    if problem.spec.integral:  # what is left is no rate
        return proposed.shapes(values, course, times**2, seed)
    weight = 1.0 / model.noise.sigma**2
    left = problem.rows.y[train] - model.predict(frame)[train]
    recording = frame.recording[train]
    sums = np.bincount(recording, weight)
    offset = np.bincount(recording, weight * left) / np.where(sums > 0.0, sums, 1.0)
    # each recording's own offset, as far as the model believes in one
    share = 1.0 if np.isinf(model.fit.variance) else model.fit.variance * sums / (1.0 + model.fit.variance * sums)
    left = left - (share * offset)[recording]
    acts = np.abs(times) > 1e-6 * np.abs(times).max(initial=0.0)
    target = course + np.where(acts, left / np.where(acts, times, 1.0), 0.0)
    return proposed.shapes(values, target, np.where(acts, weight * times**2, 0.0), seed)


def _assembled(model: ChannelModel, free: Free, sums: Sequence[Sum], auxiliary: Mapping[str, str]) -> Equation:
    problem = model.problem
    over = list(dict.fromkeys(_plain(name) for grid in free.grids for name in grid.over))
    parts: list[tuple[str, str]] = []
    units: list[str] = []
    constants: list[Constant] = []
    for grid, shape in zip(free.grids, sums, strict=True):
        names = [_plain(name) for name in grid.over]
        of = Quantities(
            [f"x{over.index(name) + 1}" for name in names],
            list(_values(model, grid)[1]),
            [unit_of(name, auxiliary) for name in names],
        )
        found = parts_of(shape, of, len(constants))
        constants += found.constants
        channel = unit_of_function(grid.times) if free.channel == TEMPERATURE else CHANNEL_UNITS[free.channel]
        times = [(FACTOR_UNITS.get(part, "1"), -1) for part in grid.times.split("*")]
        for text, unit in zip(found.texts, found.units, strict=True):
            parts.append((grid.times, text))
            units.append(product([(channel, 1), (unit, -1), *times]))
    within = []
    for name in over:
        values = quantity(name, problem.rows.frame)[problem.train]
        within.append((float(values.min()), float(values.max())))
    formula = Formula(tuple(over), tuple(within), tuple(parts), tuple((c.symbol, c.value) for c in constants))
    return Equation(free.channel, formula, tuple(units), tuple(constants))
