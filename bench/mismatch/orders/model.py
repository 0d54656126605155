"""The transmission error's model: what is periodic in the angle, and the offset, found in turns."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.orders import offset_rows as slow
from bench.mismatch.orders.between import search_between
from bench.mismatch.orders.bounds import Bounds
from bench.mismatch.orders.corner import cornered
from bench.mismatch.orders.hidden import unhide
from bench.mismatch.orders.joint import SETTLINGS, Evidence, settled
from bench.mismatch.orders.misread import TorqueCheck
from bench.mismatch.orders.partial import refined
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.orders.revolutions import (
    LEAST_PART,
    SHORTEST_REVOLUTION,
    Complex,
    Revolution,
    Seen,
    found_in,
    looks,
    passed,
    seen,
)
from bench.mismatch.orders.ringing import ringing, rings_for
from bench.mismatch.orders.series import Series, calibrate
from bench.mismatch.orders.unsure import Unsure, angle_of_rows, unsure
from bench.mismatch.orders.weak import Stage, WeakOrder, search
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.course import added
from bench.mismatch.regression.excess import excess
from bench.mismatch.regression.maxima import tail
from bench.mismatch.regression.model import plain_residual, predicted, sum_of_blocks, widened
from bench.mismatch.regression.noise import Mixture, durations, usual_rate
from bench.mismatch.regression.prior import calibrated_alone
from bench.mismatch.regression.problem import BaseTerm, ChannelProblem
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.laws import Law
from bench.simulation.terms import TRANSMISSION_ERROR

ROUNDS = 24
FEWEST_CALIBRATED = 2
"""steady revolutions that may be fitted from which the series is calibrated; its prior and the steady parts of less
than a revolution say the rest"""
LEARNINGS = 3
"""times that the series learns from the offset's rows, which are searched anew, as long as it still does"""
LEARNT = 0.5
"""size of what the offset's rows move the series by, over their noise, below which it is not searched again"""
FOLLOWED = 2.0
"""variance of what a plain model leaves of an order's vectors, over the noise's, from which the order gets
polynomials of its own"""


@dataclass(frozen=True, slots=True)
class Given:
    """What the given simulation has of the transmission error: orders of its series, the ripple's, laws of the
    series.
    """

    orders: tuple[float, ...]
    notch: tuple[float, ...] = ()
    laws: tuple[Law, ...] = ()


@dataclass(frozen=True, slots=True)
class KnownOffset:
    """The offset of the rows as an earlier search has it: its ``values`` (n,), rad, whether functions of ``states``
    that are not recorded were candidates, and by what energy inside revolutions it ``moved`` from what was taken off
    before, in squares of the samples' noise.
    """

    values: FloatArray
    states: bool
    moved: float


@dataclass(slots=True)
class TransmissionModel:
    """The transmission error's model on the rows over the angle."""

    rows: Rows
    inside: NDArray[np.bool_]
    revolutions: list[Revolution]
    train: NDArray[np.bool_]
    """which revolutions may be fitted"""
    given: Given
    folds: IntArray
    base: tuple[BaseTerm, ...]
    switched_off: tuple[str, ...] = ()
    banned: tuple[str, ...] = ()
    """effects that are no candidates for the offset"""
    periodic: Periodic | None = None
    plain: Series | None = None
    """the given orders alone"""
    seen: Seen | None = None
    noise: Mixture | None = None
    price: float | None = None
    """gain that an order reaches in noise"""
    nulls: FloatArray | None = field(default=None, repr=False)
    """what the best of all orders gains in surrogates"""
    offset: Search | None = None
    quiet: FloatArray | None = field(default=None, repr=False)
    """the rows without their offset (n,): what the orders were found in"""
    tone: FloatArray | None = field(default=None, repr=False)
    """a disturbance of one frequency on the rows (n,), rad, that is no order"""
    known: KnownOffset | None = field(default=None, repr=False)
    """the offset as an earlier search has it; None: as the simulation alone has it"""
    parts: tuple[Revolution, ...] = ()
    """steady parts of less than a revolution that may be fitted"""
    notes: list[str] = field(default_factory=list)
    laws: tuple[Law, ...] = ()
    """found strong, so that everything else is calibrated under them"""
    torque_check: TorqueCheck = field(default_factory=TorqueCheck)
    """whose the multiples of the ratio are, by the load's reaction"""

    @property
    def training_revolutions(self) -> list[Revolution]:
        """Turns that may be fitted."""
        return [t for t, chosen in zip(self.revolutions, self.train, strict=True) if chosen]

    def restore(self, before: TransmissionModel) -> None:
        """Hold again what a copy holds that was made ``before``."""
        for item in fields(self):
            setattr(self, item.name, getattr(before, item.name))

    @property
    def without_offset(self) -> FloatArray:
        """The rows (n,) less their offset and a tone, as far as these are known: what orders are found in."""
        return self.toneless if self.quiet is None else self.quiet

    @property
    def toneless(self) -> FloatArray:
        """The rows (n,) less a tone, if there is one."""
        return self.rows.y if self.tone is None else self.rows.y - self.tone

    @property
    def given_orders(self) -> FloatArray:
        """What the orders of the simulation add at the rows (n,), as calibrated."""
        if self.plain is None:
            return np.zeros(self.rows.size)
        return Periodic(self.plain, laws=self.given.laws).evaluate(self.rows.frame)

    @property
    def compared(self) -> FloatArray:
        """Samples of each row (n,) that are compared."""
        return np.where(self.inside, self.rows.number, 0.0)

    @property
    def recorded(self) -> FloatArray:
        """Samples of each row (n,), those that are not compared with them: at rest the shafts have a transmission error
        as well. None of a recording in which nothing is compared, such as one that never turns.
        """
        number, recording = self.rows.number, self.rows.frame.recording
        compared = np.bincount(recording, self.compared) > 0.0
        return np.where(compared[recording], number, 0.0)


