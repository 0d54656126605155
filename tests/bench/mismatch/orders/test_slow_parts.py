"""Whole revolutions at one fast speed, slow recordings of less than a revolution: the model follows both."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.orders import turns
from bench.mismatch.orders.model import GivenOrders, TransmissionModel, begun
from bench.mismatch.orders.turns import analyse, learn
from bench.mismatch.outcomes import of_transmission
from bench.mismatch.recordings.rows import ANGLE_STEP, Rows
from bench.mismatch.regression.problem import nominal_base
from bench.simulation import Gearbox
from bench.simulation.frame import ARRAYS, FloatArray, Frame, IntArray, concatenate
from bench.simulation.terms import TRANSMISSION_ERROR

RATIO, RATE = 185.0, 500.0
NOISE = 2e-6
"""rad, of a sample"""
ORDERS = (1.0, 3.0, 9.0, 19.0, 46.0, 92.0)
SIZES = np.array([60e-6, 20e-6, 8e-6, 12e-6, 10e-6, 4e-6])
OFFSET = np.array([5e-6, 4e-6, 1e-6, 120e-6, 8e-6, 10e-6, 4e-6, 2e-6, 1e-6])
OF_AMPLITUDE = np.array([0.05, 0.05, 0.03, 0.15, 0.15, 0.08, 0.03, 0.03, 0.03])
OF_PHASE = np.array([0.05, 0.08, 0.03, 0.2, 0.3, 0.1, 0.03, 0.03, 0.03])
"""how much the orders differ in the coefficients of squares, quantities and products of torque, speed, temperature"""
FAST, SLOWEST, LESS_SLOW = 0.17, 0.04, 0.12
SLOW_PARTS, HELD_OUT = 12, 4
"""slow recordings in each direction that may be fitted, and further ones that may not"""
CONCEALED, WAVE = 30.0, 0.5 * NOISE
"""an order that the simulation does not have, and its amplitude"""


def true(frame: Frame) -> FloatArray:
    """The transmission error without noise: each direction's amplitudes, phases and offset follow the state."""
    rng = np.random.default_rng(11)
    a, b, c = frame.torque / 1000.0, np.abs(frame.velocity) / 0.1 - 1.0, (frame.temperature - 35.0) / 15.0
    basis = np.column_stack([a * a, b * b, c * c, a, b, c, a * b, a * c, b * c])
    out = np.zeros(frame.size)
    for side in (1.0, -1.0):
        rows = frame.direction == side
        own, theta = basis[rows], frame.theta[rows]
        out[rows] = side * 30e-6 + own @ OFFSET * (1.0 + 0.05 * side)
        for order, size in zip(ORDERS, SIZES, strict=True):
            amplitude = size * (1.0 + own @ (OF_AMPLITUDE * rng.normal(size=9)))
            phase = rng.uniform(-np.pi, np.pi) + own @ (OF_PHASE * rng.normal(size=9))
            out[rows] += amplitude * np.sin(order * theta + phase)
    return out


def steady(number: int, speed: float, torque: float, temperature: float, turns: float, begin: float) -> Frame:
    """A recording at one state, rows over the angle."""
    side = float(np.sign(speed))
    size, step = round(turns * 2.0 * np.pi / ANGLE_STEP), ANGLE_STEP / abs(speed)
    elapsed: FloatArray = np.arange(size, dtype=np.float64) * step
    angle: FloatArray = np.arange(size, dtype=np.float64) * ANGLE_STEP
    values: dict[str, FloatArray] = {name: np.zeros(size) for name in ARRAYS}
    values |= {"count": np.full(size, RATE * step), "elapsed": elapsed, "time": 200.0 * number + elapsed}
    values |= {"step": np.where(elapsed > 0.0, step, 0.0), "steady": np.ones(size), "kept": np.ones(size)}
    values |= {"theta": begin + side * angle, "q": begin + side * angle, "velocity": np.full(size, speed)}
    values |= {"direction": np.full(size, side), "last_direction": np.full(size, side)}
    values |= {"travel": 10.0 * number + angle, "reversal_travel": 1.0 + angle, "reversal_time": 100.0 + elapsed}
    values |= {"torque": np.full(size, torque), "torque_level": np.full(size, torque)}
    values |= {"temperature": np.full(size, temperature)}
    return Frame(ratio=RATIO, **values | {"recording": np.full(size, number, dtype=np.int64)})  # type: ignore[arg-type]


