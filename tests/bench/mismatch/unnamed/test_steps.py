"""Steps up and down are told from Gaussian noise of any spectrum and from spikes, beside slow waves."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

from bench.mismatch import criteria
from bench.mismatch.unnamed.steps import Steps, steps
from bench.simulation.frame import FloatArray
from tests.bench.mismatch.regression.synthetic import EACH, campaign, problem

SIGMA, HEIGHT = 0.05, 0.6
FRAME = campaign(24)
RECORDINGS = FRAME.size // EACH


def looked(left: FloatArray) -> Steps | None:
    model: Any = SimpleNamespace(
        problem=problem(FRAME, left), blocks=list, predict=lambda frame: np.zeros(frame.size), floor=SIGMA
    )
    return steps(SimpleNamespace(model=model))  # type: ignore[arg-type]


def slow(seed: int, alike: float, size: float = SIGMA) -> FloatArray:
    """Noise of this ``size``, ``alike`` from row to row, anew in each recording."""
    noise = np.random.default_rng(seed).normal(scale=size, size=(RECORDINGS, EACH))
    noise[:, 1:] *= np.sqrt(1.0 - alike**2)
    return np.asarray(lfilter([1.0], [1.0, -alike], noise, axis=1)).ravel()


def waves(seed: int) -> FloatArray:
    """A slow wave in each recording: what orders of the output are off by."""
    phase = np.random.default_rng([seed, 1]).uniform(0.0, 6.28, RECORDINGS)
    return np.asarray(0.3 * HEIGHT * np.sin(2.0 * np.pi * FRAME.elapsed / 40.0 + np.repeat(phase, EACH)))


def up_and_down(which: int = 3) -> FloatArray:
    """In every ``which`` recording the level goes up for a third of the time."""
    third = EACH // 3
    level = np.zeros((RECORDINGS, EACH))
    level[::which, third : 2 * third] = HEIGHT
    return level.ravel()


@pytest.mark.parametrize("seed", range(3))
def test_steps_are_found_beside_slow_waves(seed: int) -> None:
    found = looked(up_and_down() + waves(seed) + slow(seed, 0.0))
    assert found is not None
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert 6 <= found.number <= 2 * -(-RECORDINGS // 3)
    assert found.height == pytest.approx(HEIGHT, rel=0.3)
    own = np.abs(up_and_down().reshape(RECORDINGS, EACH)).max(axis=1) > 0.0
    seen = np.abs(found.course.reshape(RECORDINGS, EACH)).max(axis=1) > 0.0
    assert not np.any(seen & ~own)


@pytest.mark.parametrize("alike", [0.0, 0.6, 0.95])
def test_noise_of_any_spectrum_has_none(alike: float) -> None:
    told = [looked(slow(seed, alike)) for seed in range(24)]
    # of 24 folders of noise, two that are told at one in a hundred are chance in one case of 40
    assert sum(found is not None and found.p_value < 0.01 for found in told) <= 1


def test_recordings_that_are_louder_have_no_steps() -> None:
    loud = np.repeat(np.where(np.arange(RECORDINGS) % 4 == 0, 6.0, 1.0), EACH)
    assert looked(loud * slow(1, 0.3)) is None


def test_spikes_and_one_way_steps_are_none() -> None:
    spikes = slow(2, 0.0)
    spikes[::37] += 40.0 * SIGMA
    assert looked(spikes) is None
    once = np.where(np.tile(np.arange(EACH), RECORDINGS) > EACH // 2, HEIGHT, 0.0)
    assert looked(once + slow(3, 0.0)) is None


def test_a_drift_within_a_recording_has_no_steps() -> None:
    """Up in some recordings and down in others, by far more than the noise from one second to the next."""
    slope = np.repeat(np.where(np.arange(RECORDINGS) % 3 == 0, 1.0, -1.0) * (np.arange(RECORDINGS) % 2), EACH)
    drift = HEIGHT * slope * np.tile(np.arange(EACH), RECORDINGS) / EACH
    assert looked(drift + slow(5, 0.0, 0.02 * SIGMA)) is None
