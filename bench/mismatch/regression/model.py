"""A channel's calibrated simulation with what was found beside it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.recordings.beginning import at_start, risen
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.bank import RIDGE, Bank, Fit, Whitening, fit, likelihood_at
from bench.mismatch.regression.calibration import Calibration
from bench.mismatch.regression.course import added
from bench.mismatch.regression.excess import levelled
from bench.mismatch.regression.noise import (
    Mixture,
    RowNoise,
    alike,
    alike_for,
    of_free_motion,
    of_rows,
    plain_mixture,
)
from bench.mismatch.regression.problem import NUISANCE, BaseTerm, ChannelProblem, starts_and_folds
from bench.mismatch.regression.recordings_differ import NONE, Differences
from bench.mismatch.regression.regressors import UNKNOWN, Free, Regressor
from bench.mismatch.regression.slow_noise import scattered
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.terms import LIBRARY

WEAK = 1e-6
"""relative to a column's mean energy: prior of free functions, where a design leaves a value of them undetermined"""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """A regressor in a bank: numbers of its columns, prior precision of its coefficients (k,)."""

    regressor: Regressor
    indices: tuple[int, ...]
    precision: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Chosen:
    """An effect in a model, with the correction of its shape where it has one."""

    main: Block
    shape: Block | None = None

    @property
    def effect(self) -> str:
        """Id of the vocabulary."""
        return self.main.regressor.effect

    @property
    def nominal(self) -> bool:
        """Whether it is a term of the nominal simulation."""
        return self.effect in LIBRARY and LIBRARY[self.effect].nominal

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Its blocks."""
        return (self.main,) if self.shape is None else (self.main, self.shape)


@dataclass(slots=True)
class ChannelModel:
    """A channel's model: the simulation's blocks, then what was chosen, fitted together on the training rows."""

    problem: ChannelProblem
    bank: Bank
    samples: Mixture
    noise: RowNoise
    base: list[Block]
    chosen: list[Chosen]
    fit: Fit
    variances: tuple[float, ...]
    folds: IntArray
    calibration: Calibration
    price: float = 0.0
    notes: list[str] = field(default_factory=list)
    differences: Differences = NONE
    """how far recordings are apart beside all effects of the model, as they were last compared"""
    moved: Mapping[int, float] = field(default_factory=dict)
    """by how much another channel says that coefficients are other than this one does, by their columns"""

    @property
    def channel(self) -> str:
        """Name of the channel."""
        return self.problem.channel

    @property
    def floor(self) -> float:
        """Noise of a single sample, free of the model."""
        if self.problem.spec.integral:
            return scattered(self.problem)[0]
        return float(np.sqrt(self.samples.variance))

    def blocks(self, chosen: Sequence[Chosen] | None = None) -> list[Block]:
        """Blocks of a model: the simulation's and those of what is chosen (default: the model's own)."""
        return [*self.base, *(b for c in (self.chosen if chosen is None else chosen) for b in c.blocks)]

    def refitted(self, chosen: Sequence[Chosen]) -> Fit:
        """Fit the simulation with some effects to what the channel tells, moved by what another one says: effects that
        do not have all columns that were moved follow that as well as they can.
        """
        blocks = self.blocks(chosen)
        found = fit_blocks(self.bank, blocks, self.variances)
        if not self.moved:
            return found
        own = list(found.index)
        missing = [i for i in self.moved if i not in own]
        moves = np.array([self.moved.get(i, 0.0) for i in own])
        if missing:
            gram = self.bank.normal([*own, *missing], found.variance).gram
            within = gram[: len(own), : len(own)]
            within = within + np.diag(np.concatenate([b.precision for b in blocks]) + RIDGE * np.diag(within))
            beyond = gram[: len(own), len(own) :] @ np.array([self.moved[i] for i in missing])
            moves = moves + np.linalg.solve(within, beyond)
        return replace(found, coefficients=found.coefficients + moves)

    def by_itself(self) -> ChannelModel:
        """The model as its channel alone tells it."""
        alone = replace(self, moved={})
        return replace(alone, fit=alone.refitted(self.chosen)) if self.moved else self

    def contribution(self, chosen: Chosen, frame: Frame, fitted: Fit | None = None) -> FloatArray:
        """What an effect adds at the rows of a frame (n,)."""
        return sum_of_blocks(chosen.blocks, self.fit if fitted is None else fitted, frame)

    @property
    def calibrated(self) -> tuple[Regressor, ...]:
        """The simulation's terms; zeros of sensors are none of them."""
        return tuple(b.regressor for b in self.base if b.regressor.effect != NUISANCE)

    @property
    def nameless(self) -> tuple[Chosen, ...]:
        """Effects without a name."""
        return tuple(chosen for chosen in self.chosen if chosen.effect == UNKNOWN)

    def sum_of(self, effects: Sequence[Chosen], frame: Frame) -> FloatArray:
        """What some effects add together at the rows of a frame (n,)."""
        return sum((self.contribution(effect, frame) for effect in effects), np.zeros(frame.size))

    def compare_recordings(self) -> None:
        """Take up how far recordings are apart beside the effects as they are now; the bank still holds the columns."""
        self.differences = Differences.of(self.bank, self.fit)

    def covariance(self, columns: Sequence[int], fitted: Fit | None = None) -> FloatArray:
        """Covariance (k, k) of the coefficients of some columns, by the noise of rows and, where that makes them less
        sure, by the differences of recordings beside all effects of the model. In another fit these make each as many
        times less sure as in the model's own.
        """
        own = self.fit.of(columns)[1]
        told = self.differences.widened(columns, own)
        if fitted is None or fitted is self.fit:
            return told
        factors = np.sqrt(np.diag(told) / np.maximum(np.diag(own), 1e-300))
        return np.asarray(fitted.of(columns)[1] * np.outer(factors, factors))

    def std(self, columns: Sequence[int], fitted: Fit | None = None) -> FloatArray:
        """Standard deviations (k,) of these coefficients."""
        return np.asarray(np.sqrt(np.maximum(np.diag(self.covariance(columns, fitted)), 0.0)))

    def predict(self, frame: Frame, chosen: Sequence[Chosen] | None = None, fitted: Fit | None = None) -> FloatArray:
        """The channel, less what is fixed, as the model says on the rows of a frame (n,)."""
        return predicted(self.blocks(chosen), self.fit if fitted is None else fitted, frame)


def calibration(problem: ChannelProblem, base: Sequence[Block], noise: RowNoise) -> Calibration:
    """What the simulation's blocks can say; zeros of sensors are none of it."""
    base = [b for b in base if b.regressor.effect != NUISANCE]
    precision = np.concatenate([np.zeros(0), *(b.precision for b in base)])
    return Calibration.of(problem, [b.regressor for b in base], precision, noise.sigma)


def explained(model: ChannelModel) -> FloatArray:
    """What a model says of its own rows (n,), with what stands for errors of sensors and of the calibration; of an
    integral without, for its zeros are levels that each recording begins with.
    """
    frame, out = model.problem.rows.frame, model.predict(model.problem.rows.frame)
    if model.problem.spec.integral:
        return out
    for block in model.blocks():
        if block.regressor.effect == NUISANCE:
            out += added(block.regressor, frame, model.fit.of(block.indices)[0])
    return out


def sum_of_blocks(blocks: Iterable[Block], fitted: Fit, frame: Frame) -> FloatArray:
    """What fitted blocks add together at the rows of a frame (n,)."""
    out = np.zeros(frame.size)
    for block in blocks:
        out += added(block.regressor, frame, fitted.of(block.indices)[0])
    return out


def predicted(blocks: Sequence[Block], fitted: Fit, frame: Frame) -> FloatArray:
    """What fitted blocks say on the rows of a frame (n,), but for those that are no part of a simulation."""
    return sum_of_blocks((b for b in blocks if b.regressor.effect != NUISANCE), fitted, frame)


def of_start(problem: ChannelProblem, prediction: FloatArray) -> FloatArray:
    """A prediction (n,) of an integral with the level of each recording's first readings; others as they are."""
    if not problem.spec.integral:
        return prediction
    frame = problem.rows.frame
    return np.asarray(prediction + risen(frame, at_start(frame, problem.rows.y) - at_start(frame, prediction)))


def fit_blocks(bank: Bank, blocks: Sequence[Block], variances: Sequence[float]) -> Fit:
    """Fit blocks of columns together.

    Where nothing but the residual tells the noise (free motion), what the blocks cannot say at starts and reversals
    would set friction, and offsets of any size take the difference: none is larger than the recordings' means allow.
    """
    index = [i for b in blocks for i in b.indices]
    if bank.whitening.noise.independent_rows is not None:
        calibrated = [i for b in blocks if not kept_small(b) for i in b.indices]
        variances = bank.ruled_in(variances, calibrated, criteria.ERROR_RATE_OF_A_CHANNEL)
    precision = np.concatenate([b.precision for b in blocks]) if blocks else np.zeros(0)
    return fit(bank, index, variances, precision)


def likelihood_of(bank: Bank, blocks: Sequence[Block], variance: float) -> float:
    """Log-likelihood of blocks of columns together, for one variance of the recordings' offsets."""
    return likelihood_at(
        bank, [i for b in blocks for i in b.indices], variance, np.concatenate([b.precision for b in blocks])
    )


def prepare_bank(
    problem: ChannelProblem, residual: FloatArray, wider: float = 1.0
) -> tuple[Bank, Mixture, RowNoise, IntArray]:
    """Whiten a problem's training rows by the noise that a ``residual`` (training rows,) shows, so many times
    ``wider``.
    """
    train = problem.train
    rows = problem.rows.take(train)
    starts, folds = starts_and_folds(rows.frame, problem.folds)
    samples = problem.noise or plain_mixture(rows, residual, problem.spec.integral)
    doubt = None if problem.doubt is None else problem.doubt[train]
    unheard = problem.noise is None and problem.doubt is None and not problem.spec.integral
    if problem.free:
        samples = samples.at_most(_of_a_sample(rows, residual)) if unheard else samples
        noise = of_free_motion(rows, residual)
    else:
        noise = alike(rows, residual) if unheard else of_rows(rows, samples, residual, doubt)
    noise = replace(noise, sigma=wider * noise.sigma)
    return Bank(rows.y, Whitening(noise, starts), problem.spec.integral), samples, noise, folds


