"""Free functions: where their knots are, and which of them have a name by definition."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.candidates import _of_product, free_candidates, in_order, named_candidates
from bench.mismatch.regression.knots import knots_of
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR
from tests.bench.mismatch.regression.synthetic import campaign


def test_levels_that_a_controller_left_a_little_apart_are_one_knot() -> None:
    """Six loads, each met to a newton metre."""
    loads = np.repeat([-900.0, -600.0, -300.0, 300.0, 600.0, 900.0], 40)
    values = loads + np.random.default_rng(0).choice([-0.5, 0.0, 0.5, 6.0], loads.size)
    knots = knots_of(values, 12)
    assert knots is not None
    assert knots == pytest.approx([-900.0, -600.0, -300.0, 300.0, 600.0, 900.0], abs=6.0)


def test_a_product_of_one_quantity_is_the_effect_that_is_any_function_of_it() -> None:
    """Cubes of temperature, speed and load in the transmission error; not of two quantities, not in a torque."""
    assert _of_product(TRANSMISSION_ERROR, "T*T*T") == "te.temperature_nonlinear"
    assert _of_product(TRANSMISSION_ERROR, "last_d*T*T*T") == "te.temperature_nonlinear"
    assert _of_product(TRANSMISSION_ERROR, "v*v*v") == "te.velocity_nonlinear"
    assert _of_product(TRANSMISSION_ERROR, "tau*tau*tau") == "te.stiffness_nonlinear"
    assert _of_product(TRANSMISSION_ERROR, "last_d*tau*tau*tau") == "unknown"
    assert _of_product(TRANSMISSION_ERROR, "tau*tau*T") == "unknown"
    assert _of_product(MOTOR_TORQUE, "d*T*T") == "unknown"


def test_a_heat_capacity_that_depends_on_temperature_can_be_drawn() -> None:
    """The temperature's functions hold one that divides loss and cooling alike."""
    found = [f for f in free_candidates(TEMPERATURE, campaign()) if f.grids[0].over == ("temperature",)]
    assert any({g.times for g in f.grids} == {"1", "power"} for f in found)


def test_bending_of_the_torque_sensor_can_be_drawn_and_a_gain_of_the_motor_torque_cannot() -> None:
    """A function of the angle times the load: its mean is a gain, which has a name in the motor torque."""
    own = {
        c: {(f.grids[0].over, g.times) for f in free_candidates(c, campaign()) for g in f.grids}
        for c in (LOAD_TORQUE, MOTOR_TORQUE)
    }
    assert (("angle",), "load_motor") in own[LOAD_TORQUE]
    assert not {(("angle",), "tau"), (("angle",), "d*abs_tau")} & own[MOTOR_TORQUE]


def test_no_knot_stands_where_no_row_is() -> None:
    """After a reversal rows of 20 ms begin at a tenth of a radian and go on at two thirds."""
    rng = np.random.default_rng(1)
    values = np.concatenate([rng.normal(-1.0, 0.02, 80), rng.uniform(-0.15, 1.4, 900)])
    knots = knots_of(values, 12)
    assert knots is not None
    assert not any(-0.9 < knot < -0.25 for knot in knots)
    assert knots[0] < -0.9
    assert len(knots) > 8


def test_in_pieces_of_a_free_motion_time_gives_no_torque_its_effect() -> None:
    """In a sweep the motion itself changes as time goes on, and friction that changes with it is no running-in."""

    def effects(channel: str, cut: bool) -> set[str]:
        return {own.effect for own in named_candidates(channel, campaign(), (), cut=cut)}

    assert effects(MOTOR_TORQUE, False) - effects(MOTOR_TORQUE, True) == {"friction.run_in"}
    assert effects(TEMPERATURE, True) == effects(TEMPERATURE, False)


def test_a_sweep_says_when_something_was_done() -> None:
    """In a drawn order of points, of which every piece has all, a name may be of the time."""
    sweep = campaign(400)
    drawn = np.random.default_rng(3).permutation(sweep.size)
    mixed = replace(sweep, velocity=sweep.velocity[drawn], torque=sweep.torque[drawn], theta=sweep.theta[drawn])
    for frame, found in ((sweep, False), (mixed, True)):
        assert in_order(frame) is not found
        names = {n.effect for n in named_candidates(MOTOR_TORQUE, frame, (), free=True, cut=True)}
        assert ("friction.run_in" in names) is found


def test_up_and_down_once_is_a_sweep() -> None:
    """No straight line over the speed says when, but each piece has speeds of its own."""
    sweep = campaign(400)
    turned = np.where(sweep.recording < 200, 2 * sweep.recording, 799 - 2 * sweep.recording)
    there_and_back = np.abs(sweep.velocity[::30])[turned]
    frame = replace(sweep, velocity=there_and_back, torque=np.zeros(sweep.size), theta=np.zeros(sweep.size))
    assert in_order(frame)
