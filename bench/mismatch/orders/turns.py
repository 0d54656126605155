"""The transmission error's orders and its offset, found in turns."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.orders import offset_rows as slow
from bench.mismatch.orders import swings as short
from bench.mismatch.orders.between import search_between
from bench.mismatch.orders.calibrating import calibrate_all
from bench.mismatch.orders.hidden import unhide
from bench.mismatch.orders.joint import SETTLINGS, Evidence, settled
from bench.mismatch.orders.look import HIGHEST_ORDER
from bench.mismatch.orders.model import KnownOffset, Swings, TransmissionModel, floor_of, with_noise
from bench.mismatch.orders.offset_problem import offset_alone, offset_problem, wavering
from bench.mismatch.orders.revolutions import Seen, looks, seen
from bench.mismatch.orders.series import Series
from bench.mismatch.orders.unsure import Unsure
from bench.mismatch.orders.weak import Stage, WeakOrder, search
from bench.mismatch.regression.excess import excess
from bench.mismatch.regression.maxima import tail
from bench.mismatch.regression.model import sum_of_blocks
from bench.mismatch.regression.noise import durations, usual_rate
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray

ROUNDS = 24
FEWEST_CALIBRATED = 2
"""steady revolutions that may be fitted from which the series is calibrated; its prior and the steady parts of less
than a revolution say the rest"""
SWINGS = 3
"""times that orders of a joint which never turns its output round are looked for beside an offset found anew"""
LEARNINGS = 3
"""times that the series learns from the offset's rows, which are searched anew, as long as it still does"""
LEARNT = 0.5
"""size of what the offset's rows move the series by, over their noise, below which it is not searched again"""


def analyse(model: TransmissionModel, seed: int) -> TransmissionModel:
    """Find what the transmission error's simulation lacks."""
    if model.swings is not None:
        return _in_swings(model, model.swings, seed)
    if int(model.train.sum()) >= FEWEST_CALIBRATED:
        if model.known is None:
            find_orders(model, model.without_offset - wavering(model, model.rows.y), seed)
        model.quiet = model.without_offset - level_of(model)
        find_orders(model, model.quiet, seed)
    offset_anew(model, seed)
    return model


def _in_swings(model: TransmissionModel, swings: Swings, seed: int) -> TransmissionModel:
    """The same where no steady part covers a revolution: the offset, which has functions of the angle then, and orders
    that come several times in a swing, in turns.
    """
    fold = model.folds[model.rows.frame.recording]
    fitted, held = model.inside & (fold >= 0), model.inside & (fold < 0)
    offset_anew(model, seed)
    for _ in range(SWINGS):
        assert model.offset is not None
        before, level = model.swings, model.offset.model.predict(model.rows.frame)
        left = model.toneless - level
        found = short.borne_out(short.search(model.rows, left, fitted), model.rows, left, held)
        if before is not None and [o.wave.order for o in found] == [o.wave.order for o in before.orders]:
            break
        model.swings = replace(swings, orders=found)
        model.offset.close()
        offset_anew(model, seed)
    return model


def level_of(model: TransmissionModel) -> FloatArray:
    """The offset of the rows (n,): as an earlier search has it, else the simulation's beside what is periodic."""
    if model.known is not None:
        return model.known.values
    assert model.periodic is not None
    return offset_alone(model, model.rows.y - model.periodic.evaluate(model.rows.frame))


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
    moved = energy / floor_of(model) ** 2
    return KnownOffset(values, offset.problem.states, moved) if 0.5 * moved > model.price else None


def offset_anew(model: TransmissionModel, seed: int) -> None:
    """Search what the model's periodic part leaves for what the offset lacks."""
    model.offset = None  # its bank would stand beside the next one's
    model.offset = searched(offset_problem(model, model.rows.y - model.periodic_at_rows), seed)


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


def find_orders(model: TransmissionModel, y: FloatArray, seed: int) -> None:
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
    # an order beyond half the rows of a revolution may be the shadow of a lower one, until that is found
    highest = np.inf if stage is None else stage.highest
    for _ in range(ROUNDS if model.price is not None else 0):
        assert model.price is not None
        model.noise = slow.mixture(now, model.revolutions, rows, rows.within, usual_rate(rows.frame))
        fresh = search(now, model.revolutions, model.train, now.orders, floor_of(model), model.price, highest)
        fresh = [w for w in fresh if w.order not in found]
        if not fresh and unhide(now, known, found, Evidence(model.revolutions, model.train, model.price)):
            now = look(found)
            continue
        if not fresh:
            # with its number an order between two follows what a whole one does with the state: whole ones come first
            fresh = search_between(
                now, model.revolutions, model.train, now.orders, floor_of(model), model.price, highest
            )
        if not fresh and highest < HIGHEST_ORDER:
            highest = np.inf
            continue
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
            fresh = search(now, model.revolutions, model.train, now.orders, floor_of(model), model.price)
            fresh = [w for w in fresh if w.order not in found and w.order not in again]
            if not fresh:
                break
            again |= {w.order for w in fresh}
            found |= {w.order: w for w in fresh}
            now = settled(look, look(found), found, by)
    calibrate_all(model, now, known, found)
    with_noise(model, now)
