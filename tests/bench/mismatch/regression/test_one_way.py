"""A drift goes one way: what comes and goes with time has not its name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.beside import shaped
from bench.mismatch.regression.one_way import one_way
from bench.mismatch.regression.problem import BaseTerm, ChannelProblem
from bench.mismatch.regression.regressors import Named, named
from bench.mismatch.regression.search import begun, searched
from bench.mismatch.regression.succession import settle
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LIBRARY, TRANSMISSION_ERROR
from tests.bench.mismatch.regression.synthetic import campaign, problem

RECORDINGS, SIZE, NOISE = 48, 4e-5, 5e-6
MADE = campaign(RECORDINGS)
FRAME = replace(MADE, velocity=np.random.default_rng(4).permutation(np.unique(MADE.velocity))[MADE.recording])
SHARE = FRAME.time / FRAME.time.max()


def measured(level: FloatArray, frame: Frame = FRAME) -> ChannelProblem:
    """A transmission error's offset with a compliance, and a level that changes."""
    rng = np.random.default_rng(2)
    y = -3e-4 * frame.torque / 1000.0 + SIZE * level + rng.normal(scale=NOISE, size=frame.size)
    term = LIBRARY["te.offset"]
    base = (BaseTerm(Named(term, TRANSMISSION_ERROR, term.forms[TRANSMISSION_ERROR][0])),)
    return replace(problem(frame, y), channel=TRANSMISSION_ERROR, base=base)


def found(own: ChannelProblem) -> set[str]:
    search = searched(own)
    settle(search)
    return {c.effect for c in search.model.chosen}


def test_what_rises_and_falls_by_more_than_its_errors_goes_not_one_way() -> None:
    rise, hump = np.linspace(0.0, 1.0, 9), np.sin(np.linspace(0.0, np.pi, 9))
    small = 0.02**2 * np.eye(9)
    assert one_way(rise, small)
    assert one_way(-rise, small)
    assert not one_way(hump, small)
    assert one_way(hump, np.eye(9))
    # less than a form may be off
    assert one_way(rise + 0.1 * hump, 1e-6 * np.eye(9))


@pytest.mark.parametrize(
    ("level", "effect"),
    [
        (1.0 - np.exp(-SHARE / 0.2), "te.drift_time"),
        (np.tanh((SHARE - 0.5) / 0.05), "te.drift_time"),
        ((SHARE > 0.55).astype(float), "te.drift_time"),
        (((SHARE > 0.3) & (SHARE < 0.7)).astype(float), "unknown"),
        (np.exp(-(((SHARE - 0.5) / 0.15) ** 2)), "unknown"),
    ],
)
def test_a_level_over_time_is_a_drift_where_it_goes_one_way(level: FloatArray, effect: str) -> None:
    assert found(measured(level)) == {effect}


def test_a_steep_law_of_a_temperature_that_comes_and_goes_is_no_drift() -> None:
    """The temperature is a function of time, and its thermometer is noisy: a table over time predicts better."""
    rng = np.random.default_rng(3)
    temperature = 31.0 + 9.0 * np.sin(2.0 * np.pi * SHARE)
    read = temperature + np.repeat(rng.normal(scale=0.8, size=RECORDINGS), FRAME.size // RECORDINGS)
    frame = replace(FRAME, temperature=read)
    effects = found(measured(np.tanh((temperature - 31.0) / 2.0), frame))
    assert "te.drift_time" not in effects
    assert effects == {"te.temperature_nonlinear"}


def test_a_film_with_a_power_of_the_speed_is_told_with_its_power() -> None:
    own = measured(2.0 / (1.0 + (np.abs(FRAME.velocity) / 0.03) ** 1.6))
    assert found(own) == {"te.velocity_nonlinear"}
    film = shaped(begun(own), [], named("te.velocity_nonlinear", TRANSMISSION_ERROR, "power", (0.05, 2.2)))
    assert film is not None
    assert isinstance(film.main.regressor, Named)
    assert film.main.regressor.point == pytest.approx((0.03, 1.6), rel=0.15)