def _of_a_sample(rows: Rows, residual: FloatArray) -> float:
    """Mean square of what a model leaves of a sample: of the rows, and within them. Noise is no more."""
    within = float(np.average(rows.within, weights=rows.number)) if rows.within.size else np.inf
    return within + float(np.average(residual**2, weights=np.maximum(rows.number, 1e-9)))


def widened(bank: Bank, blocks: Sequence[Block], fitted: Fit) -> float:
    """How many times as wide as they are the rows' noise has to be taken for a calibration that the recordings' means
    contradict, so that a row counts for what it says: its residual is as large as its noise, and rows whose residuals
    are alike are one reading (effective number of observations). 1 where the means do not contradict it.
    """
    index = [i for b in blocks for i in b.indices]
    calibrated = [i for b in blocks if not kept_small(b) for i in b.indices]
    if not bank.contradicted(calibrated, fitted.of(calibrated)[0], criteria.ERROR_RATE_OF_A_CHANNEL):
        return 1.0
    left = bank.about_levels(bank.residual(index, fitted.coefficients))
    return float(np.sqrt(max(float(np.mean(left**2)) * alike_for(left, bank.whitening.starts), 1.0)))


def kept_small(part: Block | BaseTerm) -> bool:
    """Whether a part of a model stands for what sensors or a calibration may be wrong by, and a prior keeps it small:
    it is no part of what the recordings' means are compared with.
    """
    return part.regressor.effect == NUISANCE and bool(np.any(part.precision))


def left_by(model: ChannelModel) -> FloatArray:
    """What a model leaves of the training rows (n,), less the mean of each recording."""
    problem = model.problem
    rows = problem.rows.take(problem.train)
    return levelled(rows.y - model.predict(problem.rows.frame)[problem.train], rows.frame, rows.number)


def plain_residual(problem: ChannelProblem) -> FloatArray:
    """Residual (training rows,) of the simulation fitted by plain weighted least squares, an offset a recording
    free.
    """
    train = problem.train
    rows = problem.rows.take(train)
    terms = [t for t in problem.base if not kept_small(t)]
    blocks = [t.regressor.columns(problem.rows.frame)[train] for t in terms]
    columns = np.hstack(blocks) if blocks else np.zeros((rows.size, 0))
    weight = np.maximum(rows.number, 0.0)
    y = levelled(rows.y, rows.frame, weight)
    if columns.shape[1] == 0:
        return y
    scale = np.maximum(np.sqrt(np.mean(columns**2, axis=0)), 1e-300)
    inner = levelled(columns / scale, rows.frame, weight)
    left = inner * np.sqrt(weight)[:, None]
    normal = left.T @ left
    # columns that are constant in each recording have nothing of their own: at one speed friction is an offset
    normal[np.diag_indices_from(normal)] += 1e-6 * max(float(np.trace(normal)) / left.shape[1], 1e-9 * weight.sum())
    return np.asarray(y - inner @ np.linalg.solve(normal, left.T @ (np.sqrt(weight) * y)))


def add_base(problem: ChannelProblem, bank: Bank) -> list[Block]:
    """Put the simulation's regressors into a bank."""
    train = problem.train
    out = []
    for term in problem.base:
        columns = term.regressor.columns(problem.rows.frame)[train]
        indices = bank.add(columns)
        out.append(Block(term.regressor, indices, term.precisions(len(indices))))
    return out


def add_block(problem: ChannelProblem, bank: Bank, regressor: Regressor, precision: float = 0.0) -> Block:
    """Put a regressor into a bank."""
    indices = bank.add(regressor.columns(problem.rows.frame)[problem.train])
    if precision == 0.0 and isinstance(regressor, Free):
        precision = weak_precision(bank, indices)
    return Block(regressor, indices, np.full(len(indices), precision))


def weak_precision(bank: Bank, indices: Sequence[int]) -> float:
    """Prior precision of a free function's values that only keeps undetermined ones from running away."""
    return WEAK * float(np.mean([np.sum(bank.columns.column(i) ** 2) for i in indices]))


def unrefined(bank: Bank, block: Block) -> Chosen:
    """A candidate as it stands in the bank: a prior only where a design leaves a coefficient undetermined."""
    return Chosen(replace(block, precision=np.full(len(block.indices), weak_precision(bank, block.indices))))


def with_shape(problem: ChannelProblem, bank: Bank, main: Block, shape: Free | None, size: float) -> Chosen:
    """An effect with the correction of its shape: a function whose values are drawn with standard deviation
    ``size``.
    """
    if shape is None or size <= 0.0:
        return Chosen(main)
    block = add_block(problem, bank, shape, 1.0 / size**2)
    return Chosen(main, block)
