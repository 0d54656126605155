"""Bursts: loud blocks are found where they are, noise has none."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.regression.bank import fit
from bench.mismatch.unnamed.bursts import Bursts, _chance, _louder, bursts
from bench.mismatch.unnamed.structure import _counts, _of_bursts
from bench.simulation.frame import FloatArray, Frame
from tests.bench.mismatch.regression.synthetic import banked, campaign, problem

SIGMA = 0.05
LOUD = slice(310, 325)
FRAME = campaign(24)


QUICK = replace(FRAME, elapsed=FRAME.elapsed / 8.0, time=FRAME.time / 8.0, step=FRAME.step / 8.0)
"""rows eight times as close"""
KNOCK = slice(312, 319)


def looked(seed: int, louder: float, loud: slice = LOUD, frame: Frame = FRAME, memory: float = 1.0) -> Bursts:
    noise = np.random.default_rng(seed).normal(scale=SIGMA, size=frame.size)
    noise[loud] *= louder
    own = problem(frame, 0.6 * frame.direction + noise)
    bank, base = banked(own, SIGMA)
    fitted = fit(bank, [i for b in base for i in b.indices], bank.variances())
    model: Any = SimpleNamespace(
        problem=own, bank=bank, fit=fitted, blocks=lambda: base, noise=SimpleNamespace(memory=memory)
    )
    search: Any = SimpleNamespace(model=model)
    found = bursts(search)
    assert found is not None
    return found


def test_a_burst_is_found_where_it_is() -> None:
    found = looked(1, 6.0)
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert set(found.rows.tolist()) <= set(range(LOUD.start - 5, LOUD.stop + 5))
    assert found.rows.size >= 10
    assert 3.0 < found.louder < 10.0


@pytest.mark.parametrize("seed", range(6))
def test_noise_has_no_burst(seed: int) -> None:
    found = looked(seed, 1.0)
    assert found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL
    assert found.rows.size == 0


def test_a_knock_of_a_second_is_found_as_that() -> None:
    found = looked(1, 6.0, KNOCK, QUICK, 0.1)
    assert found.p_value < criteria.ERROR_RATE_OF_A_CHANNEL
    assert set(found.rows.tolist()) <= set(range(KNOCK.start - 8, KNOCK.stop + 8))
    assert found.rows.size >= 5


@pytest.mark.parametrize("seed", range(6))
def test_noise_has_no_knock(seed: int) -> None:
    assert looked(seed, 1.0, LOUD, QUICK, 0.1).p_value > criteria.ERROR_RATE_OF_A_CHANNEL


def test_one_row_far_off_is_no_burst() -> None:
    """Noise with heavy tails has such rows."""
    found = looked(1, 40.0, slice(312, 313))
    assert found.p_value > criteria.ERROR_RATE_OF_A_CHANNEL


def test_what_comes_just_before_a_reversal_is_no_burst() -> None:
    """The same loud rows, in steady motion or each beside a row that is not."""
    loud = np.arange(KNOCK.start, KNOCK.stop)
    steady = QUICK.steady.copy()
    steady[loud[::2]] = 0.0
    assert looked(1, 6.0, KNOCK, QUICK, 0.1).rows.size >= 5
    assert looked(1, 6.0, KNOCK, replace(QUICK, steady=steady), 0.1).rows.size == 0


def frame_of(elapsed: FloatArray) -> Any:
    """Rows of one recording at some times (s)."""
    recording = np.zeros(elapsed.size, dtype=np.int64)
    return SimpleNamespace(recording=recording, elapsed=elapsed, take=lambda rows: frame_of(elapsed[rows]))


def counted(
    size: float,
    rows: int,
    named: float = 0.0,
    variables: tuple[str, ...] = (),
    effect: str = "friction.stribeck",
    compared_s: float = 1.0,
) -> bool:
    """Whether ``rows`` of 40 000, one a second, that are ``size`` times the noise off count, where a name of some
    ``variables`` adds ``named`` times it; the channel is compared at other rows, each ``compared_s``.
    """
    frame = frame_of(np.arange(40_000.0))
    y = np.zeros(40_000)
    y[:rows] = size * SIGMA
    rows_of = SimpleNamespace(y=y, frame=frame, number=np.ones(y.size), size=y.size)
    problem_of = SimpleNamespace(rows=rows_of, train=y >= 0.0, spec=SimpleNamespace(integral=False))
    model = SimpleNamespace(problem=problem_of, blocks=list, predict=lambda _: np.zeros(y.size))
    search: Any = SimpleNamespace(model=model)
    compared = frame_of(np.arange(0.0, 40_000.0, compared_s))
    # it acts where the rows are loud alone
    added = np.where(compared.elapsed <= rows, named * SIGMA, 0.0)
    name = SimpleNamespace(status="named", effect=effect, beyond=added, variables=variables)
    channel = "transmission_error" if effect.startswith("te.") else "motor_torque"
    outcome: Any = SimpleNamespace(
        floor=SIGMA, discoveries=[name], channel=channel, rows=SimpleNamespace(frame=compared)
    )
    return _counts(Bursts(np.arange(rows), 1e-4, 3.0), outcome, search)


@pytest.mark.parametrize(("named", "counts"), [(0.0, True), (8.0, True), (15.0, False)])
def test_loud_rows_that_the_form_of_a_name_may_leave_are_no_burst(named: float, counts: bool) -> None:
    assert counted(2.3, 20, named) is counts


@pytest.mark.parametrize(("named", "counts"), [(2.0, True), (3.0, False)])
def test_loud_rows_are_no_burst_where_a_loop_may_be_off_by_all_of_itself(named: float, counts: bool) -> None:
    """Until it is turned nothing tells where in its loop a recording began."""
    assert counted(2.3, 20, named, ("torque_path",)) is counts


@pytest.mark.parametrize(
    ("effect", "variables", "counts"),
    [
        ("te.hysteresis", ("torque_path",), False),
        ("te.stiffness_nonlinear", ("torque",), True),
        ("te.harmonic", ("angle",), True),
    ],
)
@pytest.mark.parametrize("compared_s", [0.1, 7.0])
def test_names_of_the_transmission_error_are_asked_at_the_same_times(
    effect: str, variables: tuple[str, ...], counts: bool, compared_s: float
) -> None:
    """It is compared over the angle, at other rows than its offset; the waves of the angle are not in the offset."""
    assert counted(2.3, 70, 3.0 if effect != "te.harmonic" else 30.0, variables, effect, compared_s) is counts


@pytest.mark.parametrize("compared_s", [0.1, 1.0, 7.0])
def test_loud_rows_lie_where_they_were_heard(compared_s: float) -> None:
    """The channel may be compared at other rows than those in which they were."""
    y = np.zeros(4000)
    y[1000:1200] = 3.0 * SIGMA
    frame = frame_of(np.arange(4000.0))
    frame.time = frame.elapsed
    rows_of = SimpleNamespace(y=y, frame=frame, number=np.ones(y.size), size=y.size)
    problem_of = SimpleNamespace(rows=rows_of, train=y >= 0.0, spec=SimpleNamespace(integral=False))
    search: Any = SimpleNamespace(
        model=SimpleNamespace(problem=problem_of, blocks=list, predict=lambda _: np.zeros(y.size))
    )
    compared = frame_of(np.arange(0.0, 4000.0, compared_s))
    rows_compared = SimpleNamespace(frame=compared, size=compared.elapsed.size)
    outcome: Any = SimpleNamespace(
        floor=SIGMA, discoveries=[], channel="transmission_error", rows=rows_compared, rmse={}
    )
    found = _of_bursts(Bursts(np.arange(1000, 1200), 1e-4, 3.0), outcome, search)
    assert found is not None
    heard = compared.elapsed[found.beyond != 0.0]
    assert heard.min() == pytest.approx(1000.0, abs=0.5 + compared_s)
    assert heard.max() == pytest.approx(1199.0, abs=0.5 + compared_s)


@pytest.mark.parametrize(
    ("size", "rows", "told"), [(2.3, 20, True), (0.45, 20, False), (0.45, 600, True), (2.3, 2, False)]
)
def test_few_loud_rows_are_told_where_they_are_above_the_noise(size: float, rows: int, told: bool) -> None:
    """Of 40 000 rows; what is below the noise of a sample has to be something over all of them."""
    assert counted(size, rows) is told


def test_the_chance_of_the_loudest_is_none_too_small() -> None:
    rng = np.random.default_rng(8)
    chances = np.array([_chance(rng.normal(size=65), 2) for _ in range(4000)])
    for rate in (0.01, 0.05):
        assert np.mean(chances < rate) <= rate


def test_what_is_hardly_loud_is_found_where_it_is_so_again_and_again() -> None:
    rng = np.random.default_rng(9)
    z = np.clip(rng.normal(size=65), None, 1.5)
    once, thrice = z.copy(), z.copy()
    once[7], thrice[[7, 30, 51]] = 3.1, 3.1
    assert _chance(once, 2) > 0.05
    assert _chance(thrice, 2) < criteria.ERROR_RATE_OF_A_CHANNEL


@pytest.mark.parametrize(("spread", "loud"), [(1.2, False), (0.15, True)])
def test_blocks_are_loud_beside_those_of_a_like_speed(spread: float, loud: bool) -> None:
    """Most blocks are of long recordings at one speed, and scatter little; ten times as loud is one at another."""
    rng = np.random.default_rng(2)
    scatter = np.concatenate([rng.normal(0.0, 0.15, 80), rng.normal(0.0, spread, 41)])
    scatter[100] = np.log(10.0)
    speed = np.append(np.linspace(1.4, 1.6, 80), np.linspace(0.3, 0.5, 41))
    number = np.full(speed.size, 200.0)
    z = _louder(number * np.exp(scatter), number, speed, np.ones(speed.size, dtype=bool))[2]
    assert (_chance(z, 1) < criteria.ERROR_RATE_OF_A_CHANNEL) is loud
