"""A gain error of the torque sensor that grows with temperature, and one that does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.given import Known
from bench.mismatch.prediction import corrected
from bench.mismatch.regression.problem import BaseTerm, ChannelProblem
from bench.mismatch.regression.regressors import Named, named
from bench.mismatch.regression.search import searched
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LIBRARY, LOAD_TORQUE
from tests.bench.mismatch.regression.synthetic import EACH, campaign, problem

MADE = campaign(40, 3)
TURNED = np.where(MADE.elapsed < 0.5 * EACH, 1.0, -1.0)
FRAME = replace(MADE, direction=TURNED, load_motor_torque=MADE.torque, load_motor_level=MADE.torque)
FRICTION = LIBRARY["load.bearing_friction"].forms[LOAD_TORQUE][0]
GAIN, PER_KELVIN, NOISE = 0.006, 2.5e-4, 1.3


def measured(per_kelvin: float) -> ChannelProblem:
    """What the sensor reads beyond the load motor's torque: friction at the output, and its own gain error."""
    gain = GAIN + per_kelvin * (FRAME.temperature - 25.0)
    noise = np.random.default_rng(5).normal(0.0, NOISE, FRAME.size)
    y = 7.0 * FRAME.direction + gain * FRAME.load_motor_level + noise
    base = (BaseTerm(named("load.bearing_friction", LOAD_TORQUE, FRICTION.name)),)
    return replace(problem(FRAME, y), channel=LOAD_TORQUE, base=base)


def known(per_kelvin: float) -> Known:
    return Known(named("sensor.torque_gain", LOAD_TORQUE, "temperature"), np.array([GAIN, per_kelvin]))


@pytest.mark.parametrize(("per_kelvin", "form"), [(PER_KELVIN, "temperature"), (0.0, "gain")])
def test_a_gain_is_told_with_what_it_depends_on(per_kelvin: float, form: str) -> None:
    model = searched(measured(per_kelvin)).model
    (effect,) = model.chosen
    regressor = effect.main.regressor
    assert isinstance(regressor, Named)
    assert (regressor.effect, regressor.form.name) == ("sensor.torque_gain", form)
    values, covariance = model.fit.of(effect.main.indices)
    true = np.array([GAIN, per_kelvin][: values.size])
    assert np.all(np.abs(values - true) < 4.0 * np.sqrt(np.diag(covariance)))


def test_the_torque_is_corrected_by_the_gain_at_its_temperature() -> None:
    hot = FRAME.temperature - 25.0
    read = FRAME.torque * (1.0 + GAIN + PER_KELVIN * hot)
    off = read - corrected(replace(FRAME, torque=read, torque_level=read), [known(PER_KELVIN)]).torque
    assert off == pytest.approx((GAIN + PER_KELVIN * hot) * FRAME.load_motor_level)


def test_where_the_load_is_kept_the_correction_is_that_of_the_mean_temperature() -> None:
    """A segment at one load, in which the temperature drifts, has one mean error."""
    warming: FloatArray = 30.0 + 0.05 * FRAME.elapsed
    kept = replace(FRAME, kept=np.ones(FRAME.size), followed=np.zeros(FRAME.size), temperature=warming)
    off = kept.torque - corrected(kept, [known(PER_KELVIN)]).torque
    mean = GAIN + PER_KELVIN * (float(warming[FRAME.recording == 0].mean()) - 25.0)
    assert off == pytest.approx(mean * FRAME.load_motor_level)
