"""States with a memory: driven by the recordings or not, handed on from one recording to the next."""

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.given import Known
from bench.mismatch.prediction import evaluated
from bench.mismatch.regression.candidates import exercised
from bench.mismatch.regression.regressors import named
from bench.simulation.terms import MOTOR_TORQUE, TRANSMISSION_ERROR
from tests.bench.simulation.terms.frames import at_loads_and_speeds

LOADS = (-900.0, -600.0, -300.0, 300.0, 600.0, 900.0)
SPEEDS = (0.05, 0.08, 0.12, 0.17)
EACH = 40


@pytest.mark.parametrize(("path", "driven"), [("steady", False), ("up and down", True)])
def test_loops_are_driven_where_the_load_goes_up_and_down(path: str, driven: bool) -> None:
    rise = np.linspace(0.0, 1.0, EACH // 2)
    rows = at_loads_and_speeds(np.ones(EACH) if path == "steady" else np.concatenate([rise, rise[::-1]]), LOADS, SPEEDS)
    loop = named("te.hysteresis", TRANSMISSION_ERROR, "play", (200.0,))
    assert exercised(loop, loop.columns(rows), rows) is driven
    plain = named("te.lost_motion", TRANSMISSION_ERROR, "tanh", (100.0,))
    assert exercised(plain, plain.columns(rows), rows)


def test_friction_that_builds_up_is_predicted_sample_by_sample_where_the_motion_turns() -> None:
    samples = at_loads_and_speeds(np.ones(EACH), (0.0,), SPEEDS)
    angle = 0.3 * np.sin(0.45 * np.arange(samples.size))
    direction = np.sign(np.gradient(angle))
    samples = replace(samples, theta=angle, q=angle, direction=direction, last_direction=direction)
    campaign = samples.take(np.arange(3, samples.size, 4))
    building = Known(named("friction.presliding", MOTOR_TORQUE, "dahl_kept", (5.0,)), np.array([2.0]))
    whole = building.regressor.columns(samples)[:, 0] * 2.0
    last = samples.recording == samples.recording[-1]
    told = evaluated(building, samples.take(last), campaign)
    assert told == pytest.approx(whole[last], abs=0.1)
    fresh = evaluated(building, samples.take(last), None)
    assert np.abs(fresh - whole[last]).max() > 0.1