@dataclass(frozen=True)
class Campaign:
    """Recordings' rows, the fold of each recording, which rows are of slow ones, which of those held out."""

    rows: Rows
    folds: IntArray
    slow: NDArray[np.bool_]
    held_out: NDArray[np.bool_]

    def left(self, prediction: FloatArray, rows: NDArray[np.bool_]) -> float:
        """What a prediction (n,) leaves of a sample in some rows (n,), over the noise."""
        squares = (self.rows.y - prediction) ** 2 * self.rows.number
        return float(np.sqrt(np.mean(squares[rows])) / NOISE)


def campaign(whole: dict[float, int], concealed: float = 0.0) -> Campaign:
    """So many ``whole`` revolutions in each direction, at loads in turn; slow recordings of a tenth to a third of one,
    some held out. ``concealed``: amplitude of an order that the simulation does not have.
    """
    rng = np.random.default_rng(3)
    parts: list[Frame] = []
    fold: list[int] = []

    def record(speed: float, torque: float, warmth: tuple[float, float], turns: float, held_out: bool) -> None:
        temperature, begin = float(rng.uniform(*warmth)), float(rng.uniform(-3.0, 3.0))
        fold.append(-1 if held_out else len(fold))
        parts.append(steady(len(parts), speed, torque, temperature, turns, begin))

    for side, number in whole.items():
        for torque in np.linspace(-900.0, 900.0, number):
            record(side * FAST, float(torque), (28.0, 36.0), 1.02, False)
        for speed in np.linspace(SLOWEST, LESS_SLOW, SLOW_PARTS):
            record(side * speed, rng.uniform(-900.0, 900.0), (24.0, 42.0), rng.uniform(0.1, 0.33), False)
        for speed in rng.uniform(1.1 * SLOWEST, 0.95 * LESS_SLOW, HELD_OUT):
            record(side * speed, rng.uniform(-800.0, 800.0), (26.0, 40.0), rng.uniform(0.1, 0.33), True)
    frame, folds = concatenate(parts), np.asarray(fold, dtype=np.int64)
    y = true(frame) + concealed * np.sin(CONCEALED * frame.theta)
    y += NOISE / np.sqrt(frame.count) * rng.normal(size=frame.size)
    within = NOISE**2 * rng.chisquare(frame.count - 1.0) / frame.count
    rows = Rows(frame, y, frame.count, within, np.zeros(frame.size), np.zeros(frame.size))
    return Campaign(rows, folds, np.abs(frame.velocity) < 0.9 * FAST, folds[frame.recording] < 0)


def analysed(own: Campaign, parts: bool = True) -> TransmissionModel:
    """The model of a campaign; without ``parts`` the series is that of whole revolutions and of the offset's rows."""
    model = begun(own.rows, own.folds, GivenOrders(ORDERS), nominal_base(TRANSMISSION_ERROR, ()))
    assert len(model.parts) == SLOW_PARTS * len({p.direction for p in model.parts})
    if not parts:
        model.parts = ()
    analyse(model, 0)
    learn(model, 0)
    return model


def predicted(model: TransmissionModel) -> FloatArray:
    """Periodic part and offset at a model's rows (n,)."""
    assert model.periodic is not None
    assert model.offset is not None
    frame = model.rows.frame
    return model.periodic.evaluate(frame) + model.offset.model.predict(frame)


