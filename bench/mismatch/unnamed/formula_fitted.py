"""Constants of a formula where they fit best beside the simulation, by variable projection; whether it has poles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares

from bench.mismatch.regression.bank import Bank
from bench.mismatch.regression.model import Block
from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.refine import projector
from bench.mismatch.regression.regressors import remembers
from bench.mismatch.unnamed.formula_regressor import Equation
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import quantity

EVALUATIONS = 20
FARTHEST = np.log(30.0)
"""by how much a scale may leave its proposal, as a logarithm"""
SHIFT = 5.0
"""by how much a number without a unit may"""
DOUBT = 1.0
"""standard deviation of a scale's logarithm above which the recordings do not tell it"""
POLE = 3.0
"""times its largest value on the rows that a part may reach between them"""
LOOKS = 2000
LARGEST = 1e100
"""what a part may come to on the way of a fit; beyond it, it is nothing"""


def tuned(problem: ChannelProblem, bank: Bank, beside: Sequence[Block], start: Equation, variance: float) -> Equation:
    """The formula with its constants where they fit best beside other blocks, each with its standard deviation; that
    is None where the recordings do not tell it.
    """
    if not start.constants:
        return start
    frame, train = problem.rows.frame, problem.train
    # an integral, and a quantity that remembers, run through all rows
    whole = problem.spec.integral or remembers(start)
    rows = frame if whole else frame.take(train)
    project = projector(bank, beside, variance)
    target = project(bank.y)
    positive = np.array([c.positive for c in start.constants])
    value = np.array([c.value for c in start.constants])
    size = np.array([c.size for c in start.constants])
    first = np.where(positive, np.log(np.where(positive, value, 1.0)), value / size)

    def left(x: FloatArray) -> FloatArray:
        formula = start.with_values(np.where(positive, np.exp(x), size * x))
        columns = formula.columns(rows)
        columns = columns[train] if whole else columns
        white = project(bank.whitening.apply(np.where(np.abs(columns) < LARGEST, columns, 0.0)))
        scale = np.sqrt(np.maximum(np.sum(white**2, axis=0), 1e-300))
        white = white / scale
        normal = white.T @ white + 1e-9 * np.eye(white.shape[1])
        return np.asarray(target - white @ np.linalg.solve(normal, white.T @ target))

    room = np.where(positive, FARTHEST, SHIFT)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        found = least_squares(
            left,
            first,
            bounds=(first - room, first + room),
            diff_step=np.full(first.size, 1e-3),
            max_nfev=EVALUATIONS,
            x_scale=0.3,
        )
    jacobian = np.asarray(found.jac)
    normal = jacobian.T @ jacobian
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    spread = np.sqrt(
        np.maximum(np.diag(np.linalg.inv(normal / np.outer(scale, scale) + 1e-9 * np.eye(scale.size))), 0.0)
    )
    doubt = spread / scale
    value = np.where(positive, np.exp(found.x), size * found.x)
    std = tuple(
        float(d * (v if p else s)) if d < DOUBT else None
        for v, d, p, s in zip(value, doubt, positive, size, strict=True)
    )
    return start.with_values(value, std)


def bounded(problem: ChannelProblem, equation: Equation) -> bool:
    """Whether the parts of a formula are finite numbers everywhere between what was recorded, not only on the rows."""
    formula = equation.formula
    low, high = (np.array(ends) for ends in zip(*formula.within, strict=True))
    share = np.random.default_rng(0).random((LOOKS, low.size))
    share[: 2 * low.size] = np.round(share[: 2 * low.size])  # corners, too
    if low.size == 1:
        share = np.linspace(0.0, 1.0, LOOKS)[:, None]
    points = low + share * (high - low)
    with np.errstate(all="ignore"):
        between = [np.broadcast_to(v, (LOOKS,)) for v in formula.parts_at(list(points.T))]
        rows = equation.columns(problem.rows.frame)
    plain = formula.parts_at([_on_rows(problem, name) for name in formula.over])
    sizes = [float(np.max(np.abs(v))) for v in plain]
    fine = all(
        np.isfinite(v).all() and np.abs(v).max() <= POLE * max(s, 1e-300) for v, s in zip(between, sizes, strict=True)
    )
    return bool(fine and np.isfinite(rows).all())


def _on_rows(problem: ChannelProblem, name: str) -> FloatArray:
    return quantity(name, problem.rows.frame)[problem.train]
