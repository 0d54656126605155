"""A linear axis speaks of newtons and metres."""

from __future__ import annotations

import pytest

from bench.simulation.linear import all_in_metres, in_metres


@pytest.mark.parametrize(
    ("shaft", "axis"),
    [
        ("N*m", "N"),
        ("N*m*s/rad", "N*s/m"),
        ("N*m*s^2/rad^2", "N*s^2/m^2"),
        ("kg*m^2", "kg"),
        ("rad/s", "m/s"),
        ("friction modulated with the output angle", "friction modulated with the position"),
        ("f(angle=0.2)*d", "f(position=0.2)*d"),
        ("gradual, J/K, theta_m", "gradual, J/K, theta_m"),
        ("distance at the motor shaft over which it builds up", "distance at the motor over which it builds up"),
        ("inertia of the input side", "mass of the input side"),
        ("constant offset of the motor torque.", "constant offset of the motor force."),
        ("Motor torque: all loads, load torques", "Motor force: all loads, load forces"),
        ("motor_torque += f(angle), f a table", "motor_torque += f(position), f a table"),
        (
            "motor.inertia.J, load_torque, aux/torque, torque.csv",
            "motor.inertia.J, load_torque, aux/torque, torque.csv",
        ),
    ],
)
def test_units_and_words(shaft: str, axis: str) -> None:
    assert in_metres(shaft) == axis


def test_names_of_files_and_effects_stay() -> None:
    content = {
        "file": "rad/N*m.h5",
        "findings": [{"effect": "load.rad", "name": "a rad", "parameters": [{"unit": "N*m"}]}],
    }
    told = all_in_metres(content)
    assert told["file"] == "rad/N*m.h5"
    assert told["findings"] == [{"effect": "load.rad", "name": "a m", "parameters": [{"unit": "N"}]}]