def told(own: Campaign, model: TransmissionModel) -> ChannelOutcome:
    """What a report would say."""
    held_out = set(np.flatnonzero(own.folds < 0).tolist())
    data = SimpleNamespace(gearbox=Gearbox(RATIO), held_out=lambda: held_out, auxiliary_units={}, linear=False)
    return of_transmission(model, cast("Any", data), 0, False)


@pytest.fixture(scope="module")
def both() -> Campaign:
    """Eight whole revolutions in each direction."""
    return campaign({1.0: 8, -1.0: 8})


def test_slow_recordings_are_left_with_their_noise_and_nothing_is_named(both: Campaign) -> None:
    model = analysed(both)
    outcome = told(both, model)
    assert outcome.discoveries == []
    assert model.seen is not None
    assert model.seen.orders == ORDERS
    np.testing.assert_array_equal(outcome.whole, predicted(model))
    assert np.array_equal(outcome.held_out, both.held_out)
    assert both.left(outcome.whole, both.slow & ~both.held_out) < 1.05
    assert both.left(outcome.whole, both.held_out) < 1.1
    assert both.left(outcome.whole, ~both.slow) < 1.05
    assert outcome.floor == pytest.approx(NOISE, rel=0.02)


def test_whole_revolutions_alone_say_nothing_of_another_speed(both: Campaign, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turns, "LEARNT", np.inf)
    prediction = predicted(analysed(both, parts=False))
    assert both.left(prediction, ~both.slow) < 1.05
    assert both.left(prediction, both.slow & ~both.held_out) > 5.0
    assert both.left(prediction, both.held_out) > 5.0


def test_the_offsets_rows_teach_the_series_what_parts_leave_open(
    both: Campaign, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Level and line of a part are free where it refines the series: its lowest orders are told by the offset."""
    monkeypatch.setattr(turns, "LEARNT", np.inf)
    prediction = predicted(analysed(both))
    assert both.left(prediction, both.slow & ~both.held_out) > 1.15
    assert both.left(prediction, both.held_out) > 1.15


@pytest.mark.parametrize("whole", [{1.0: 2}, {-1.0: 3}, {1.0: 2, -1.0: 2}], ids=["two", "three-backwards", "two-each"])
def test_few_whole_revolutions_calibrate_the_series(whole: dict[float, int]) -> None:
    """Alone they leave more than fourteen times the noise of recordings held out."""
    own = campaign(whole)
    model = analysed(own)
    assert model.periodic is not None
    assert model.periodic.series.orders == ORDERS
    assert set(model.periodic.series.amplitude) == {int(side) for side in whole}
    prediction = predicted(model)
    assert own.left(prediction, own.slow & ~own.held_out) < 1.1
    assert own.left(prediction, own.held_out) < 2.0
    assert told(own, model).discoveries == []


def test_an_order_that_is_concealed_is_named_and_nothing_else() -> None:
    own = campaign({1.0: 8}, WAVE)
    (found,) = told(own, analysed(own)).discoveries
    assert found.effect == "te.harmonic"
    assert found.orders == (CONCEALED,)


def test_rows_of_a_direction_without_a_whole_revolution_calibrate_no_offset() -> None:
    """Their waves are in them: they are no part of what the offset is fitted to."""
    own = campaign({1.0: 6, -1.0: 0})
    model = analysed(own)
    assert model.offset is not None
    problem = model.offset.model.problem
    assert problem.usable.any()
    assert not np.any(problem.usable & (problem.rows.frame.direction < 0))
    assert told(own, model).discoveries == []


def test_a_series_is_no_surer_for_rows_that_are_asked_again(both: Campaign, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(turns, "LEARNT", 0.0)
    monkeypatch.setattr(turns, "LEARNINGS", 1)
    once = analysed(both).periodic
    monkeypatch.setattr(turns, "LEARNINGS", 3)
    thrice = analysed(both).periodic
    assert once is not None
    assert thrice is not None
    assert np.array_equal(once.series.covariance[1], thrice.series.covariance[1])
    assert not np.array_equal(once.series.amplitude[1], thrice.series.amplitude[1])
