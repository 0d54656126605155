"""Nonlinear parameters of a term, refined between the points of its grid by variable projection.

Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973) 413: for each point everything linear is solved for, and what is
left is minimised by scipy's trust-region least squares. How sure the point is follows from the slope of what is left,
with the linear parts free to make up for it (Kaufman, BIT 15 (1975) 49).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from bench.mismatch.regression.bank import RIDGE, Bank
from bench.mismatch.regression.model import Block
from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.recordings_differ import apart, wider
from bench.mismatch.regression.regressors import Named, Regressor
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import Form

_EVALUATIONS = 25
_SLOPE = 1e-3
"""step, over the parameter or its range, by which slopes are taken"""
_BEYOND = 1.5
"""factor by which a point may leave its grid"""
SMALLEST = 1e-100
"""size of a whitened column below which it counts as none"""


@dataclass(frozen=True, slots=True)
class _Projector:
    """Whitens columns, marginalises the offsets, and takes off what the model's own columns say."""

    bank: Bank
    variance: float
    basis: FloatArray

    def __call__(self, white: FloatArray) -> FloatArray:
        out = self.bank.less_offsets(white, self.variance)
        return np.asarray(out - self.basis @ (self.basis.T @ out)) if self.basis.shape[1] else out


def projector(bank: Bank, blocks: Sequence[Block], variance: float) -> _Projector:
    """Projector off the columns of ``blocks`` for a variance of the offsets."""
    plain = _Projector(bank, variance, np.zeros((bank.y.size, 0)))
    index = [i for b in blocks for i in b.indices]
    if not index:
        return plain
    raw = bank.columns.some(index)
    columns = plain(raw)
    # of a column that the offsets say altogether only rounding is left
    determined = np.sum(columns**2, axis=0) > RIDGE * np.sum(raw**2, axis=0)
    columns = columns[:, determined]
    precision = np.concatenate([b.precision for b in blocks])[determined]
    if not determined.any():
        return plain
    # what the columns leave of the sum of squares is y'(I - B*B')y with B = X*(X'X + P)^(-1/2); a residual whose
    # squares sum up to that is the root of it times y
    energy = np.sum(columns**2, axis=0) + precision
    scale = np.sqrt(np.where(energy > 1e-200, energy, 1.0))
    values, vectors = np.linalg.eigh((columns / scale).T @ (columns / scale) + np.diag(precision / scale**2))
    alive = values > 1e-9 * values.max()
    half = (columns / scale) @ (vectors[:, alive] / np.sqrt(values[alive]))
    squares, eigenvectors = np.linalg.eigh(half.T @ half)
    kept = squares > 1e-12
    squares = np.clip(squares[kept], 0.0, 1.0)
    basis = half @ (eigenvectors[:, kept] / np.sqrt(squares)) * np.sqrt(1.0 - np.sqrt(1.0 - squares))
    return _Projector(bank, variance, basis)


def refined(
    problem: ChannelProblem, bank: Bank, others: Sequence[Block], start: Named, variance: float, tied: bool = False
) -> Named:
    """The term with its nonlinear parameters where they fit best beside ``others``, and their standard deviations; as
    it is where it has none, or where they count something. ``tied``: with the very coefficient of the term it shares it
    with.
    """
    if not start.point or start.form.counts:
        return start
    frame = problem.rows.frame
    course = _Course(problem, start.form, tuple(b for b in others if tied and b.regressor.effect == start.form.shares))
    project = projector(bank, [b for b in others if not any(b is shared for shared in course.shared)], variance)
    target = project(bank.y)
    lower, upper = bounds(start.form, frame)
    positive = bool(np.all(lower > 0))
    first, low, high = (np.log(v) if positive else np.asarray(v) for v in (np.asarray(start.point), lower, upper))
    first = np.clip(first, low + 1e-6 * (high - low), high - 1e-6 * (high - low))

    def left(x: FloatArray) -> FloatArray:
        point = tuple(float(v) for v in (np.exp(x) if positive else x))
        white = project(bank.whitening.apply(course.columns(point)))
        scale = np.sqrt(np.maximum(np.sum(white**2, axis=0), 1e-300))
        white = white / scale
        normal = white.T @ white + 1e-9 * np.eye(white.shape[1])
        return np.asarray(target - white @ np.linalg.solve(normal, white.T @ target))

    found = least_squares(
        left,
        first,
        bounds=(low, high),
        x_scale=np.maximum(0.1 * (high - low), 1e-9),
        diff_step=np.full(first.size, 1e-3),
        max_nfev=_EVALUATIONS,
    )
    better = start
    if 2.0 * found.cost < float(np.sum(left(first) ** 2)):
        better = replace(start, point=tuple(float(v) for v in (np.exp(found.x) if positive else found.x)))
    deviation, carried = _deviation(better, course, project, target)
    return replace(better, deviation=deviation, carried=carried)


