from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

from bench.errors import ProofError
from bench.proof import make
from bench.proof.analyse import Job
from bench.proof.peers import compare_peers
from bench.proof.peers.candidates import Problem, problems
from bench.proof.peers.location import location_of
from bench.proof.peers.methods import METHODS, cross_validated, held_out, pick
from bench.proof.peers.rows import read_rows


@pytest.fixture(scope="module")
def posed(made) -> dict[str, Problem]:
    return {p.channel: p for p in problems(read_rows(made.out / make.RECORDINGS / made.clear.alias))}


def greedy(problem: Problem) -> np.ndarray:
    """The single best column."""
    x, y = problem.columns[problem.train], problem.y[problem.train]
    return np.array([int(np.argmax(np.abs(x.T @ y)))])


def test_problems_cover_the_channels_and_the_vocabulary(posed) -> None:
    assert set(posed) == {"transmission_error", "motor_torque", "load_torque", "temperature"}
    names = {effect for p in posed.values() for effect in p.effects}
    assert len(names) >= 25
    for problem in posed.values():
        assert np.isfinite(problem.columns).all()
        assert problem.train.any()
        assert not problem.train.all()


def test_columns_are_orthogonal_to_the_simulation(posed) -> None:
    motor = posed["motor_torque"]
    assert abs(motor.y[motor.train].mean()) < 1e-6
    assert np.allclose(np.sqrt(np.mean(motor.columns[motor.train] ** 2, axis=0)), 1.0)


def test_a_planted_column_is_picked_and_noise_is_pruned(posed) -> None:
    motor = posed["motor_torque"]
    rng = np.random.default_rng(1)
    at = motor.effects.index("friction.viscous_quadratic")
    noise = rng.normal(0.0, 1.0, motor.y.size)
    planted = Problem(
        motor.channel,
        motor.columns[:, at] + noise,
        motor.columns,
        motor.effects,
        motor.orders,
        motor.recording,
        motor.train,
    )
    assert pick(greedy, planted).tolist() == [at]
    assert held_out(planted, np.array([at])) < held_out(planted, np.array([], dtype=np.int64))
    empty = Problem(motor.channel, noise, motor.columns, motor.effects, motor.orders, motor.recording, motor.train)
    assert pick(greedy, empty).size == 0
    assert cross_validated(empty, np.array([], dtype=np.int64)) == pytest.approx(1.0, rel=0.05)


def test_compare_scores_each_peer(made) -> None:
    job = Job("null", made.null.name, 3, False, made.out)
    compared = compare_peers([job], {"greedy": greedy})
    assert len(compared.scores["greedy"]) == 1
    assert "### greedy" in compared.markdown()
    assert compared.to_dict()["greedy"]["cases"] == 1


def test_a_folder_is_not_done_twice(made) -> None:
    job = Job("null", made.null.name, 3, False, made.out)
    first = compare_peers([job], {"once": greedy})

    def broken(problem: Problem) -> np.ndarray:
        raise AssertionError("asked again")

    assert compare_peers([job], {"once": broken}).scores == first.scores


@pytest.mark.skipif(find_spec("pysindy") is not None, reason="the peers are installed")
def test_missing_peers_are_named(made) -> None:
    with pytest.raises(ProofError, match="pysindy"):
        compare_peers([])


@pytest.mark.skipif(find_spec("pysindy") is None or find_spec("sysidentpy") is None, reason="needs the peers")
@pytest.mark.parametrize("name", list(METHODS))
def test_every_peer_runs(posed, name: str) -> None:
    picked = pick(METHODS[name], posed["motor_torque"])
    assert picked.dtype == np.int64


def test_a_peer_is_given_the_place_of_its_columns(posed) -> None:
    motor = posed["motor_torque"]
    picked = np.array([motor.effects.index("friction.viscous_quadratic")])
    place = location_of(motor, picked, "friction.viscous_quadratic")
    assert set(place["conditions"]) == {"velocity", "load_torque", "temperature", "direction"}
    low, high = place["conditions"]["velocity"]
    assert 0.0 <= low < high
    energy = motor.states["weight"] * motor.columns[:, picked[0]] ** 2
    inside = (motor.states["velocity"] >= low) & (motor.states["velocity"] <= high)
    assert energy[inside].sum() >= 0.9 * energy.sum()
    sums = np.bincount(motor.recording, weights=energy)
    assert place["recordings"][0] == motor.names[int(np.argmax(sums))]
