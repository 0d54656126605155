"""What the offset of the transmission error is fitted to: what is left beside all that is periodic."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.orders import offset_rows as slow
from bench.mismatch.orders.model import TransmissionModel, floor_of
from bench.mismatch.orders.ringing import ringing, rings_for
from bench.mismatch.orders.unsure import angle_of_rows, unsure
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.course import added
from bench.mismatch.regression.model import plain_residual, predicted, widened
from bench.mismatch.regression.noise import durations, usual_rate
from bench.mismatch.regression.prior import calibrated_alone
from bench.mismatch.regression.problem import BaseTerm, ChannelProblem
from bench.simulation.frame import FloatArray
from bench.simulation.terms import TRANSMISSION_ERROR


def wavering(model: TransmissionModel, y: FloatArray) -> FloatArray:
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


def offset_problem(model: TransmissionModel, y: FloatArray) -> ChannelProblem:
    """Return what the regression of the offset is given: the rows (n,) beside all that is periodic, ``y``, averaged in
    time, with what the series is unsure of.
    """
    rows, usable, _ = slow.offset_rows(model.rows, y, model.inside)
    rows = slow.at_level(rows, usable & (model.folds[rows.frame.recording] >= 0))
    doubt, base = None, model.base
    if model.periodic is not None:
        frame = rows.frame
        x = frame.states
        doubt, base = _unsure(model, rows, x, usable)
        # where the series, at a state that no revolution has shown, is as uncertain as a sample is noisy, it says
        # nothing; a series that is so everywhere still has a mean
        sure = usable & (doubt < floor_of(model) ** 2)
        usable = sure if sure.any() else usable
        # a direction in which no revolution was calibrated has all of its waves in the rows
        calibrated = np.isin(np.sign(frame.last_direction), list(model.periodic.series.amplitude))
        usable = usable & calibrated if (usable & calibrated).any() else usable
        noise = floor_of(model) / float(np.sqrt(max(np.median(rows.number), 1.0)))
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
        free=model.swings is not None and model.swings.free,
        cut=model.swings is not None and model.swings.free and model.swings.cut,
        swings=model.swings is not None,
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


def offset_alone(model: TransmissionModel, y: FloatArray) -> FloatArray:
    """The simulation's offset calibrated on ``y`` (n,), at the rows."""
    problem = offset_problem(model, y)
    residual = plain_residual(problem)
    bank, blocks, fit = calibrated_alone(problem, residual)
    wider = widened(bank, blocks, fit)
    if wider > 1.0:
        _, blocks, fit = calibrated_alone(problem, residual, wider)
    return predicted(blocks, fit, model.rows.frame)
