"""Of two encoders the less noisy one tells the acceleration: with noise in it an inertia would be fitted too small."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.recordings.prepared import _quieter

ACCELERATION = np.repeat([0.0, 0.35, 0.0, -0.35, 0.0], 400)
"""rad/s² at the output: starts and stops between steady parts"""


def noisy(size: float, seed: int) -> np.ndarray:
    return ACCELERATION + size * np.random.default_rng(seed).normal(size=ACCELERATION.size)


def inertia(column: np.ndarray) -> float:
    """What is fitted of an inertia of 16.5 kg·m²."""
    return float(column @ (16.5 * ACCELERATION) / (column @ column))


@pytest.mark.parametrize("swapped", [False, True])
def test_the_quieter_one_is_taken(swapped: bool) -> None:
    quiet, loud = noisy(0.001, 1), noisy(0.2, 2)
    taken = _quieter(loud, quiet) if swapped else _quieter(quiet, loud)
    assert taken is quiet
    assert inertia(taken) == pytest.approx(16.5, rel=1e-3)
    assert inertia(loud) < 0.75 * 16.5


def test_a_single_sample_is_left_as_it_is() -> None:
    one = np.ones(1)
    assert _quieter(one, 2.0 * one) is one
