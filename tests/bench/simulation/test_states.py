"""Quantities that are states: they follow what was driven before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.errors import ConfigurationError
from bench.simulation.memory import taken_along
from bench.simulation.quantities import (
    QUANTITIES,
    RECENT,
    STATE_TIMES_S,
    STATES,
    TAKEN_ALONG,
    kind_of,
    label,
    quantity,
    state_named,
    state_of,
)
from tests.bench.simulation.terms.frames import ROWS, frame

FRAME = frame()


@given(reach=st.floats(0.01, 10.0), swing=st.floats(0.1, 50.0))
def test_what_is_taken_along_slips_at_its_reach_and_follows_before(reach: float, swing: float) -> None:
    x = 3.0 + swing * np.sin(0.7 * FRAME.elapsed)
    wound = taken_along(x, FRAME, reach)
    rounding = 8.0 * np.spacing(np.abs(x).max() + reach)
    assert wound[0] == 0.0
    assert np.all(np.abs(wound) <= reach + rounding)
    # inside its reach it follows; where it does not, it stands at an end
    follows = np.abs(np.diff(wound) - np.diff(x)) <= rounding
    assert np.all(follows | (np.abs(np.abs(wound[1:]) - reach) <= rounding))


def test_it_goes_on_between_recordings() -> None:
    x = np.concatenate([np.linspace(0.0, 1.0, ROWS), np.full(ROWS, 1.0), np.full(ROWS, 0.8)])
    wound = taken_along(x, FRAME, 0.5)
    assert wound[ROWS - 1] == wound[ROWS] == pytest.approx(0.5)
    assert wound[2 * ROWS] == pytest.approx(0.3)


@pytest.mark.parametrize("seconds", STATE_TIMES_S)
def test_a_recent_speed_follows_a_step_with_its_time_constant(seconds: float) -> None:
    time = np.arange(FRAME.size) * 1.0
    one = replace(FRAME, recording=np.zeros_like(FRAME.recording), time=time, velocity=np.where(time > 0.0, -0.2, 0.0))
    follows = quantity(f"recent_speed_{seconds:g}s", one)
    # between two rows the speed runs straight from one to the other
    expected = 0.2 * (1.0 - np.exp(-(time - 0.5) / seconds))
    assert follows[1:] == pytest.approx(expected[1:], abs=0.2 / seconds**2)


def test_every_candidate_is_a_state_with_a_label_and_finite_values() -> None:
    for name in (*(n for names in RECENT.values() for n in names), *TAKEN_ALONG):
        assert state_of(name) is not None
        assert np.isfinite(quantity(name, FRAME)).all()
    assert {kind_of(name) for name in TAKEN_ALONG} | set(RECENT) == STATES
    assert label("recent_loss_50s") == "loss, lagged by 50 s"
    assert label("taken_along_1235mrad") == "angle taken along by up to 1.235 rad"
    assert QUANTITIES["recent_load_50s"].unit == "kN^2*m^2"


@given(kind=st.sampled_from(sorted(STATES)), scale=st.floats(1.0, 1e5))
def test_a_state_is_known_by_its_name_at_any_scale(kind: str, scale: float) -> None:
    found = state_of(state_named(kind, scale))
    assert found is not None
    assert found[0] == kind
    assert found[1] == pytest.approx(scale, abs=5.1e-4 if kind == "taken_along" else 0.51)


def test_what_only_begins_like_a_state_is_none() -> None:
    for name in (
        "recent_speed",
        "recent_speed_s",
        "recent_speed_8mrad",
        "taken_along_5s",
        "recent_speed_0s",
        "recent_speed_8.5s",
        "speed",
        "taken_along",
    ):
        assert state_of(name) is None
        assert kind_of(name) == name
    with pytest.raises(ConfigurationError, match=r"recent_speed_x.* or a state such as recent_speed_50s"):
        quantity("recent_speed_x", FRAME)
