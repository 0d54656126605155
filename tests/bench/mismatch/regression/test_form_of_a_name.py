"""A free function of the very quantity by which nature's form of a name may differ is part of that name."""

from __future__ import annotations

import numpy as np
import pytest

from bench.mismatch.regression.beside import _beyond
from bench.mismatch.regression.choosing import _form_of_a_name, _may_be_added
from bench.mismatch.regression.model import Block, Chosen
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, Regressor
from bench.mismatch.regression.search import begun
from bench.simulation.tables import Grid
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, TRANSMISSION_ERROR
from tests.bench.mismatch.regression.synthetic import campaign, problem

KNOTS = (-900.0, 0.0, 900.0)


def block(regressor: Regressor) -> Block:
    """A regressor as a block of a bank."""
    return Block(regressor, (), np.zeros(0))


def lost_motion() -> Chosen:
    """Lost motion by the library's own form."""
    term = LIBRARY["te.lost_motion"]
    form = term.forms[TRANSMISSION_ERROR][0]
    return Chosen(block(Named(term, TRANSMISSION_ERROR, form, (60.0,))))


def table(over: str, times: str, effect: str = UNKNOWN) -> Free:
    """A table over one quantity."""
    return Free(TRANSMISSION_ERROR, (Grid((over,), times, (KNOTS,)),), effect)


@pytest.mark.parametrize(
    ("free", "effect"),
    [
        (table("torque", "1", "te.stiffness_nonlinear"), "te.lost_motion"),
        (table("torque", "1"), "te.lost_motion"),
        (table("temperature", "p", "te.temperature_nonlinear"), "te.temperature_nonlinear"),
        (table("torque", "last_d"), UNKNOWN),
    ],
)
def test_what_two_functions_of_one_quantity_add_up_to_is_one_effect(free: Free, effect: str) -> None:
    found = _form_of_a_name(block(free), [lost_motion()])
    assert found.regressor.effect == effect
    assert _form_of_a_name(block(free), []).regressor is free


def test_an_effect_that_is_any_function_of_a_quantity_is_asked_for_once() -> None:
    own = table("torque", "1", "te.stiffness_nonlinear")
    had = {(own.effect, own.variables)}
    assert _may_be_added(own, set(), set(), True)
    assert not _may_be_added(own, set(), had, True)
    assert not _may_be_added(own, {own.effect}, set(), True)
    assert _may_be_added(table("torque", "1"), set(), had, True)
    assert not _may_be_added(table("torque", "1"), set(), set(), False)


@pytest.mark.parametrize(("times", "effect"), [("d", "sensor.torque_nonlinearity"), ("load_motor", UNKNOWN)])
def test_what_passes_through_a_curved_sensor_is_no_second_effect(times: str, effect: str) -> None:
    term = LIBRARY["sensor.torque_nonlinearity"]
    curved = Chosen(block(Named(term, LOAD_TORQUE, term.forms[LOAD_TORQUE][0])))
    free = Free(LOAD_TORQUE, (Grid(("load_motor_torque",), times, (KNOTS,)),))
    assert _form_of_a_name(block(free), [curved]).regressor.effect == effect


@pytest.mark.parametrize(
    ("effect", "least", "most"), [("square", 0.05, 0.6), ("viscous", 0.0, 0.01), ("bump", 0.8, 1.0)]
)
def test_a_form_is_corrected_by_a_share_of_what_the_simulation_cannot_say(
    effect: str, least: float, most: float
) -> None:
    """Drag with the square of the speed is mostly viscous friction; a bump over the temperature is nothing of it."""
    frame = campaign()
    omega = frame.omega
    y = 0.5 * frame.direction + 0.006 * omega + np.random.default_rng(1).normal(0.0, 0.01, frame.size)
    search = begun(problem(frame, y))
    courses = {
        "square": 4e-4 * np.sign(omega) * omega**2,
        "viscous": 0.003 * omega,
        "bump": 0.1 * np.exp(-(((frame.temperature - 30.0) / 1.0) ** 2)) * np.sign(np.sin(50.0 * frame.time)),
    }
    share = _beyond(search, courses[effect][search.model.problem.train], 0.0)
    assert least <= share <= most
