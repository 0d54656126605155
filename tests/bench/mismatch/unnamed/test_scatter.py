"""Recordings of one state that scatter more than the others, and what else may differ between recordings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.recordings.vibration import Density
from bench.mismatch.regression.search import begun
from bench.mismatch.unnamed.scatter import Scatter, scatter
from bench.mismatch.unnamed.structure import _of_scatter
from bench.mismatch.unnamed.structure import _scatter as of_search
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LOAD_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign, problem
from tests.bench.mismatch.report import made

RECORDINGS, SIGMA, RATE, STEP = 30, 0.05, 500.0, 0.1
FRAME = campaign(RECORDINGS)
STEADY = np.ones(FRAME.size)
SPEED = np.array([abs(FRAME.velocity[FRAME.recording == r][0]) for r in range(RECORDINGS)])
LOAD = np.array([FRAME.torque_level[FRAME.recording == r][0] for r in range(RECORDINGS)])


def densities(factor: FloatArray, seed: int = 0) -> list[Density]:
    """White noise of ``SIGMA`` times the square root of ``factor`` (recordings,), seven segments averaged."""
    rng = np.random.default_rng(seed)
    size = round(0.5 * RATE / STEP) + 1
    level = SIGMA**2 / (0.5 * RATE)
    return [
        Density(r, f * level * rng.chisquare(14.0, size) / 14.0, STEP, 7.0, RATE, SPEED[r] / (2.0 * np.pi))
        for r, f in enumerate(factor)
    ]


def test_what_scatters_at_slow_speed_is_found_with_its_limit() -> None:
    found = scatter(densities(np.where(SPEED < 0.012, 3.0, 1.0)), FRAME, STEADY, 1)
    assert found is not None
    assert (found.quantity, found.side) == ("speed", "below")
    assert found.limit == pytest.approx(0.012, rel=0.15)
    assert set(found.recordings) == set(np.flatnonzero(SPEED < 0.012))
    assert found.louder == pytest.approx(np.sqrt(3.0), rel=0.05)
    assert found.p_value < 2e-3


@pytest.mark.parametrize(("factor", "told"), [(1.9, True), (1.35, False)])
def test_half_as_much_energy_again_is_enough(factor: float, told: bool) -> None:
    """Which is what is told as more than noise everywhere (1.25 times the floor)."""
    found = scatter(densities(np.where(SPEED < 0.012, factor, 1.0)), FRAME, STEADY, 1)
    assert (found is not None) is told


def test_one_recording_that_swings_hides_no_state() -> None:
    factor = np.where(np.abs(LOAD) > 400.0, 2.5, 1.0)
    factor[int(np.argmin(np.abs(LOAD)))] = 1e4
    found = scatter(densities(factor), FRAME, STEADY, 1)
    assert found is not None
    assert (found.quantity, found.side) == ("load", "above")


@pytest.mark.parametrize(("inside", "told"), [(3.0, True), (1.0, False)])
def test_scatter_of_a_torque_inside_the_rows_counts(inside: float, told: bool) -> None:
    """What sticks and slips many times in a row leaves the rows' means as they are."""
    slow = np.where(SPEED < 0.012, inside, 1.0)[FRAME.recording]
    y = 0.5 * FRAME.direction + np.random.default_rng(6).normal(0.0, 0.1 * SIGMA, FRAME.size)
    own = problem(FRAME, np.asarray(y))
    own = replace(own, rows=replace(own.rows, within=SIGMA**2 * slow))
    found = of_search(begun(own), densities(np.where(SPEED < 0.012, 3.0, 1.0)), 1)
    assert (found is not None) is told


@pytest.mark.parametrize("louder", [3.0, 1.0])
def test_of_another_channel_a_mean_of_many_samples_counts_as_much_as_one(louder: float) -> None:
    """Slow recordings have nine samples where the others have one: their means scatter less, and their samples more."""
    slow = (SPEED < 0.012)[FRAME.recording]
    number = np.where(slow, 9.0, 1.0)
    scale = SIGMA * np.sqrt(np.where(slow, louder, 1.0) / number)
    own = problem(FRAME, np.asarray(np.random.default_rng(7).normal(0.0, scale)))
    search = begun(replace(own, rows=replace(own.rows, number=number)))
    search.model = replace(search.model, problem=replace(search.model.problem, channel=LOAD_TORQUE))
    found = of_search(search, densities(np.where(SPEED < 0.012, 3.0, 1.0)), 1)
    assert (found is not None) is (louder > 2.0)


@pytest.mark.parametrize(
    "factor",
    [
        np.ones(RECORDINGS),
        # a machine vibrates more the faster it turns
        np.where(SPEED > 0.05, 4.0, 1.0),
        # less than twice the mean square
        np.where(SPEED < 0.012, 1.5, 1.0),
        # whichever state: loud at random
        np.random.default_rng(3).permutation(np.where(np.arange(RECORDINGS) < 6, 3.0, 1.0)),
    ],
    ids=["noise", "faster", "little", "random"],
)
def test_what_is_no_finding(factor: FloatArray) -> None:
    found = scatter(densities(factor), FRAME, STEADY, 1)
    assert found is None or found.p_value > 0.01


def test_lines_are_no_scatter() -> None:
    lined = densities(np.ones(RECORDINGS))
    for one in lined:
        if SPEED[one.recording] < 0.012:
            one.power[300] *= 3000.0
    assert scatter(lined, FRAME, STEADY, 1) is None


def test_few_recordings_tell_nothing() -> None:
    few = [replace(d) for d in densities(np.where(SPEED < 0.012, 3.0, 1.0))[:9]]
    assert scatter(few, FRAME, STEADY, 1) is None
    assert scatter(densities(np.ones(RECORDINGS)), FRAME, 0.0 * STEADY, 1) is None


def test_a_load_that_is_driven_up_and_down_is_no_scatter() -> None:
    slow = np.flatnonzero(SPEED < 0.012)
    factor = np.where(SPEED < 0.012, 3.0, 1.0)
    factor[slow[0]] = 1e4
    level = FRAME.torque_level.copy()
    own = FRAME.recording == slow[0]
    level[own] = np.linspace(-800.0, 800.0, int(own.sum()))
    found = scatter(densities(factor), replace(FRAME, torque_level=level), STEADY, 1)
    assert found is not None
    assert set(found.recordings) == set(slow[1:])


def test_a_long_recording_is_no_more_of_a_witness_for_the_range() -> None:
    """Of two loud recordings the slow one has nine times the samples; those where it is strongest are told by them."""
    frame = made.campaign()
    own = made.outcome(frame, "motor_torque", [], SIGMA)
    long, short = 0, 1
    number = np.where(frame.recording == long, 9.0 * own.rows.number, own.rows.number)
    own = replace(own, rows=replace(own.rows, number=number))
    found = Scatter("speed", "below", 0.05, (long, short), (SIGMA**2, SIGMA**2), SIGMA**2, 2.0, 1e-4)
    told = _of_scatter(found, own)
    assert told.excess is not None
    assert told.everywhere is not None
    energy = np.bincount(frame.recording, np.where(own.usable, number * told.excess**2, 0.0))
    assert energy[long] == pytest.approx(energy[short])
    assert energy.sum() == pytest.approx(np.sum(np.where(own.usable, number * told.everywhere**2, 0.0)))
    assert set(np.unique(told.everywhere)) == {0.0, SIGMA}
