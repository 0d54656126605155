"""What revolutions leave unknown of a series is the same error at every row: a few directions hold it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.orders.series import Series
from bench.mismatch.orders.unsure import MOST, unsure
from bench.simulation.frame import ARRAYS, FloatArray, Frame
from tests.bench.mismatch.orders.test_partial import NOISE, SLOW, calibrated

ROWS = 400
RATE = 500.0


def slow(count: float = 10.0) -> Frame:
    """Half a revolution at a speed at which no whole one was made; each row a mean of ``count`` samples."""
    values: dict[str, FloatArray] = {name: np.zeros(ROWS) for name in ARRAYS}
    values |= {"theta": np.linspace(1.0, 1.0 + np.pi, ROWS), "velocity": np.full(ROWS, SLOW)}
    values |= {"last_direction": np.ones(ROWS), "temperature": np.full(ROWS, 25.0), "count": np.full(ROWS, count)}
    values["recording"] = np.zeros(ROWS, dtype=np.int64)
    return Frame(ratio=185.0, **values)  # type: ignore[arg-type]


def at(frame: Frame) -> tuple[FloatArray, FloatArray]:
    """States (n, 3) and angles that the rows turn through (n,), rad."""
    states = np.column_stack([frame.torque, frame.velocity, frame.temperature])
    return states, np.abs(frame.velocity) * frame.count / RATE


def drawn(series: Series, rng: np.random.Generator) -> Series:
    """The series with coefficients drawn from their covariance."""
    off = np.array([rng.multivariate_normal(np.zeros(20), own) for own in series.covariance[1]])
    return replace(series, amplitude={1: series.amplitude[1] + off[:, :10]}, phase={1: series.phase[1] + off[:, 10:]})


def test_a_few_directions_hold_what_the_series_may_be_wrong_by() -> None:
    series, frame = calibrated(), slow()
    shared = unsure(series, (), RATE, frame, np.full(ROWS, NOISE**2), np.ones(ROWS, dtype=bool))
    assert shared is not None
    columns = shared.columns(frame)
    assert 1 <= columns.shape[1] <= MOST
    rng = np.random.default_rng(3)
    errors = [drawn(series, rng).evaluate(frame) - series.evaluate(frame) for _ in range(40)]
    left = [e - columns @ np.linalg.lstsq(columns, e, rcond=None)[0] for e in errors]
    assert np.sqrt(np.mean(np.square(errors))) > 5.0 * NOISE
    # the rest is of second order in the phase, and of directions below the noise
    assert np.sqrt(np.mean(np.square(left))) < 0.15 * np.sqrt(np.mean(np.square(errors)))
    # each column is as large as its standard deviation
    states, span = at(frame)
    variance = series.variance(states, frame.last_direction, span)
    assert float(np.mean(np.sum(columns**2, axis=1))) == pytest.approx(float(np.mean(variance)), rel=0.1)
    # and what is left of the doubt is less than a row's noise, whatever the angle
    rest = variance - shared.explained(states, frame.last_direction, span)
    assert np.all(np.abs(rest) < 0.1 * NOISE**2)


def test_an_order_of_unknown_phase_keeps_its_doubt() -> None:
    series, frame = calibrated(), slow()
    wild = {1: series.covariance[1].copy()}
    wild[1][0, 19, 19] = 4.0
    doubtful = replace(series, covariance=wild)
    shared = unsure(doubtful, (), RATE, frame, np.full(ROWS, NOISE**2), np.ones(ROWS, dtype=bool))
    assert shared is not None
    states, span = at(frame)
    alone = doubtful.less(series.orders[1:])
    rest = doubtful.variance(states, frame.last_direction, span) - shared.explained(states, frame.last_direction, span)
    assert np.all(rest > 0.9 * alone.variance(states, frame.last_direction, span))


def test_simulated_rows_without_noise_are_no_trouble() -> None:
    frame = slow()
    assert unsure(calibrated(), (), RATE, frame, np.zeros(ROWS), np.ones(ROWS, dtype=bool)) is not None


def test_nothing_is_fitted_where_the_series_is_known_better_than_the_rows() -> None:
    chosen = np.ones(ROWS, dtype=bool)
    assert unsure(calibrated(), (), RATE, slow(), np.full(ROWS, 1e-6), chosen) is None


def test_a_row_over_a_whole_wave_does_not_see_its_order() -> None:
    series = calibrated()
    wave = 2.0 * np.pi / series.orders[-1]
    frame = slow(count=wave / SLOW * RATE)
    x = np.column_stack([frame.torque, frame.velocity, frame.temperature])
    alone = series.less(series.orders[:-1])
    over = np.abs(frame.velocity) * frame.count / RATE
    assert np.max(alone.variance(x, frame.last_direction, over)) < 1e-9 * np.max(
        alone.variance(x, frame.last_direction)
    )
    everywhere = np.ones(ROWS, dtype=bool)
    assert unsure(alone, (), RATE, frame, np.full(ROWS, NOISE**2), everywhere) is None


def test_a_series_learns_what_the_rows_say_of_its_directions() -> None:
    series, frame = calibrated(), slow()
    shared = unsure(series, (), RATE, frame, np.full(ROWS, NOISE**2), np.ones(ROWS, dtype=bool))
    assert shared is not None
    columns = shared.columns(frame)
    true = drawn(series, np.random.default_rng(4))
    error = true.evaluate(frame) - series.evaluate(frame)
    precision = columns.T @ columns / NOISE**2 + np.eye(shared.size)
    covariance = np.linalg.inv(precision)
    learnt = shared.known(covariance @ columns.T @ error / NOISE**2, covariance)
    left = true.evaluate(frame) - learnt.evaluate(frame)
    assert np.sqrt(np.mean(left**2)) < 0.2 * np.sqrt(np.mean(error**2))
    states, span = at(frame)
    before, after = (one.variance(states, frame.last_direction, span) for one in (series, learnt))
    assert np.mean(after) < 0.05 * np.mean(before)
    assert np.all(after >= 0.0)


def test_a_series_whose_directions_say_nothing_stays() -> None:
    series, frame = calibrated(), slow()
    shared = unsure(series, (), RATE, frame, np.full(ROWS, NOISE**2), np.ones(ROWS, dtype=bool))
    assert shared is not None
    same = shared.known(np.zeros(shared.size), np.eye(shared.size))
    assert np.array_equal(same.amplitude[1], series.amplitude[1])
    assert np.array_equal(same.covariance[1], series.covariance[1])
