"""Noise from spectra: the size that was put in, whatever lines stand in it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.noise import (
    MEMORIES_S,
    Mixture,
    durations,
    middle_variance,
    mixture,
    plain_mixture,
    usual_rate,
)
from bench.simulation.frame import ARRAYS, FloatArray, Frame
from tests.bench.mismatch.spectra import densities


def found(**what: object) -> Mixture:
    own = mixture(densities(3, **what))  # type: ignore[arg-type]
    assert own is not None
    return own


def test_white_noise_is_white() -> None:
    own = found(white=4.0)
    assert own.variance == pytest.approx(4.0, rel=0.05)
    assert own.white == pytest.approx(4.0, rel=0.08)


def test_a_mixture_is_recovered() -> None:
    own = found(white=1.0, slow=2.0, memory=0.3)
    assert own.white == pytest.approx(1.0, rel=0.08)
    assert sum(own.parts) == pytest.approx(2.0, rel=0.15)
    time = float(np.dot(own.parts, MEMORIES_S) / sum(own.parts))
    assert 0.15 < time < 0.6


def test_physics_in_a_few_bins_is_no_noise() -> None:
    own = found(white=1.0, order=(900.0, 3.0))
    assert own.variance == pytest.approx(1.0, rel=0.06)


def test_means_scatter_as_the_mixture_says() -> None:
    own = Mixture(1.0, (0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0), 100.0)
    rng = np.random.default_rng(5)
    keep = np.exp(-1.0 / (100.0 * 0.1))
    values = np.zeros((4000, 50))
    state = rng.normal(size=4000) * np.sqrt(2.0)
    for k in range(50):
        values[:, k] = state + rng.normal(size=4000)
        state = keep * state + np.sqrt(2.0 * (1.0 - keep**2)) * rng.normal(size=4000)
    told = own.of_means(np.array([50.0]), np.array([0.5]))[0]
    assert np.var(values.mean(axis=1)) == pytest.approx(told, rel=0.08)


@pytest.mark.parametrize("number", [1, 2, 3, 10, 99, 101])
@pytest.mark.parametrize("apart", [0.004, 0.0099, 0.0101, 0.05, 0.5])
def test_means_of_few_samples_scatter_as_the_mixture_says(apart: float, number: int) -> None:
    """Samples that are further apart than the noise remembers are independent, however long they take."""
    memory = 0.1
    own = Mixture(0.0, (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), 100.0)
    between = np.abs(np.subtract.outer(np.arange(number), np.arange(number))) * apart
    expected = float(np.exp(-between / memory).mean())
    told = own.of_means(np.full(1, float(number)), np.full(1, number * apart))[0]
    assert told == pytest.approx(expected, rel=0.002)


def test_too_few_spectra_tell_nothing() -> None:
    assert mixture(densities(1, recordings=2)) is None


def mixed(rng: np.random.Generator, memory: float, quick: float = 250.0, slow: float = 5.0) -> Rows:
    """Rows of two seconds: ten recordings at a quick rate, two long ones at a slow one; noise of 1 with a memory (s).
    A minute lies between the recordings, which the first step of each has.
    """
    parts: list[dict[str, FloatArray]] = []
    for k in range(12):
        rate, seconds = (quick, 60) if k < 10 else (slow, 1200)
        n = int(rate * seconds)
        keep = np.exp(-1.0 / (rate * memory)) if memory else 0.0
        noise = lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], rng.normal(size=n))
        blocks = noise.reshape(seconds // 2, -1)
        count = np.full(len(blocks), float(blocks.shape[1]))
        parts.append(
            {
                "y": blocks.mean(axis=1),
                "within": blocks.var(axis=1),
                "count": count,
                "step": np.append(60.0, np.full(len(blocks) - 1, 2.0)),
                "elapsed": np.arange(len(blocks)) * 2.0,
                "recording": np.full(len(blocks), float(k)),
            }
        )
    joined = {name: np.concatenate([p[name] for p in parts]) for name in parts[0]}
    zeros = {name: np.zeros(joined["y"].size) for name in ARRAYS}
    own = {name: joined[name] for name in ("count", "step", "elapsed")}
    frame = Frame(ratio=185.0, **{**zeros, **own, "recording": joined["recording"].astype(np.int64)})  # type: ignore[arg-type]
    return Rows(frame, joined["y"], joined["count"], joined["within"])


def test_the_rate_is_that_of_most_samples_and_each_row_lasts_as_long_as_it_does() -> None:
    rows = mixed(np.random.default_rng(0), 0.5)
    assert usual_rate(rows.frame) == pytest.approx(250.0)
    assert np.allclose(durations(rows.frame), 2.0)


@pytest.mark.parametrize("memory", [0.5, 0.0])
def test_rows_of_a_slow_recording_are_as_sure_as_the_noise_lets_them(memory: float) -> None:
    """Noise slower than the slow samples is averaged as much by ten of them as by five hundred; white noise is not."""
    rows = mixed(np.random.default_rng(1), memory)
    noise = plain_mixture(rows, rows.y, slow=True)
    variance = noise.of_means(rows.number, durations(rows.frame))
    slow = rows.frame.recording >= 10
    for own in (slow, ~slow):
        assert variance[own][0] == pytest.approx(float(np.var(rows.y[own])), rel=0.4)


@pytest.mark.parametrize("number", [2, 3, 5, 30])
def test_the_middle_of_few_samples_scatter_is_the_variance_all_the_same(number: int) -> None:
    drawn = np.random.default_rng(2).normal(0.0, 3.0, (4000, number)).var(axis=1, ddof=1)
    assert middle_variance(drawn, np.full(4000, number - 1.0)) == pytest.approx(9.0, rel=0.06)


@pytest.mark.parametrize("memory", [7.0, 20.0])
def test_a_thermometer_may_remember_for_half_a_minute(memory: float) -> None:
    """A mean over twenty seconds is hardly less noisy than a reading; a drift beside it is no noise."""
    rows = mixed(np.random.default_rng(4), memory)
    drifting = rows.y + 0.003 * rows.frame.elapsed
    noise = plain_mixture(rows, drifting, slow=True)
    told = noise.of_means(np.full(1, 5000.0), np.full(1, 20.0))[0]
    x = 20.0 / memory
    # ten recordings of a minute hold few such times
    assert 0.35 < told / (2.0 * (x - 1.0 + np.exp(-x)) / x**2) < 1.6
    # torques do not: their physics is as slow
    assert max(m for v, m in zip(*_parts(plain_mixture(rows, drifting)), strict=True) if v > 0.0) <= MEMORIES_S[-1]


def _parts(noise: Mixture) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return noise.parts, noise.memories
