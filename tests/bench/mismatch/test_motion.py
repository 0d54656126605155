"""Corners of a speed profile."""

import numpy as np

from bench.mismatch.recordings.motion import corners

RATE = 500.0


def acceleration(*levels: float) -> np.ndarray:
    return np.repeat(np.asarray(levels, dtype=np.float64), 300)


def test_a_ramp_has_corners_where_it_begins_and_ends() -> None:
    found = np.flatnonzero(corners(acceleration(0.0, 60.0, 0.0, 0.0), RATE, 0.06))
    assert {300, 600} <= set(found.tolist())
    assert not {150, 450, 899} & set(found.tolist())


def test_a_recording_that_begins_on_a_ramp_begins_with_a_corner() -> None:
    marked = corners(acceleration(60.0, 0.0, 0.0, 0.0), RATE, 0.06)
    assert marked[0]
    assert marked[300]
    assert not marked[150]
    assert not corners(acceleration(0.0, 0.0, 60.0, 0.0), RATE, 0.06)[0]
