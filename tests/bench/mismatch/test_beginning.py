"""What the first seconds of a recording tell of the temperature it begins with."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np

from bench.mismatch.recordings.beginning import START_S, at_start
from bench.simulation.frame import Frame

RECORDINGS, RATE_HZ, MEMORY_S = 400, 20.0, 0.5


def _frame(duration_s: float) -> tuple[Frame, int]:
    each = int(duration_s * RATE_HZ)
    time = np.tile(np.arange(each) / RATE_HZ, RECORDINGS)
    recording = np.repeat(np.arange(RECORDINGS), each)
    return cast(Frame, SimpleNamespace(recording=recording, time=time + 1e3 * recording, size=time.size)), each


def _thermometer(each: int, rng: np.random.Generator) -> np.ndarray:
    """Noise of standard deviation 1 that forgets itself over ``MEMORY_S`` (autoregressive, first order)."""
    kept = np.exp(-1.0 / RATE_HZ / MEMORY_S)
    noise = rng.normal(size=(RECORDINGS, each))
    for k in range(1, each):
        noise[:, k] = kept * noise[:, k - 1] + np.sqrt(1.0 - kept**2) * noise[:, k]
    return noise.ravel()


def test_correlated_noise_moves_the_start_by_less_than_a_third_of_itself() -> None:
    frame, each = _frame(40.0)
    wrong = at_start(frame, _thermometer(each, np.random.default_rng(3)))
    # variance of what is left of a recording grows by the square of this
    assert np.std(wrong) < 0.3


def test_the_start_is_that_of_the_first_seconds_alone() -> None:
    frame, each = _frame(40.0)
    later = np.tile(np.where(np.arange(each) / RATE_HZ > START_S, 5.0, 1.0), RECORDINGS)
    assert np.allclose(at_start(frame, later), 1.0)


def test_a_recording_shorter_than_that_is_averaged_as_a_whole() -> None:
    frame, each = _frame(START_S / 3.0)
    assert np.allclose(at_start(frame, np.tile(np.linspace(0.0, 2.0, each), RECORDINGS)), 1.0)
