"""From a search to what it says of its channel: prediction, noise floor, discoveries, how sure they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.orders.beyond_orders import beyond_orders
from bench.mismatch.orders.discoveries import discoveries as of_orders
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.reported_swings import discoveries as in_swings
from bench.mismatch.orders.turns import learn, offset_anew
from bench.mismatch.recordings.beginning import at_start, risen
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.vibration import Density
from bench.mismatch.regression import noise
from bench.mismatch.regression.beside import BEYOND_BOUNDS, bounds_exceeded
from bench.mismatch.regression.course import columns_at
from bench.mismatch.regression.discoveries import discoveries as of_regression
from bench.mismatch.regression.hidden_states import with_states
from bench.mismatch.regression.model import ChannelModel, of_start
from bench.mismatch.regression.open_forms import with_open_forms
from bench.mismatch.regression.problem import NUISANCE, WanderingZero
from bench.mismatch.regression.regressors import Named
from bench.mismatch.regression.slots import Slot
from bench.mismatch.regression.slow_noise import scattered
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.succession import settle, without_empty_laws
from bench.mismatch.unnamed.formula import in_formulas
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import TRANSMISSION_ERROR

SPECTRA = "spectra of the steady parts, medians over recordings and frequencies"
DIFFERENCES = "differences of rows a few steps apart: what changes as quickly counts as noise"
SCATTER = "scatter inside blocks of two seconds and of these about parabolas over nine of them, medians over recordings"
BY_REVOLUTIONS = "revolutions against each other, medians over orders and frequencies"
MOST_ROWS = 4000
"""rows on which the uncertainty of a prediction is worked out"""
GROUPS = 5
"""groups of recordings whose noise is told apart to see how sure the noise is"""


def slots_of(search: Search, data: Dataset, formulas: bool) -> list[Slot]:
    """Settle which effects a search has; ``formulas`` whether one is looked for where an effect has no name."""
    slots = settle(search)
    if formulas:
        slots = in_formulas(search, slots, data.auxiliary_units)
    slots = with_open_forms(search, without_empty_laws(search, slots))
    search.model.compare_recordings()
    return slots


def of_search(search: Search, slots: Sequence[Slot], data: Dataset) -> ChannelOutcome:
    """Return what the search of a channel says, whose effects were settled (``slots``)."""
    model = search.model
    problem = model.problem
    frame = problem.rows.frame
    whole = of_start(problem, model.predict(frame))
    before = of_start(problem, model.predict(frame, [], model.refitted([])))
    densities = data.density.get(problem.channel, [])
    error, method = floor_error(densities), DIFFERENCES if problem.noise is None else SPECTRA
    if problem.spec.integral:
        error, method = scattered(problem)[1], SCATTER
    outcome = ChannelOutcome(
        problem.channel,
        problem.rows,
        problem.usable,
        problem.held_out,
        whole,
        before,
        model.floor,
        error,
        method,
    )
    number = np.where(problem.usable, problem.rows.number, 0.0)
    outcome.discoveries += of_regression(search, slots, whole, number)
    outcome.doubt = uncertainty(model, frame, problem.held_out, problem.rows.number)
    if problem.spec.integral and model.noise.independent_rows is None:
        # zeros as large as the fitted recordings have shown them (:func:`regression.prior.zeros_settled`); what no file
        # holds is missing from every prediction
        outcome.doubt += of_zeros(model, problem.held_out)
    outcome.levels = 0.0 if problem.spec.integral else model.fit.variance
    outcome.notes += model.notes
    outcome.notes += impossible_numbers(model)
    return outcome


def impossible_numbers(model: ChannelModel) -> list[str]:
    """A sentence for each number of the calibrated simulation that is surely beyond what is physically possible: what
    these recordings hold, and nothing explains, has calibrated it.
    """
    out = []
    for block in model.base:
        term = block.regressor
        if not isinstance(term, Named):
            continue
        values, covariance = model.fit.of(block.indices)
        std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        bounds = bounds_exceeded(term, values, BEYOND_BOUNDS * std)
        out += [
            f"{symbol.symbol} ({symbol.meaning}) comes out as {value:.3g} ± {error:.2g} {symbol.unit}, beyond"
            f" {bound:g}, which is not possible: something else in these recordings has calibrated it"
            for symbol, value, error, bound in zip(term.form.linear, values, std, bounds, strict=True)
            if np.isfinite(bound)
        ]
    return out


def of_transmission(model: TransmissionModel, data: Dataset, seed: int, formulas: bool) -> ChannelOutcome:
    """Return what the transmission error's model says: its orders, its pulses, the terms of its offset."""
    plain = model.periodic
    found = of_orders(model, data.gearbox, seed)
    if model.periodic is not plain:
        # a pulse or a law says what orders had said badly: the offset is what they leave now
        offset_anew(model, seed)
    # orders and laws are found as revolutions show them: a law has to say more than they do, and not than the offset
    learn(model, seed)
    assert model.offset is not None
    offset = model.offset = model.offset if data.linear else with_states(model.offset, seed)
    slots = settle(offset)
    if formulas:
        slots = in_formulas(offset, slots, data.auxiliary_units)
    slots = with_open_forms(offset, slots)
    frame = model.rows.frame
    offset_model = offset.model
    offset_model.compare_recordings()
    periodic = model.periodic_at_rows
    level = offset_model.predict(frame)
    before = model.given_orders + offset_model.predict(frame, [], offset_model.refitted([]))
    held = np.isin(frame.recording, list(data.held_out()))
    floor = offset_model.floor
    spread = model.seen.white if model.seen is not None else np.zeros(0)
    error = float(floor * np.std(spread) / spread.mean() / np.sqrt(spread.size)) if spread.size > GROUPS else None
    outcome = ChannelOutcome(
        TRANSMISSION_ERROR,
        model.rows,
        model.inside,
        model.inside & held,
        periodic + level,
        before,
        floor,
        error,
        BY_REVOLUTIONS if model.noise is not None else DIFFERENCES,
    )
    if model.periodic is not None and outcome.held_out.any():
        chosen = np.flatnonzero(outcome.held_out)[:: max(1, int(outcome.held_out.sum()) // MOST_ROWS)]
        part = frame.take(chosen)
        x = part.states
        outcome.doubt = float(np.mean(model.periodic.series.variance(x, part.last_direction)))
        outcome.doubt += uncertainty(offset_model, frame, outcome.held_out, model.rows.number)
    outcome.levels = offset_model.fit.variance
    outcome.discoveries += found
    if model.swings is not None:
        outcome.discoveries += in_swings(model.swings.orders, model.rows, model.compared, floor, model.banned)
    left = model.rows.y - periodic
    told = of_regression(offset, slots, level, model.compared, frame, left)
    calibrated = offset_model.calibrated
    outcome.discoveries += [
        replace(
            found,
            everywhere=beyond_orders(
                offset_model.contribution(slot.chosen, frame), calibrated, frame, model.recorded, model.given.orders
            ),
        )
        for slot, found in zip(slots, told, strict=True)
    ]
    outcome.notes += [*model.notes, *offset_model.notes]
    return outcome


def uncertainty(model: ChannelModel, frame: Frame, rows: NDArray[np.bool_], number: FloatArray) -> float:
    """Mean variance of a model's prediction over the samples of some rows, by the covariance of its coefficients."""
    chosen = np.flatnonzero(rows)[:: max(1, int(rows.sum()) // MOST_ROWS)]
    if chosen.size == 0:
        return 0.0
    blocks = [b for b in model.blocks() if b.regressor.effect != NUISANCE]
    columns = np.hstack([np.zeros((chosen.size, 0)), *(columns_at(b.regressor, frame, chosen) for b in blocks)])
    covariance = model.fit.of([i for b in blocks for i in b.indices])[1]
    variance = np.sum(columns @ covariance * columns, axis=1)
    return float(np.average(np.maximum(variance, 0.0), weights=np.maximum(number[chosen], 1e-9)))


def of_zeros(model: ChannelModel, rows: NDArray[np.bool_]) -> float:
    """Mean variance over the samples of some rows of an integral, by zeros of sensors that add up from where each
    recording begins: they differ by as much as the fitted recordings say, and nothing recorded tells them.
    """
    problem, out = model.problem, 0.0
    number = np.where(rows, problem.rows.number, 0.0)
    if not number.any():
        return out
    for block in model.base:
        if not isinstance(block.regressor, WanderingZero):
            continue
        for column, precision in zip(block.regressor.columns(problem.rows.frame).T, block.precision, strict=True):
            risen_by = column - risen(problem.rows.frame, at_start(problem.rows.frame, column))
            out += float(np.average(risen_by**2, weights=number)) / float(precision)
    return out


def floor_error(densities: Sequence[Density]) -> float | None:
    """Standard error of the noise of a sample: groups of recordings against each other. Where a group has too few, by
    leaving each group out (delete-a-group jackknife: Kott, J. Official Statistics 17 (2001) 521); None where too few
    are left even so.
    """
    groups = _floors([densities[k::GROUPS] for k in range(GROUPS)])
    if groups is not None:
        return float(np.std(groups, ddof=1) / np.sqrt(GROUPS))
    others = _floors([[d for n, d in enumerate(densities) if n % GROUPS != k] for k in range(GROUPS)])
    return None if others is None else float(np.std(others) * np.sqrt(GROUPS - 1))


def _floors(groups: Sequence[Sequence[Density]]) -> list[float] | None:
    """Noise of a sample in each of some groups of recordings; None where one has too few."""
    found = [noise.mixture(group) for group in groups]
    floors = [float(np.sqrt(one.variance)) for one in found if one is not None]
    return floors if len(floors) == len(groups) else None
