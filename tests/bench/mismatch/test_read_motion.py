"""The motion of the motor, of which an eccentric encoder reads the derivatives of its error as well."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.given import Given
from bench.mismatch.prediction import Predictor
from bench.mismatch.read_motion import without_misread_motion
from bench.mismatch.recordings.smoothing import local_quadratic
from bench.simulation.frame import ARRAYS, FloatArray, Frame, concatenate
from bench.simulation.model import FORMAT, FORMAT_VERSION, Simulation
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE
from bench.simulation.waves import Wave, evaluate

RATE, SPAN, RATIO, GROUP = 1000.0, 0.06, 100.0, 10
WAVE = Wave(RATIO, "1", 2e-5, -3e-5)
"""once a revolution of the motor"""


def moving(size: int, count: float, rate: float = RATE) -> Frame:
    """Rows of one recording, of which only a test's own quantities count."""
    values: dict[str, FloatArray] = {name: np.zeros(size) for name in ARRAYS}
    values |= {"count": np.full(size, count), "step": np.full(size, count / rate)}
    return Frame(ratio=RATIO, **values | {"recording": np.zeros(size, dtype=np.int64)})  # type: ignore[arg-type]


def read(misread: bool, rate: float = RATE) -> Frame:
    """A ramp of the speed, in rows of ten samples; with or without the encoder's error."""
    time = np.arange(round(4.0 * rate)) / rate
    theta = 0.02 * time + 0.5 * 0.1 * time**2
    error = evaluate([WAVE], theta, moving(theta.size, 1.0, rate)) if misread else np.zeros(theta.size)
    # the transmission error is the output less the motor: what it shows the motor's angle lacks
    _, speed, change = local_quadratic(theta - error, rate, SPAN)

    def rows(values: FloatArray) -> FloatArray:
        return np.asarray(values.reshape(-1, GROUP).mean(axis=1))

    frame = moving(theta.size // GROUP, float(GROUP), rate)
    return replace(frame, theta=rows(theta), velocity=rows(speed), acceleration=RATIO * rows(change))


def test_what_an_encoder_misreads_moves_no_rotor() -> None:
    inner = slice(10, -10)
    true, seen = read(False), read(True)
    off = np.abs(seen.acceleration - true.acceleration)[inner].max()
    left = without_misread_motion(seen, (WAVE,), SPAN)
    assert off > 5.0
    assert np.abs(left.acceleration - true.acceleration)[inner].max() < 0.05 * off
    off = np.abs(seen.velocity - true.velocity)[inner].max()
    assert np.abs(left.velocity - true.velocity)[inner].max() < 0.1 * off


def test_a_slower_recording_is_read_at_its_own_rate() -> None:
    """A row of ten samples lasts ten times as long there."""
    fast, slow = read(True), read(True, 100.0)
    slow = replace(slow, recording=np.ones(slow.size, dtype=np.int64))
    left = without_misread_motion(concatenate([fast, slow]), (WAVE,), SPAN)
    alone = without_misread_motion(replace(slow, recording=np.zeros(slow.size, dtype=np.int64)), (WAVE,), SPAN)
    assert left.acceleration[fast.size :] == pytest.approx(alone.acceleration)
    true, inner = read(False, 100.0), slice(2, -2)
    off, after = (np.abs(one.acceleration - true.acceleration)[inner].max() for one in (slow, alone))
    assert after < 0.3 * off


def test_a_file_with_an_encoder_error_predicts_the_motor_torque_of_the_true_motion() -> None:
    seen = read(True)
    rows = [{"effect": "sensor.motor_encoder", "channels": ["transmission_error"], "waves": [WAVE.to_json()]}]
    file = {"format": FORMAT, "format_version": FORMAT_VERSION, "gearbox": {"ratio": RATIO}, "terms": rows}
    predictor = Predictor(Given.of(Simulation.from_json(file)))
    moved = predictor.moved(MOTOR_TORQUE, seen, SPAN)
    assert moved.acceleration == pytest.approx(without_misread_motion(seen, (WAVE,), SPAN).acceleration)
    assert predictor.moved(LOAD_TORQUE, seen, SPAN) is seen
