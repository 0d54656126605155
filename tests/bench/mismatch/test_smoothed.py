"""Rates at the corners of a speed profile and where cycles were lost."""

from __future__ import annotations

import numpy as np

from bench.mismatch.recordings.prepared import _pieces
from bench.mismatch.recordings.smoothing import smoothed

RATE, SPAN = 500.0, 0.06
RAMP = 300
"""samples of the ramp, to 30 rad/s at 50 rad/s²"""


def test_a_steady_segment_does_not_feel_the_ramp_before_it() -> None:
    time = np.arange(900) / RATE
    begin = RAMP / RATE
    angle = np.where(time < begin, 25.0 * time**2, 25.0 * begin**2 + 50.0 * begin * (time - begin))
    label = np.where(np.arange(900) < RAMP, -1, 0)
    _, plain, felt = smoothed(angle, RATE, SPAN, [])
    _, speed, acceleration = smoothed(angle, RATE, SPAN, _pieces(time, RATE, label))
    steady = slice(RAMP, 900)
    assert np.max(np.abs(felt[steady])) > 5.0
    assert np.max(np.abs(acceleration[steady])) < 1e-6
    assert np.max(np.abs(speed[steady] - 50.0 * begin)) < 1e-6 < np.max(np.abs(plain[steady] - 50.0 * begin))


def test_a_lost_cycle_is_no_acceleration() -> None:
    time = np.delete(np.arange(900) / RATE, 450)
    angle = 30.0 * time
    label = np.zeros(time.size, dtype=np.int64)
    assert np.max(np.abs(smoothed(angle, RATE, SPAN, [])[2])) > 20.0
    assert np.max(np.abs(smoothed(angle, RATE, SPAN, _pieces(time, RATE, label))[2])) < 1e-5


def test_one_piece_is_smoothed_as_a_whole() -> None:
    time = np.arange(900) / RATE
    assert _pieces(time, RATE, np.full(900, -1)) == []