def begun(
    rows: Rows,
    folds: IntArray,
    given: Given,
    base: Sequence[BaseTerm],
    switched_off: Sequence[str] = (),
    banned: Sequence[str] = (),
) -> TransmissionModel:
    """A model with nothing calibrated yet."""
    revolutions = found_in(rows.frame)
    inside = (rows.number > 0) & (rows.frame.direction != 0)
    bounds = Bounds.of([t.velocity for t in revolutions])
    if bounds is not None:
        inside &= bounds.inside(rows.frame)
    train = np.array([folds[t.recording] >= 0 for t in revolutions], dtype=bool)
    parts = tuple(
        p
        for p in found_in(rows.frame, LEAST_PART, SHORTEST_REVOLUTION)
        if folds[p.recording] >= 0 and bool(inside[p.rows].all()) and bool((rows.number[p.rows] > 0).all())
    )
    return TransmissionModel(
        rows, inside, revolutions, train, given, folds, tuple(base), tuple(switched_off), tuple(banned), parts=parts
    )


def analyse(model: TransmissionModel, seed: int) -> TransmissionModel:
    """Find what the transmission error's simulation lacks."""
    if int(model.train.sum()) >= FEWEST_CALIBRATED:
        if model.known is None:
            _orders(model, model.without_offset - _wavering(model, model.rows.y), seed)
        model.quiet = model.without_offset - level_of(model)
        _orders(model, model.quiet, seed)
    offset_anew(model, seed)
    return model


def level_of(model: TransmissionModel) -> FloatArray:
    """The offset of the rows (n,): as an earlier search has it, else the simulation's beside what is periodic."""
    if model.known is not None:
        return model.known.values
    assert model.periodic is not None
    return _offset_alone(model, model.rows.y - model.periodic.evaluate(model.rows.frame))


def misleading(model: TransmissionModel) -> KnownOffset | None:
    """The offset of a model, if it differs inside revolutions from what was taken off the rows before the orders were
    looked for, by more than an order has to gain; None where it does not.

    What goes on inside a revolution, such as a play that a torque crosses slowly, is otherwise read as orders.
    """
    if model.offset is None or model.quiet is None or model.price is None:
        return None
    offset, frame = model.offset.model, model.rows.frame
    # what the series may be wrong by is no part of the offset
    blocks = (b for b in offset.blocks() if not isinstance(b.regressor, Unsure))
    values = sum_of_blocks(blocks, offset.fit, frame)
    more = values - (model.toneless - model.quiet)
    energy = 0.0
    for revolution in model.training_revolutions:
        number, angle = model.rows.number[revolution.rows], frame.theta[revolution.rows]
        # a level and a drift are fitted in each revolution beside the orders
        line = np.column_stack([np.ones(angle.size), angle - np.mean(angle)])
        energy += float(number @ excess(more[revolution.rows], [line], number) ** 2)
    moved = energy / _floor(model) ** 2
    return KnownOffset(values, offset.problem.states, moved) if 0.5 * moved > model.price else None


