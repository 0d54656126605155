"""Rates at the corners of a speed profile and where cycles were lost."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.recordings.runs import WIDEST_BRIDGE, Runs, smoothed
from bench.mismatch.recordings.smoothing import window

RATE, SPAN = 500.0, 0.06
RAMP = 300
"""samples of the ramp, to 30 rad/s at 50 rad/s²"""
SHORT = 15
"""samples between lost cycles and the end of a ramp: half a window"""


def test_a_steady_segment_does_not_feel_the_ramp_before_it() -> None:
    time = np.arange(900) / RATE
    begin = RAMP / RATE
    angle = np.where(time < begin, 25.0 * time**2, 25.0 * begin**2 + 50.0 * begin * (time - begin))
    label = np.where(np.arange(900) < RAMP, -1, 0)
    _, plain, felt = smoothed(angle, SPAN, Runs.whole(900, RATE))
    _, speed, acceleration = smoothed(angle, SPAN, Runs.of(time, RATE, SPAN, label))
    steady = slice(RAMP, 900)
    assert np.max(np.abs(felt[steady])) > 5.0
    assert np.max(np.abs(acceleration[steady])) < 1e-6
    assert np.max(np.abs(speed[steady] - 50.0 * begin)) < 1e-6 < np.max(np.abs(plain[steady] - 50.0 * begin))


def test_a_lost_cycle_is_no_acceleration() -> None:
    time = np.delete(np.arange(900) / RATE, 450)
    angle = 30.0 * time
    label = np.zeros(time.size, dtype=np.int64)
    assert np.max(np.abs(smoothed(angle, SPAN, Runs.whole(899, RATE))[2])) > 20.0
    assert np.max(np.abs(smoothed(angle, SPAN, Runs.of(time, RATE, SPAN, label))[2])) < 1e-5


def test_one_piece_is_smoothed_as_a_whole() -> None:
    time = np.arange(900) / RATE
    runs = Runs.of(time, RATE, SPAN, np.full(900, -1))
    assert runs.pieces == ()
    assert not runs.unknown.any()


@pytest.mark.parametrize("lost", [1, 5])
def test_a_piece_shorter_than_a_window_has_its_rates_over_the_time_that_lost_cycles_took(lost: int) -> None:
    label = np.where(np.arange(900) < RAMP, 1, 0)
    gone = slice(RAMP - SHORT - lost, RAMP - SHORT)
    time, label = (np.delete(values, gone) for values in (np.arange(900) / RATE, label))
    piece = slice(RAMP - SHORT - lost, RAMP - lost)
    angle = 3.0 * time
    runs = Runs.of(time, RATE, SPAN, label)
    assert piece in runs.pieces
    _, speed, acceleration = smoothed(angle, SPAN, runs)
    assert np.max(np.abs(speed[piece] - 3.0)) < 1e-9
    assert np.max(np.abs(acceleration[piece])) < 1e-6
    assert not runs.unknown.any()


@pytest.mark.parametrize("more", [False, True])
def test_where_many_cycles_were_lost_a_short_piece_has_no_rates(more: bool) -> None:
    lost = int(WIDEST_BRIDGE * window(RATE, SPAN)) + int(more)
    label = np.where(np.arange(900) < RAMP, 1, 0)
    gone = slice(RAMP - SHORT - lost, RAMP - SHORT)
    time, label = (np.delete(values, gone) for values in (np.arange(900) / RATE, label))
    unknown = Runs.of(time, RATE, SPAN, label).unknown
    assert np.flatnonzero(unknown).tolist() == (list(range(gone.start, gone.start + SHORT)) if more else [])


def test_a_bridge_takes_little_of_an_acceleration() -> None:
    lost = int(WIDEST_BRIDGE * window(RATE, SPAN))
    time = np.delete(np.arange(900) / RATE, slice(450 - lost, 450))
    runs = Runs(RATE, np.rint(time * RATE).astype(np.int64), (), np.zeros(time.size, dtype=bool))
    acceleration = smoothed(25.0 * time**2, SPAN, runs)[2]
    assert 0.9 * 50.0 < acceleration.min() < acceleration.max() < 1.1 * 50.0


def test_hours_between_two_samples_are_no_hours_of_samples() -> None:
    time = np.concatenate([np.arange(100), np.arange(100) + 1e7]) / RATE
    runs = Runs.of(time, RATE, SPAN, np.full(200, -1))
    assert runs.at[-1] < 200 + 2 * window(RATE, SPAN)
    assert np.max(np.abs(smoothed(3.0 * (time % 1e3), SPAN, runs)[2])) < 1e-3
