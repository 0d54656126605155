"""A lubricant that softens beyond a temperature: a knee in the offset of the transmission error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.mismatch.regression.problem import BaseTerm
from bench.mismatch.regression.regressors import Named, named
from bench.mismatch.regression.search import searched
from bench.mismatch.regression.succession import settle
from bench.simulation.terms import LIBRARY, TRANSMISSION_ERROR
from tests.bench.mismatch.regression.synthetic import campaign, problem

EFFECT = "te.temperature_nonlinear"
RECORDINGS, SLOPE, NOISE = 48, 1e-4, 5e-6


def test_a_knee_is_found_with_its_place_and_slope() -> None:
    frame = campaign(RECORDINGS)
    low, high = float(frame.temperature.min()), float(frame.temperature.max())
    knee, width = low + 0.55 * (high - low), 0.04 * (high - low)
    rise = SLOPE * width * np.logaddexp(0.0, (frame.temperature - knee) / width)
    y = rise + np.random.default_rng(2).normal(scale=NOISE, size=frame.size)
    term = LIBRARY["te.offset"]
    base = (BaseTerm(Named(term, TRANSMISSION_ERROR, term.forms[TRANSMISSION_ERROR][0])),)
    search = searched(replace(problem(frame, y), channel=TRANSMISSION_ERROR, base=base))
    settle(search)
    (found,) = search.model.chosen
    regressor = found.main.regressor
    assert isinstance(regressor, Named)
    assert (found.effect, regressor.form.name) == (EFFECT, "knee")
    assert regressor.point[0] == pytest.approx(knee, abs=0.05 * (high - low))


def test_far_beyond_the_knee_it_is_a_straight_line_and_far_below_it_is_nothing() -> None:
    frame = campaign(2)
    warm = replace(frame, temperature=np.linspace(20.0, 60.0, frame.size))
    column = named(EFFECT, TRANSMISSION_ERROR, "knee", (40.0, 0.5)).columns(warm)[:, 0]
    beyond = np.maximum(warm.temperature - 40.0, 0.0)
    assert column == pytest.approx(beyond, abs=0.5 * np.log(2.0) + 1e-9)
    assert column[0] == pytest.approx(0.0, abs=1e-12)
    assert column[-1] == pytest.approx(20.0, abs=1e-12)