def offset_anew(model: TransmissionModel, seed: int) -> None:
    """Search what the model's periodic part leaves for what the offset lacks."""
    periodic = model.periodic.evaluate(model.rows.frame) if model.periodic is not None else np.zeros(model.rows.size)
    model.offset = None  # its bank would stand beside the next one's
    model.offset = searched(_problem(model, model.rows.y - periodic), seed)


def learn(model: TransmissionModel, seed: int) -> None:
    """Keep what the offset's rows say of the series, and search the offset anew, as long as that moves the rows. The
    rows are the same then, and say no more of how sure the series is.
    """
    covariance = None
    for _ in range(LEARNINGS):
        if model.periodic is None or model.offset is None:
            break
        series = _learnt(model, model.offset)
        if series is None:
            break
        if model.plain is not None and not model.laws and model.periodic.laws == model.given.laws:
            model.plain = series.less([f for f in series.orders if f not in model.plain.orders])
        covariance = series.covariance if covariance is None else covariance
        model.periodic = replace(model.periodic, series=series)
        offset_anew(model, seed)
    if model.periodic is not None and covariance is not None:
        model.periodic = replace(model.periodic, series=replace(model.periodic.series, covariance=covariance))


def _learnt(model: TransmissionModel, offset: Search) -> Series | None:
    """The series with what the offset's rows say of its coefficients; None where that moves the rows by next to
    nothing.
    """
    assert model.noise is not None
    fitted, problem = offset.model, offset.model.problem
    block = next((b for b in fitted.base if isinstance(b.regressor, Unsure)), None)
    if block is None:
        return None
    assert isinstance(block.regressor, Unsure)
    coefficients, covariance = fitted.fit.of(block.indices)
    frame = problem.rows.frame
    shift = (block.regressor.columns(frame) @ coefficients)[problem.usable]
    noise = model.noise.of_means(problem.rows.number, durations(frame))[problem.usable]
    if np.mean(shift**2) < LEARNT**2 * np.mean(noise):
        return None
    return block.regressor.known(coefficients, covariance)


def _orders(model: TransmissionModel, y: FloatArray, seed: int) -> None:
    """Find and calibrate everything periodic in ``y`` (n,): the rows without their offset."""
    rows, given = model.rows, model.given
    known = [*given.orders, *(f for f in given.notch if f not in given.orders)]
    found: dict[float, WeakOrder] = {}
    shown = looks(rows, model.revolutions)

    def look(at: Collection[float]) -> Seen:
        return seen(shown, model.revolutions, y, [*known, *sorted(at)])

    now = look(())
    stage = Stage.of(now, model.revolutions, model.train)
    if stage is not None and model.price is None:
        model.nulls = stage.maxima(seed, False)
        model.price = tail(model.nulls, criteria.ERROR_RATE_OF_A_CHANNEL)
    for _ in range(ROUNDS if model.price is not None else 0):
        assert model.price is not None
        model.noise = slow.mixture(now, model.revolutions, rows, rows.within, usual_rate(rows.frame))
        fresh = search(now, model.revolutions, model.train, now.orders, _floor(model), model.price)
        fresh = [w for w in fresh if w.order not in found]
        if not fresh and unhide(now, known, found, Evidence(model.revolutions, model.train, model.price)):
            now = look(found)
            continue
        if not fresh:
            # with its number an order between two follows what a whole one does with the state: whole ones come first
            fresh = search_between(now, model.revolutions, model.train, now.orders, _floor(model), model.price)
        if not fresh:
            break
        found |= {w.order: w for w in fresh}
        now = look(found)
    if model.price is not None:
        by = Evidence(model.revolutions, model.train, model.price)
        now = settled(look, now, found, by)
        # several that leak into each other may each be needless beside the others, and not all of them
        again: set[float] = set()
        for _ in range(SETTLINGS):
            fresh = search(now, model.revolutions, model.train, now.orders, _floor(model), model.price)
            fresh = [w for w in fresh if w.order not in found and w.order not in again]
            if not fresh:
                break
            again |= {w.order for w in fresh}
            found |= {w.order: w for w in fresh}
            now = settled(look, look(found), found, by)
    calibrate_all(model, now, known, found)
    with_noise(model, now)


