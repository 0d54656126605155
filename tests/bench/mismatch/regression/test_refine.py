"""Nonlinear parameters: where they are found, how sure they are said to be, what the projector takes off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.discovery import AMBIGUOUS, NAMED
from bench.mismatch.regression.discoveries import size_of_term, sure_of_name
from bench.mismatch.regression.model import add_block, fit_blocks
from bench.mismatch.regression.refine import bounds, projector, refined, strained
from bench.mismatch.regression.regressors import Named, named
from bench.simulation.memory import NOISE_SHARE
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import banked, campaign, problem

SIGMA, SIZE, SPEED = 0.05, 0.4, 4.0
"""N·m noise of a row, N·m Stribeck friction, rad/s at the motor over which it decays"""
DRAWS = 40


def stribeck(speed: float) -> Named:
    return named("friction.stribeck", MOTOR_TORQUE, "gaussian", (speed,))


def found(seed: int, true: float = SPEED, size: float = SIZE, start: float = 2.0) -> tuple[Named, bool]:
    frame = campaign()
    noise = np.random.default_rng(seed).normal(scale=SIGMA, size=frame.size)
    y = 0.6 * frame.direction + 0.01 * frame.omega + size * stribeck(true).columns(frame)[:, 0] + noise
    own = problem(frame, y)
    bank, base = banked(own, SIGMA)
    better = refined(own, bank, base, stribeck(start), 0.0)
    return better, strained(better, frame)


def test_intervals_of_a_nonlinear_parameter_cover_the_truth() -> None:
    scores = []
    for seed in range(DRAWS):
        better, _ = found(seed)
        assert better.deviation[0] is not None
        scores.append((better.point[0] - SPEED) / better.deviation[0])
    z = np.asarray(scores)
    # 95 % of 40 is 38; fewer than 34 have a chance of 1 in 300
    assert np.sum(np.abs(z) < 1.96) >= 34
    assert 0.7 < np.sqrt(np.mean(z**2)) < 1.35


def test_recordings_that_differ_make_a_parameter_less_sure() -> None:
    """Each recording has a speed of its own: the mean of them is known as well as they agree, not as well as rows."""
    scores = []
    frame = campaign()
    for seed in range(DRAWS):
        rng = np.random.default_rng(seed)
        speeds = SPEED * np.exp(0.3 * rng.normal(size=int(frame.recording.max()) + 1))
        curve = np.exp(-((frame.omega / speeds[frame.recording]) ** 2)) * frame.direction
        y = 0.6 * frame.direction + 0.01 * frame.omega + SIZE * curve + rng.normal(scale=0.1 * SIGMA, size=frame.size)
        own = problem(frame, y)
        bank, base = banked(own, 0.1 * SIGMA)
        better = refined(own, bank, base, stribeck(3.0), 0.0)
        assert better.deviation[0] is not None
        scores.append((better.point[0] - SPEED) / better.deviation[0])
    assert np.sum(np.abs(scores) < 1.96) >= 32
    assert np.sqrt(np.mean(np.square(scores))) < 1.6


def test_the_interval_of_a_coefficient_knows_that_of_the_shape() -> None:
    """With the shape held at its best value a coefficient looks surer than it is."""
    told, held = [], []
    frame = campaign()
    for seed in range(DRAWS):
        # a shallow curve that few slow points show: its size and its width go together
        true, size = 12.0, 1.2
        noise = np.random.default_rng(seed).normal(scale=SIGMA, size=frame.size)
        y = 0.6 * frame.direction + 0.01 * frame.omega + size * stribeck(true).columns(frame)[:, 0] + noise
        own = problem(frame, y)
        bank, base = banked(own, SIGMA)
        better = refined(own, bank, base, stribeck(8.0), 0.0)
        block = add_block(own, bank, better)
        fitted = fit_blocks(bank, [*base, block], (0.0,))
        values, covariance = fitted.of(block.indices)
        std = np.sqrt(np.diag(covariance))
        (row, _) = better.parameters(values, std)
        told.append((row["value"] - size) / row["std"])
        held.append((row["value"] - size) / std[0])
    assert np.sqrt(np.mean(np.square(held))) > 1.35
    assert 0.7 < np.sqrt(np.mean(np.square(told))) < 1.35


def test_a_loop_behind_a_play_is_no_better_known_than_that() -> None:
    """The play that keeps noise from turning a loop is a share of its width, and leaves that open."""
    forms = LIBRARY["te.hysteresis"].forms["transmission_error"]
    assert {f.name.split("_")[0]: f.blur for f in forms if f.name != "angle_play"} == {
        "play": 0.0,
        "bouc": NOISE_SHARE,
        "stack": 0.0,
        "forgetting": NOISE_SHARE,
        "dithered": NOISE_SHARE,
        "pair": 0.0,
        "reversal": 0.0,
    }


def test_a_parameter_at_the_end_of_its_range_has_no_deviation() -> None:
    better, at_end = found(1, true=20.0, size=8.0, start=12.0)
    assert at_end
    assert better.deviation == (None,)


@pytest.mark.parametrize(
    ("at_the_end", "size", "left"),
    # it may be the term or what it turns into; it may be the whole or nothing: a coin's toss
    [(False, 0.1, 1.0), (True, 0.1, 0.5), (False, 0.03, 0.5)],
)
def test_a_name_is_half_as_sure_where_it_may_be_another(at_the_end: bool, size: float, left: float) -> None:
    assert sure_of_name(NAMED, at_the_end, np.array([0.0, size]), np.diag([0.02**2, 0.02**2])) == left
    assert sure_of_name(AMBIGUOUS, at_the_end, np.array([0.0, size]), np.diag([0.02**2, 0.02**2])) == 1.0


@pytest.mark.parametrize(("deviation", "left"), [(1.6, 0.5), (0.2, 1.0), (None, 0.5)])
def test_a_lag_of_the_sensor_is_nothing_where_its_time_may_be_zero(deviation: float | None, left: float) -> None:
    # its coefficient is one over the heat capacity, which is sure whatever the lag is
    term = LIBRARY["thermal.sensor_lag"]
    lag = Named(term, "temperature", term.forms["temperature"][0], (1.7,), (deviation,))
    assert sure_of_name(NAMED, False, *size_of_term(lag, np.array([2e-5]), np.array([[1e-14]]))) == left


def test_a_deviation_stands_in_the_report_and_in_the_file() -> None:
    better, _ = found(3)
    told = better.parameters(np.array([0.4]), np.array([0.01]))
    assert told[1]["symbol"] == "w_s"
    assert told[1]["std"] == better.deviation[0]
    assert better.row(np.array([0.4]), np.array([0.01]))["parameters"]["w_s"]["std"] == better.deviation[0]


@pytest.mark.parametrize("precision", [0.0, 3.0e2])
@pytest.mark.parametrize("variance", [0.0, 2e-4, np.inf])
def test_the_projector_leaves_the_squares_of_a_dense_solution(precision: float, variance: float) -> None:
    frame = campaign(8)
    y = 0.6 * frame.direction + np.random.default_rng(5).normal(scale=SIGMA, size=frame.size)
    own = problem(frame, y)
    bank, base = banked(own, SIGMA, 0.3)
    blocks = [type(b)(b.regressor, b.indices, np.full(len(b.indices), precision)) for b in base]
    left = projector(bank, blocks, variance)(bank.y)
    x = np.hstack([bank.columns.some(b.indices) for b in base])
    ones = np.zeros((frame.size, 8))
    ones[np.arange(frame.size), frame.recording] = bank.one
    offset = 0.0 if np.isinf(variance) else 1.0 / max(variance, 1e-12)
    prior = np.array([precision] * x.shape[1] + [offset] * 8)
    x = np.hstack([x, ones])
    beta = np.linalg.lstsq(
        np.vstack([x, np.diag(np.sqrt(prior))]), np.append(bank.y, np.zeros(prior.size)), rcond=None
    )[0]
    squares = float(np.sum((bank.y - x @ beta) ** 2) + np.sum(prior * beta**2))
    assert float(left @ left) == pytest.approx(squares, rel=1e-5)


def test_a_parameter_stays_within_its_physical_bounds() -> None:
    term = named("friction.viscous_quadratic", "motor_torque", "power", (1.6,))
    low, high = bounds(term.form, campaign(4))
    # an exponent near one is viscous friction, no churning
    assert low[0] == 1.2
    assert high[0] == 4.0


def test_a_wave_without_a_whole_period_is_no_modulation() -> None:
    term = named("friction.position_dependent", MOTOR_TORQUE, "constant", (1.0,))
    frame = campaign(4)
    swing = replace(frame, q=np.linspace(0.0, 1.0, frame.size))
    assert [p[0] for p in term.form.grid(swing)] == [7.0, 8.0, 9.0, 10.0, 11.0, 12.0]
    assert term.form.grid(replace(frame, q=np.linspace(0.0, 0.2, frame.size))) == ()
    assert len(term.form.grid(replace(frame, q=np.linspace(0.0, 7.0, frame.size)))) == 12


def test_columns_that_are_alike_are_sure_together() -> None:
    """A gain and a limit whose sum is known to a hundredth, and either to no more than its own size."""
    covariance = 0.5 * np.array([[1.0, -0.9999], [-0.9999, 1.0]])
    assert sure_of_name(NAMED, False, np.array([0.5, 0.5]), covariance) == 1.0
    assert sure_of_name(NAMED, False, np.array([0.5, -0.5]), covariance) < 1.0
