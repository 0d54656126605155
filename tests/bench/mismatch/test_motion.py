"""Corners of a speed profile, and noise that forgets itself where rows are missing."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np

from bench.mismatch.motion import corners
from bench.mismatch.noise import _steps

RATE = 500.0


def acceleration(*levels: float) -> np.ndarray:
    return np.repeat(np.asarray(levels, dtype=np.float64), 300)


def test_a_ramp_has_corners_where_it_begins_and_ends() -> None:
    found = np.flatnonzero(corners(acceleration(0.0, 60.0, 0.0, 0.0), RATE))
    assert {300, 600} <= set(found.tolist())
    assert not {150, 450, 899} & set(found.tolist())


def test_a_recording_that_begins_on_a_ramp_begins_with_a_corner() -> None:
    marked = corners(acceleration(60.0, 0.0, 0.0, 0.0), RATE)
    assert marked[0]
    assert marked[300]
    assert not marked[150]
    assert not corners(acceleration(0.0, 0.0, 60.0, 0.0), RATE)[0]


def test_rows_that_are_missing_between_two_count() -> None:
    frame = cast(Any, SimpleNamespace(elapsed=np.array([0.0, 0.1, 0.2, 0.7, 0.8, 0.0, 0.1])))
    steps = _steps(frame, np.ones(7, dtype=bool))
    np.testing.assert_allclose(steps, [1.0, 1.0, 1.0, 5.0, 1.0, 8.0, 1.0])