def with_noise(model: TransmissionModel, now: Seen) -> None:
    """Tell a model's noise from what its revolutions show and its rows scatter."""
    assert model.periodic is not None
    slope = model.periodic.slope(model.rows.frame.take(steady_rows(model)))
    steady = model.rows.take(steady_rows(model))
    inner = np.maximum(steady.within - 2.0 * slope * steady.lean + slope**2 * steady.sweep, 0.0)
    model.noise = slow.mixture(now, model.revolutions, steady, inner, usual_rate(model.rows.frame))


def steady_rows(model: TransmissionModel) -> NDArray[np.bool_]:
    """Rows inside the bounds, in steady motion."""
    return np.asarray(model.inside & (model.rows.frame.steady > 0.5))


def _floor(model: TransmissionModel) -> float:
    assert model.noise is not None
    return float(np.sqrt(model.noise.variance))


def calibrate_all(model: TransmissionModel, now: Seen, known: Sequence[float], found: dict[float, WeakOrder]) -> None:
    """Calibrate the series and the further orders on what the revolutions show of them all."""
    stage = Stage.of(now, model.revolutions, model.train)
    # what is found under a law follows it, as the series does
    polynomial = list(known)
    weak: list[WeakOrder] = []
    for f, order in found.items():
        k = now.orders.index(f)
        if stage is None:
            continue
        vectors = now.vectors[model.train, k] / stage.scale
        sigma = stage.shape_at(f)
        estimate = stage.estimated(f, order.model, vectors, sigma, order.gain)
        if model.laws or stage.misfit(estimate, vectors, sigma) > FOLLOWED:
            polynomial.append(f)
        weak.append(estimate)
    revolutions = model.training_revolutions
    model.seen = now
    if stage is not None and not model.laws:
        bent = _bent(model, now, stage, [w for w in weak if w.order in polynomial])
        weak = [bent.get(w.order, w) for w in weak]
        polynomial = [f for f in polynomial if f not in bent]
    columns = np.array([now.orders.index(f) for f in polynomial], dtype=np.int64)
    noise = now.noise(polynomial)[model.train]
    vectors = now.vectors[model.train][:, columns]
    alone = tuple(w for w in weak if w.order not in polynomial)

    def under(laws: tuple[Law, ...], waves: tuple[WeakOrder, ...]) -> Periodic:
        series = calibrated_by(model, vectors, noise, polynomial, passed(laws, revolutions, polynomial))
        return with_parts(model, Periodic(series, waves, laws=laws))

    model.periodic = under((*model.given.laws, *model.laws), alone)
    given = under(model.given.laws, alone) if model.laws else model.periodic
    model.plain = given.series.less([f for f in polynomial if f not in known])


def _bent(model: TransmissionModel, now: Seen, stage: Stage, asked: Sequence[WeakOrder]) -> dict[float, WeakOrder]:
    """Of found orders that are to have polynomials those that waves over the torque follow better, as such."""
    if not asked:
        return {}
    orders = [w.order for w in asked]
    columns = [now.orders.index(f) for f in orders]
    noise, vectors = now.noise(orders)[model.train], now.vectors[model.train][:, columns]
    series = calibrated_by(model, vectors, noise, orders, np.ones_like(vectors))
    points = model.folds[[t.recording for t in model.training_revolutions]]
    found = (cornered(w, stage, vectors[:, k], series, noise[:, k], points) for k, w in enumerate(asked))
    return {w.order: w for w in found if w is not None}


def calibrated_by(
    model: TransmissionModel, vectors: Complex, noise: FloatArray, orders: Sequence[float], by: Complex
) -> Series:
    """The series of ``vectors`` (revolutions, orders) of the training revolutions whose components have ``noise``,
    before something multiplies them ``by`` a response (revolutions, orders).
    """
    given = {*model.given.orders, *model.given.notch}
    return calibrate(model.training_revolutions, vectors / by, noise / np.abs(by), orders, model.parts, given)


def with_parts(model: TransmissionModel, periodic: Periodic) -> Periodic:
    """What is periodic with what the steady parts of less than a revolution say of its series."""
    if not model.parts or model.seen is None or not periodic.series.orders:
        return periodic
    rest = replace(periodic, series=periodic.series.less(periodic.series.orders), laws=())
    rest_of_rows = model.without_offset.copy()
    for part in model.parts:
        rest_of_rows[part.rows] -= rest.evaluate(model.rows.frame.take(part.rows))
    white = float(np.median(model.seen.white[model.train]))
    return replace(
        periodic, series=refined(periodic.series, model.rows, rest_of_rows, model.parts, white, periodic.laws)
    )