@dataclass(frozen=True, slots=True)
class _Course:
    """Columns of a form at the training rows; of one that shares its coefficient with a block, those of both."""

    problem: ChannelProblem
    form: Form
    shared: tuple[Block, ...]

    def columns(self, point: Sequence[float] | FloatArray) -> FloatArray:
        """Columns (n, k) for nonlinear parameters."""
        frame, train = self.problem.rows.frame, self.problem.train
        columns = self.form.columns(frame, tuple(float(v) for v in point))[train]
        for block in self.shared:
            columns = columns + block.regressor.columns(frame)[train]
        return np.where(np.isfinite(columns), columns, 0.0)


def _deviation(
    term: Named, course: _Course, project: _Projector, target: FloatArray
) -> tuple[tuple[float | None, ...], tuple[float, ...]]:
    """Standard deviation of each nonlinear parameter in its own unit, everything linear and the other parameters free;
    and what these give to each coefficient, beside its own where they are known.

    None where one stands at the end of its range, and where the recordings do not tell it within that range.
    """
    lower, upper = bounds(term.form, course.problem.rows.frame)
    point = np.asarray(term.point)
    free = np.flatnonzero(~_at_end(point, lower, upper))

    def white(at: FloatArray) -> FloatArray:
        return project(project.bank.whitening.apply(course.columns(at)))

    columns = white(point)
    columns = columns / np.sqrt(np.maximum(np.sum(columns**2, axis=0), 1e-300))
    inverse = np.linalg.inv(columns.T @ columns + RIDGE * np.eye(columns.shape[1]))
    size = np.sqrt(np.maximum(np.sum(white(point) ** 2, axis=0), 1e-300))
    beta = inverse @ (columns.T @ target) / size
    left = target - columns @ (beta * size)
    slopes, moved = [], []
    for k in free:
        step = np.zeros(point.size)
        step[k] = _SLOPE * (point[k] if lower[k] > 0 else upper[k] - lower[k])
        slope = (white(point + step) - white(point - step)) @ beta / (2.0 * step[k])
        made_up = inverse @ (columns.T @ slope)
        slopes.append(slope - columns @ made_up)
        # a column without energy beside the others has no coefficient that could move
        moved.append(np.where(size > SMALLEST, -made_up / np.maximum(size, SMALLEST), 0.0))
    out: list[float | None] = [None] * point.size
    carried = np.zeros(size.size)
    if free.size:
        jacobian = np.array(slopes).T
        scale = np.maximum(np.sqrt(np.sum(jacobian**2, axis=0)), 1e-300)
        normal = (jacobian / scale).T @ (jacobian / scale)
        joint = np.linalg.inv(normal + RIDGE * np.eye(free.size))
        joint = wider(joint, apart((jacobian / scale) @ joint, left, project.bank.whitening.starts))
        root = np.sqrt(np.maximum(np.diag(joint), 1e-300))
        spread = root / scale
        if free[0] == 0:
            spread[0] = np.hypot(spread[0], term.form.blur * point[0])
        known = spread < (upper - lower)[free]
        for k, value, sure in zip(free, spread, known, strict=True):
            out[int(k)] = float(value) if sure else None
        change = np.array(moved)[known] * spread[known, None]
        together = (joint / np.outer(root, root))[np.ix_(known, known)]
        carried = np.sqrt(np.maximum(np.sum(change * (together @ change), axis=0), 0.0))
    return tuple(out), tuple(float(v) for v in carried)


def bounds(form: Form, frame: Frame) -> tuple[FloatArray, FloatArray]:
    """The range of a form's grid, a little widened, inside the physical bounds of its parameters: beyond it a term
    turns into something else.
    """
    grid = np.asarray(form.grid(frame))
    least, most = np.array([s.lower for s in form.nonlinear]), np.array([s.upper for s in form.nonlinear])
    if grid.size == 0:
        return least, most
    low, high = grid.min(axis=0), grid.max(axis=0)
    margin = 0.1 * (high - low) + 1e-9
    return (
        np.maximum(np.where(low > 0, low / _BEYOND, low - margin), np.minimum(least, low)),
        np.minimum(np.where(low > 0, high * _BEYOND, high + margin), np.maximum(most, high)),
    )


def strained(named: Regressor, frame: Frame) -> bool:
    """Whether a nonlinear parameter stands at the end of its range, where the term turns into something else."""
    if not isinstance(named, Named) or not named.point:
        return False
    return bool(np.any(_at_end(np.asarray(named.point), *bounds(named.form, frame))))


def at_longest(named: Regressor, frame: Frame) -> bool:
    """Whether the first nonlinear parameter, over which a term builds up or decays, stands at the top of its range."""
    if not isinstance(named, Named) or not named.point:
        return False
    lower, upper = bounds(named.form, frame)
    return bool(_at_end(np.asarray(named.point), lower, upper)[0] and named.point[0] > 0.5 * (lower[0] + upper[0]))


def _at_end(point: FloatArray, lower: FloatArray, upper: FloatArray) -> NDArray[np.bool_]:
    """Which parameters stand within a hundredth of an end of their range."""
    room = 0.01 * (upper - lower)
    return np.asarray((point < lower + np.minimum(room, 0.01 * np.abs(lower))) | (point > upper - room))
