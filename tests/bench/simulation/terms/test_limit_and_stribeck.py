"""A reported torque that is limited, and Stribeck friction at the speeds that were measured."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign

LIMIT, SHARP, DRAG, VISCOUS = 3.0, 40.0, 0.4, 0.002


def test_a_sharp_limit_cuts_off() -> None:
    frame = campaign(20)
    frame = replace(frame, torque_level=np.linspace(-1000.0, 1000.0, frame.size))
    form = LIBRARY["motor.torque_constant"].form(MOTOR_TORQUE, "limit")
    assert form is not None
    load, taken = form.columns(frame, (LIMIT, SHARP, DRAG, VISCOUS)).T
    shaft = frame.torque_level / frame.ratio + DRAG * frame.direction + VISCOUS * frame.omega
    assert np.array_equal(load, frame.torque_level / frame.ratio)
    assert np.ptp(shaft) > 2.0 * LIMIT
    np.testing.assert_allclose(shaft + taken, np.clip(shaft, -LIMIT, LIMIT), atol=0.02 * LIMIT)


def test_a_limit_far_away_takes_nothing() -> None:
    frame = campaign(20)
    form = LIBRARY["motor.torque_constant"].form(MOTOR_TORQUE, "limit")
    assert form is not None
    taken = form.columns(frame, (1e3, 3.0, DRAG, VISCOUS))[:, 1]
    assert np.max(np.abs(taken)) < 1e-6


@pytest.mark.parametrize("slowest", [1.0, 60.0])
def test_stribeck_speeds_are_those_that_were_measured(slowest: float) -> None:
    """A curve of which e to the minus seventy is seen has any size that one likes."""
    frame = campaign(20)
    speed = np.linspace(slowest, 170.0, frame.size)
    frame = replace(frame, velocity=speed / frame.ratio, direction=np.ones(frame.size))
    term = LIBRARY["friction.stribeck"]
    form = term.form(MOTOR_TORQUE, "gaussian")
    assert form is not None
    for point in form.grid(frame):
        assert np.max(np.abs(form.columns(frame, point))) > 1e-4
    assert max(p[0] for p in form.grid(frame)) > slowest / 3.0