def _wavering(model: TransmissionModel, y: FloatArray) -> FloatArray:
    """What the offset's polynomial makes of torque and speed that waver inside a revolution, roughly (n,).

    Taken off before the orders are fitted, so that a wavering load is not read as an order.
    """
    blocks, means = [], []
    regressor = next((b.regressor for b in model.base if b.regressor.effect == "te.offset"), None)
    if regressor is None:
        return np.zeros(y.size)
    for revolution in model.training_revolutions:
        blocks.append(regressor.columns(model.rows.frame.take(revolution.rows)).mean(axis=0))
        means.append(float(np.mean(y[revolution.rows])))
    x = np.asarray(blocks)
    scale = np.maximum(np.sqrt(np.mean(x**2, axis=0)), 1e-9)
    normal = (x / scale).T @ (x / scale) / len(blocks) + 1e-5 * np.eye(x.shape[1])
    beta = np.linalg.solve(normal, (x / scale).T @ np.asarray(means) / len(blocks)) / scale
    return added(regressor, model.rows.frame, beta)


def _problem(model: TransmissionModel, y: FloatArray) -> ChannelProblem:
    rows, usable, _ = slow.offset_rows(model.rows, y, model.inside)
    rows = slow.at_level(rows, usable & (model.folds[rows.frame.recording] >= 0))
    doubt, base = None, model.base
    if model.periodic is not None:
        frame = rows.frame
        x = frame.states
        doubt, base = _unsure(model, rows, x, usable)
        # where the series, at a state that no revolution has shown, is as uncertain as a sample is noisy, it says
        # nothing; a series that is so everywhere still has a mean
        sure = usable & (doubt < _floor(model) ** 2)
        usable = sure if sure.any() else usable
        # a direction in which no revolution was calibrated has all of its waves in the rows
        calibrated = np.isin(np.sign(frame.last_direction), list(model.periodic.series.amplitude))
        usable = usable & calibrated if (usable & calibrated).any() else usable
        noise = _floor(model) / float(np.sqrt(max(np.median(rows.number), 1.0)))
        quiet = usable & ~ringing(frame, rings_for(model.periodic.laws, model.periodic.series, noise))
        # a mode that would swing most of the time says nothing of when the offset may be compared
        usable = quiet if 2 * int(quiet.sum()) >= int(usable.sum()) else usable
    return ChannelProblem(
        TRANSMISSION_ERROR,
        rows,
        usable,
        model.folds,
        base,
        model.noise,
        doubt,
        model.switched_off,
        model.banned,
        states=model.known is not None and model.known.states,
    )


def _unsure(
    model: TransmissionModel, rows: Rows, states: FloatArray, usable: NDArray[np.bool_]
) -> tuple[FloatArray, tuple[BaseTerm, ...]]:
    """Variance of the rows (n,) at ``states`` (n, 3) by what the series is unsure of, and the base with what of it all
    rows share.
    """
    assert model.periodic is not None
    assert model.noise is not None
    frame, rate, series = rows.frame, usual_rate(model.rows.frame), model.periodic.series
    span = angle_of_rows(frame, rate)
    doubt = series.variance(states, frame.last_direction, span)
    counted = usable & (model.folds[frame.recording] >= 0) & (rows.number > 0)
    noise = model.noise.of_means(rows.number, durations(frame))
    shared = unsure(series, model.periodic.laws, rate, frame, noise, counted)
    if shared is None:
        return doubt, model.base
    doubt = np.maximum(doubt - shared.explained(states, frame.last_direction, span), 0.0)
    return doubt, (*model.base, BaseTerm(shared, (1.0,) * shared.size))


def _offset_alone(model: TransmissionModel, y: FloatArray) -> FloatArray:
    """The simulation's offset calibrated on ``y`` (n,), at the rows."""
    problem = _problem(model, y)
    residual = plain_residual(problem)
    bank, blocks, fit = calibrated_alone(problem, residual)
    wider = widened(bank, blocks, fit)
    if wider > 1.0:
        _, blocks, fit = calibrated_alone(problem, residual, wider)
    return predicted(blocks, fit, model.rows.frame)


__all__ = ["Given", "TransmissionModel", "analyse", "begun", "replace"]
