"""A Stribeck curve whose speed follows the lubricant's temperature, up or down, and one whose speed does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.candidates import named_candidates
from bench.mismatch.regression.regressors import Named
from bench.mismatch.regression.search import searched
from bench.simulation.frame import FloatArray
from bench.simulation.terms import MOTOR_TORQUE
from tests.bench.mismatch.regression.synthetic import campaign, problem

FRAME = campaign(40, 1)
SPEED, SIZE, NOISE = 6.0, 0.3, 0.005


def curve(beta: float, exponent: float) -> FloatArray:
    """The friction (n,) of a curve whose speed is ``SPEED`` at 25 degC and rises by ``beta`` a kelvin."""
    speed = SPEED * np.exp(beta * (FRAME.temperature - 25.0))
    return np.asarray(SIZE * FRAME.direction * np.exp(-((np.abs(FRAME.omega) / speed) ** exponent)))


def found(extra: FloatArray) -> Named:
    """The one effect beside dry and viscous friction."""
    noise = np.random.default_rng(4).normal(0.0, NOISE, FRAME.size)
    (effect,) = searched(problem(FRAME, 0.4 * FRAME.direction + 0.01 * FRAME.omega + extra + noise)).model.chosen
    regressor = effect.main.regressor
    assert isinstance(regressor, Named)
    return regressor


@pytest.mark.parametrize(("beta", "exponent"), [(-0.03, 1.0), (0.04, 2.0), (-0.03, 0.85)])
def test_a_stribeck_speed_that_follows_the_temperature_is_found(beta: float, exponent: float) -> None:
    regressor = found(curve(beta, exponent))
    assert (regressor.effect, regressor.form.name) == ("friction.stribeck", "hersey")
    assert regressor.variables == ("speed", "temperature")
    speed, rate, power = regressor.point
    assert speed == pytest.approx(SPEED, rel=0.05)
    assert rate == pytest.approx(beta, abs=0.004)
    assert power == pytest.approx(exponent, abs=0.1)


@pytest.mark.parametrize(("exponent", "form"), [(1.0, "exponential"), (2.0, "gaussian")])
def test_a_stribeck_speed_that_stays_needs_no_temperature(exponent: float, form: str) -> None:
    regressor = found(curve(0.0, exponent))
    assert (regressor.effect, regressor.form.name) == ("friction.stribeck", form)
    assert regressor.variables == ("speed",)


def test_where_the_temperature_is_constant_nothing_follows_it() -> None:
    def forms(frame: object) -> set[str]:
        return {c.form.name for c in named_candidates(MOTOR_TORQUE, frame, ()) if c.effect == "friction.stribeck"}  # type: ignore[arg-type]

    cool = replace(FRAME, temperature=np.full(FRAME.size, 25.0))
    assert forms(FRAME) - forms(cool) == {"hersey"}
