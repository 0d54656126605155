"""A tone at some speeds: one frequency in common at more of them than chance puts there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.unnamed.some_speeds import at_some_speeds
from bench.mismatch.unnamed.tones import tone
from tests.bench.mismatch.spectra import densities

SPEEDS, BINS = 24, np.arange(20, 420)


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).chisquare(20, size=(SPEEDS, BINS.size)) / 20.0


@pytest.mark.parametrize("seed", range(10))
def test_noise_has_none(seed: int) -> None:
    found = at_some_speeds(noise(seed), BINS)
    assert found is not None
    assert found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL


@pytest.mark.parametrize("seed", range(10))
def test_lines_at_another_frequency_at_each_speed_are_none(seed: int) -> None:
    """Five orders that nobody knows: three of them at one frequency are no wonder, at some of 400 frequencies."""
    loud = noise(seed)
    rng = np.random.default_rng(100 + seed)
    for row in loud:
        row[rng.choice(BINS.size, 5, replace=False)] += rng.uniform(20.0, 1000.0, 5)
    found = at_some_speeds(loud, BINS)
    assert found is not None
    assert found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL


@pytest.mark.parametrize("lines", [0, 5])
def test_one_frequency_at_a_quarter_of_the_speeds_is_one(lines: int) -> None:
    loud = noise(1)
    rng = np.random.default_rng(2)
    for row in loud:
        row[rng.choice(BINS.size, lines, replace=False)] += 50.0
    loud[:6, 130] += 60.0
    found = at_some_speeds(loud, BINS)
    assert found is not None
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert found.frequency == 130
    assert np.flatnonzero(loud[:, 130] >= found.least).size >= 3


def test_a_frequency_that_was_not_seen_counts_for_nothing() -> None:
    loud = noise(3)
    loud[:, 130] = np.nan
    loud[:2, 130] = 1e6
    found = at_some_speeds(loud, BINS)
    assert found is not None
    assert found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL
    assert at_some_speeds(np.full((SPEEDS, 5), np.nan), np.arange(5)) is None


def test_too_few_speeds_cannot_tell() -> None:
    assert at_some_speeds(noise(4)[:5], BINS) is None


def test_a_tone_in_some_recordings_has_their_amplitude_and_these_are_told() -> None:
    own = [replace(d, rotation_rate=0.01 * 1.1**k) for k, d in enumerate(densities(1))]
    loud = [replace(d, rotation_rate=o.rotation_rate) for d, o in zip(densities(5, tone=(17.3, 0.8)), own, strict=True)]
    found = tone([*loud[:4], *own[4:]], 1)
    assert found is not None
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert not found.everywhere
    assert found.frequency == pytest.approx(17.3, abs=max(3.0 * found.frequency_std, 0.02))
    assert found.amplitude == pytest.approx(0.8, rel=0.1)
    assert set(found.recordings[:4]) == {d.recording for d in loud[:4]}
