"""Rates at the corners of a speed profile and where cycles were lost."""

from __future__ import annotations

import numpy as np

from bench.mismatch.recordings.prepared import _pieces, _smoothed
from bench.mismatch.recordings.smoothing import local_quadratic, span_for

RATE, SPAN = 500.0, 0.06
RAMP = 300
"""samples of the ramp, to 30 rad/s at 50 rad/s²"""


def test_a_steady_segment_does_not_feel_the_ramp_before_it() -> None:
    time = np.arange(900) / RATE
    begin = RAMP / RATE
    angle = np.where(time < begin, 25.0 * time**2, 25.0 * begin**2 + 50.0 * begin * (time - begin))
    label = np.where(np.arange(900) < RAMP, -1, 0)
    _, plain, felt = _smoothed(angle, RATE, SPAN, [])
    _, speed, acceleration = _smoothed(angle, RATE, SPAN, _pieces(time, RATE, label))
    steady = slice(RAMP, 900)
    assert np.max(np.abs(felt[steady])) > 5.0
    assert np.max(np.abs(acceleration[steady])) < 1e-6
    assert np.max(np.abs(speed[steady] - 50.0 * begin)) < 1e-6 < np.max(np.abs(plain[steady] - 50.0 * begin))


def test_a_lost_cycle_is_no_acceleration() -> None:
    time = np.delete(np.arange(900) / RATE, 450)
    angle = 30.0 * time
    label = np.zeros(time.size, dtype=np.int64)
    assert np.max(np.abs(_smoothed(angle, RATE, SPAN, [])[2])) > 20.0
    assert np.max(np.abs(_smoothed(angle, RATE, SPAN, _pieces(time, RATE, label))[2])) < 1e-5


def test_one_piece_is_smoothed_as_a_whole() -> None:
    time = np.arange(900) / RATE
    assert _pieces(time, RATE, np.full(900, -1)) == []


def test_a_shaft_that_shakes_is_no_coarse_encoder() -> None:
    rng = np.random.default_rng(2)
    time = np.arange(4000) / 1000.0
    turning = 2.0 * time + 0.3 * np.sin(3.0 * time)
    coarse = turning + rng.normal(0.0, 4e-4, time.size)
    # the same encoder on a rotor that its cogging shakes at 60 Hz, with 1.4e3 rad/s²
    shaken = coarse + 0.01 * np.sin(2.0 * np.pi * 60.0 * time)
    assert span_for(coarse, 1000.0, 0.3) == 0.06
    assert span_for(shaken, 1000.0, 0.3) == 0.015
    kept = local_quadratic(shaken, 1000.0, 0.015)[2]
    assert np.sqrt(2.0) * np.std(kept) > 0.5 * 0.01 * (2.0 * np.pi * 60.0) ** 2
