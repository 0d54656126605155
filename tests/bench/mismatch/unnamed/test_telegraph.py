"""Telegraphs: jumps between two levels are told from Gaussian noise of the same spectrum, and from spikes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.unnamed.structure import _of_telegraph
from bench.mismatch.unnamed.telegraph import Telegraph, telegraph
from bench.simulation.frame import FloatArray, Frame
from tests.bench.mismatch.regression.synthetic import EACH, campaign, problem

SIGMA = 0.05
HEIGHT = 0.2
STAY_S = 12.0
FRAME = campaign(24)


def looked(left: FloatArray, frame: Frame = FRAME) -> Telegraph | None:
    model: Any = SimpleNamespace(
        problem=problem(frame, left), blocks=list, predict=lambda frame: np.zeros(frame.size), floor=SIGMA
    )
    search: Any = SimpleNamespace(model=model)
    return telegraph(search)


def white(seed: int) -> FloatArray:
    offsets = np.random.default_rng([seed, 1]).normal(scale=HEIGHT, size=FRAME.size // EACH)
    return np.random.default_rng(seed).normal(scale=SIGMA, size=FRAME.size) + np.repeat(offsets, EACH)


def jumps(seed: int) -> FloatArray:
    changes = np.random.default_rng([seed, 2]).random(FRAME.size) < 1.0 - np.exp(-1.0 / STAY_S)
    return (np.cumsum(changes) % 2).astype(np.float64)


@pytest.mark.parametrize("seed", range(3))
def test_jumps_of_a_friction_are_found_with_their_height_and_their_stays(seed: int) -> None:
    own = jumps(seed)
    found = looked(HEIGHT * own * FRAME.direction + white(seed))
    assert found is not None
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    # half of the bins in each level; a rate is known to one over the root of its jumps
    assert found.height == pytest.approx(HEIGHT, abs=5.0 * SIGMA * np.sqrt(4.0 / FRAME.size))
    for stay in found.stays:
        assert stay == pytest.approx(STAY_S, abs=4.0 * STAY_S / np.sqrt(0.5 * FRAME.size / STAY_S))
    true = HEIGHT * own * FRAME.direction
    true = true - np.repeat(true.reshape(-1, EACH).mean(axis=1), EACH)
    assert np.corrcoef(found.course, true)[0, 1] > 0.9


@pytest.mark.parametrize("every", [1, 3])
def test_jumps_lie_where_they_were_found(every: int) -> None:
    """The channel may be compared at other rows than those in which they were."""
    course = np.where(FRAME.recording == 2, HEIGHT, 0.0)
    compared = FRAME.take(np.arange(0, FRAME.size, every))
    outcome: Any = SimpleNamespace(
        floor=SIGMA,
        channel="transmission_error",
        rows=SimpleNamespace(frame=compared, size=compared.size),
        rmse={},
    )
    found = _of_telegraph(Telegraph("1", HEIGHT, (9.0, 9.0), 1e-4, course), outcome, FRAME)
    assert np.array_equal(found.beyond != 0.0, compared.recording == 2)


@pytest.mark.parametrize("seed", range(4))
def test_gaussian_noise_of_the_same_spectrum_is_no_telegraph(seed: int) -> None:
    rng = np.random.default_rng([seed, 3])
    # a telegraph's covariance is exponential with half of its mean stay
    kept = np.exp(-2.0 / STAY_S)
    course = np.zeros(FRAME.size)
    for k, step in enumerate(rng.normal(scale=0.5 * HEIGHT, size=FRAME.size)):
        course[k] = kept * course[k - 1] * (k % EACH > 0) + np.sqrt(1.0 - kept**2 * (k % EACH > 0)) * step
    found = looked(course + white(seed))
    assert found is None or found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL


def test_jumps_below_what_is_reported_of_anything_are_not_looked_at() -> None:
    assert looked(0.2 * SIGMA * jumps(0) + white(0)) is None


@pytest.mark.parametrize("seed", range(4))
def test_spikes_and_heavy_tails_are_no_telegraph(seed: int) -> None:
    rng = np.random.default_rng([seed, 4])
    spikes = np.where(rng.random(FRAME.size) < 0.03, 6.0 * SIGMA, 0.0)
    found = looked(SIGMA * rng.standard_t(4.0, size=FRAME.size) + spikes)
    assert found is None or found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL


def test_a_few_jumps_up_and_as_many_down_are_enough() -> None:
    """A jump in two recordings of three: eight up and eight down in the campaign."""

    def jumping(recordings: list[int]) -> FloatArray:
        changes = np.zeros(FRAME.size, dtype=bool)
        changes[[EACH * number + EACH // 2 for number in recordings]] = True
        return (np.cumsum(changes) % 2).astype(np.float64)

    found = looked(HEIGHT * jumping([number for number in range(24) if number % 3]) + white(0))
    assert found is not None
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert looked(HEIGHT * jumping([0, 5, 12, 17]) + white(0)) is None


def test_offsets_of_recordings_that_reverse_are_no_jumps() -> None:
    """Times the direction, a recording's offset changes its sign at every reversal: it stays all the same."""
    rng = np.random.default_rng(5)
    run = EACH // 2
    back_and_forth = np.where((np.arange(FRAME.size) % EACH) // run % 2 == 0, 1.0, -1.0)
    frame = replace(FRAME, direction=back_and_forth)
    offsets = np.repeat(rng.choice([-0.5, 0.5], FRAME.size // EACH) * HEIGHT, EACH)
    found = looked(offsets + rng.normal(scale=SIGMA, size=FRAME.size), frame)
    assert found is None or found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL
