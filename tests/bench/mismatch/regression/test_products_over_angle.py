"""A drag in a part of the revolution above a speed is a product of two tables, and no wave of the friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.beside import differs_from_zero
from bench.mismatch.regression.model import Chosen, add_block
from bench.mismatch.regression.products import products, replaced
from bench.mismatch.regression.regressors import UNKNOWN, Free, named
from bench.mismatch.regression.search import begun, searched
from bench.mismatch.regression.succession import _in_its_place, _less_than_its_correction
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.tables import Grid
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import EACH, campaign, problem

SIGMA = 0.02
FRICTION = "friction.position_dependent"


def turning(recordings: int = 36) -> Frame:
    """Recordings of a whole revolution each, at six speeds."""
    frame = campaign(recordings)
    turn = np.tile(2.0 * np.pi * (np.arange(EACH) + 0.5) / EACH, recordings)
    speed = np.array([0.03, 0.05, 0.07, 0.1, 0.14, 0.2])[(np.arange(recordings) // 2) % 6]
    return replace(
        frame, q=frame.direction * turn, theta=frame.direction * turn, velocity=frame.direction * np.repeat(speed, EACH)
    )


def bump(frame: Frame) -> FloatArray:
    """One at 2.3 rad, 1.2 rad wide."""
    away = (np.mod(frame.q, 2.0 * np.pi) - 2.3 + np.pi) % (2.0 * np.pi) - np.pi
    return np.asarray(np.where(np.abs(away) < 0.6, np.cos(np.pi / 1.2 * away) ** 2, 0.0))


@pytest.mark.parametrize("above", [0.08, 0.0])
def test_a_drag_over_the_angle_above_a_speed_is_a_function_of_both(above: float) -> None:
    """At all speeds it is friction over the angle, as that is defined."""
    frame = turning()
    drag = 0.25 * frame.direction * bump(frame) * (np.abs(frame.velocity) > above)
    y = 0.6 * frame.direction + drag + np.random.default_rng(4).normal(scale=SIGMA, size=frame.size)
    model = searched(problem(frame, y)).model
    variables = [c.main.regressor.variables for c in model.chosen]
    if above:
        assert [c.effect for c in model.chosen] == [UNKNOWN]
        assert variables == [("angle", "speed")]
        left = drag - model.contribution(model.chosen[0], frame)
        assert np.std(left) < SIGMA
    else:
        assert {c.effect for c in model.chosen} == {FRICTION}


def test_products_of_the_angle_are_not_asked_over_the_load() -> None:
    """A name says how friction over the angle goes with it."""
    frame = turning()
    y = 0.6 * frame.direction + np.random.default_rng(4).normal(scale=SIGMA, size=frame.size)
    search = begun(problem(frame, y + 0.25 * frame.direction * bump(frame)))
    wave = Chosen(add_block(search.model.problem, search.bank, named(FRICTION, MOTOR_TORQUE, "with_load", (3.0,))))
    search.model.chosen = [wave, replace(wave)]
    made = [b.regressor for b in products(search)]
    assert [r.variables for r in made] == [("angle",), ("angle", "speed"), ("angle", "temperature")]
    assert all(r.effect == UNKNOWN for r in made)
    assert replaced(search.model.chosen, made[1]) == search.model.chosen
    other = Chosen(add_block(search.model.problem, search.bank, named("load.unbalance", MOTOR_TORQUE, "gravity")))
    assert replaced([other], made[1]) == []


def test_bumps_that_a_close_table_says_by_itself_are_friction_over_the_angle() -> None:
    """A product with any other quantity has as close a table, and follows them as well."""
    frame = turning()
    profile = np.zeros(frame.size)
    for place, width, height in ((1.1, 0.22, 0.6), (3.9, 0.2, -0.9), (5.2, 0.18, 0.5)):
        away = (np.mod(frame.q, 2.0 * np.pi) - place + np.pi) % (2.0 * np.pi) - np.pi
        profile += height * np.exp(-0.5 * (away / width) ** 2)
    y = frame.direction * (0.6 + profile) + np.random.default_rng(4).normal(scale=SIGMA, size=frame.size)
    model = searched(problem(frame, y)).model
    assert {c.effect for c in model.chosen} == {FRICTION}


def test_a_load_torque_over_the_angle_that_grows_with_the_load_is_a_function_of_both() -> None:
    frame = turning()
    frame = replace(frame, load_motor_torque=frame.torque, load_motor_level=frame.torque)
    grows = (np.abs(frame.load_motor_level) / 1000.0) ** 1.3 * np.cos(2.0 * frame.q + 0.8)
    y = 40.0 * grows + np.random.default_rng(4).normal(scale=2.0, size=frame.size)
    own = replace(problem(frame, y), channel=LOAD_TORQUE)
    search = begun(own)
    grid = Grid(("angle",), "1", (tuple(np.linspace(0.1, 6.2, 12).tolist()),))
    search.model.chosen = [Chosen(add_block(search.model.problem, search.bank, Free(LOAD_TORQUE, (grid,))))]
    assert ("angle", "load_motor_torque") in [b.regressor.variables for b in products(search)]
    model = searched(own).model
    assert [c.main.regressor.variables for c in model.chosen] == [("angle", "load_motor_torque")]
    left = 40.0 * grows - model.contribution(model.chosen[0], frame)
    assert np.std(left) < 2.0


@pytest.mark.parametrize(("size", "less"), [(0.002, True), (0.2, False)])
def test_a_name_that_says_less_than_its_correction_gives_it_its_place(size: float, less: bool) -> None:
    frame = turning()
    wave = named(FRICTION, MOTOR_TORQUE, "constant", (3.0,))
    y = 0.6 * frame.direction + wave.columns(frame) @ np.array([size, 0.0]) + 0.1 * frame.direction * bump(frame)
    search = begun(problem(frame, y + np.random.default_rng(4).normal(scale=SIGMA, size=frame.size)))
    table = Free(MOTOR_TORQUE, (Grid(("angle",), "d", (tuple(np.linspace(0.1, 6.2, 12).tolist()),)),), FRICTION)
    blocks = [add_block(search.model.problem, search.bank, r) for r in (wave, table)]
    effect = Chosen(blocks[0], replace(blocks[1], precision=np.full(12, 1.0 / 0.04**2)))
    search.model = replace(search.model, chosen=[effect], fit=search.model.refitted([effect]))
    assert (_less_than_its_correction(search.model) is effect) is less
    if less:
        (instead,) = _in_its_place(search, effect)
        assert instead.effect == FRICTION
        assert isinstance(instead.main.regressor, Free)


def test_the_largest_of_many_is_no_surer_than_one() -> None:
    """Of twelve that are nothing the largest is two standard deviations off in every other case."""
    rng = np.random.default_rng(6)
    for number in (1, 2, 12):
        drawn = rng.normal(size=(2000, number))
        told = np.mean([differs_from_zero(one, np.eye(number)) for one in drawn])
        assert 0.03 < told < 0.1
