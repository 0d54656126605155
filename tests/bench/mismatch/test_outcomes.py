"""How sure the noise of a sample is."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.outcomes import floor_error
from bench.mismatch.recordings.vibration import Density

RATE, BINS = 500.0, 128


def densities(count: int, spread: float, seed: int = 1) -> list[Density]:
    """Spectra of white noise of 1 unit, whose size differs from recording to recording by a ``spread``."""
    rng = np.random.default_rng(seed)
    step = 0.5 * RATE / BINS
    out = []
    for number in range(count):
        size = 1.0 + rng.normal(0.0, spread)
        power = size**2 * 2.0 / RATE * rng.chisquare(40.0, BINS) / 40.0
        out.append(Density(number, power, step, 20.0, RATE, 0.1))
    return out


def test_a_few_recordings_tell_how_sure_the_noise_is_as_many_do() -> None:
    """Twelve leave groups of two, which are too few by themselves."""
    few = [floor_error(densities(12, 0.05, seed)) for seed in range(12)]
    many = [floor_error(densities(60, 0.05, seed)) for seed in range(12)]
    assert None not in few
    assert None not in many
    small, large = (float(np.median([e for e in one if e is not None])) for one in (few, many))
    # of a mean it would be 0.05 / sqrt(12) and 0.05 / sqrt(60)
    assert small == pytest.approx(0.05 / np.sqrt(12.0), rel=0.5)
    assert large == pytest.approx(0.05 / np.sqrt(60.0), rel=0.5)


def test_too_few_recordings_do_not_tell() -> None:
    assert floor_error(densities(3, 0.05)) is None
    assert floor_error([]) is None
