"""Quantities that are states: they follow what was driven before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.errors import ConfigurationError
from bench.mismatch.recordings.rows import reduced
from bench.simulation.frame import gone_through
from bench.simulation.memory import limited_integral, taken_along, worked_up
from bench.simulation.quantities import (
    OF_KIND,
    QUANTITIES,
    REMEMBERED,
    STATE_TIMES_S,
    STATES,
    kind_of,
    label,
    made_of,
    quantity,
    state_named,
    state_of,
    viscosity,
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


@given(limit=st.floats(1.0, 1e5), swing=st.floats(1.0, 1e3))
def test_an_impulse_stops_at_its_limit_and_is_the_integral_before(limit: float, swing: float) -> None:
    x = swing * (0.2 + np.sin(0.7 * FRAME.elapsed))
    came = limited_integral(x, FRAME, limit)
    assert np.all(np.abs(came) <= limit)
    before = np.concatenate(([0.0], came[:-1]))
    same = FRAME.recording[1:] == FRAME.recording[:-1]
    area = np.append(0.0, np.where(same, 0.5 * (x[1:] + x[:-1]) * np.diff(FRAME.time), 0.0))
    follows = np.isclose(came - before, area, rtol=0.0, atol=1e-9 * limit)
    pushed = (np.abs(came) == limit) & (np.sign(area) == np.sign(came))
    assert np.all(follows | pushed)


def test_an_impulse_goes_on_between_recordings() -> None:
    x = np.concatenate([np.full(ROWS, 10.0), np.zeros(ROWS), np.full(ROWS, -10.0)])
    came = limited_integral(x, FRAME, 1e6)
    whole = 10.0 * (FRAME.time[ROWS - 1] - FRAME.time[0])
    assert came[ROWS - 1] == came[ROWS] == came[2 * ROWS] == pytest.approx(whole)
    assert came[-1] == pytest.approx(0.0, abs=1e-9 * whole)


def test_an_impulse_of_rows_of_unequal_length_is_that_of_the_samples() -> None:
    edges = np.flatnonzero(np.isin(np.arange(FRAME.size) % ROWS % 43, [0, 2, 5, 40]))
    whole = limited_integral(FRAME.torque, FRAME, 400.0)
    rows = reduced(FRAME, edges)
    number = np.add.reduceat(FRAME.count, edges)
    mean = np.add.reduceat(whole * FRAME.count, edges) / number
    short = limited_integral(rows.torque, rows, 400.0)
    assert np.abs(short - mean).max() < 0.08 * np.ptp(mean)


@given(rest=st.floats(5.0, 500.0), motion=st.floats(1.0, 50.0))
def test_what_motion_works_up_rest_restores(rest: float, motion: float) -> None:
    turns = (np.arange(FRAME.size) // 50 % 2).astype(float)
    state = worked_up(turns, FRAME, rest, motion)
    assert np.all((state >= 0.0) & (state <= 1.0))
    same = (FRAME.recording[1:] == FRAME.recording[:-1]) & (turns[1:] == turns[:-1])
    step = np.diff(FRAME.time)[same]
    left = np.where(turns[1:] > 0.5, 1.0 - state[1:], state[1:])[same]
    before = np.where(turns[1:] > 0.5, 1.0 - state[:-1], state[:-1])[same]
    assert left == pytest.approx(before * np.exp(-step / np.where(turns[1:][same] > 0.5, motion, rest)), abs=1e-12)


def test_between_recordings_it_is_restored_whatever_they_end_with() -> None:
    state = worked_up(np.ones(FRAME.size), FRAME, 30.0, 4.0)
    (begin,) = np.flatnonzero(FRAME.recording == 1)[:1]
    gap = FRAME.time[begin] - FRAME.elapsed[begin] - FRAME.time[begin - 1]
    restored = state[begin - 1] * np.exp(-gap / 30.0)
    assert gap > 0.0
    assert state[begin] == pytest.approx(1.0 + (restored - 1.0) * np.exp(-FRAME.elapsed[begin] / 4.0))


def test_states_go_on_through_rows_that_lie_aside() -> None:
    beside = FRAME.recording == 1
    apart = replace(FRAME.take(~beside), aside=FRAME.take(beside))
    for name in (
        "impulse_600Nms",
        "recent_torque_50s",
        "recent_speed_8s",
        "taken_along_200mrad",
        "worked_in_4s_50s",
        "film_40Nm",
        "warming",
    ):
        assert quantity(name, apart) == pytest.approx(quantity(name, FRAME)[~beside], abs=1e-9)
    assert gone_through(apart).torque == pytest.approx(FRAME.torque)


@pytest.mark.parametrize("seconds", STATE_TIMES_S)
def test_a_recent_speed_follows_a_step_with_its_time_constant(seconds: float) -> None:
    time = np.arange(FRAME.size) * 1.0
    one = replace(FRAME, recording=np.zeros_like(FRAME.recording), time=time, velocity=np.where(time > 0.0, -0.2, 0.0))
    follows = quantity(f"recent_speed_{seconds:g}s", one)
    # between two rows the speed runs straight from one to the other
    expected = 0.2 * (1.0 - np.exp(-(time - 0.5) / seconds))
    assert follows[1:] == pytest.approx(expected[1:], abs=0.2 / seconds**2)


def test_every_candidate_is_a_state_with_a_label_and_finite_values() -> None:
    for kind, names in OF_KIND.items():
        for name in names:
            assert kind_of(name) == kind
            assert np.isfinite(quantity(name, FRAME)).all()
    assert set(OF_KIND) == STATES
    assert label("recent_loss_50s") == "loss, lagged by 50 s"
    assert label("taken_along_1235mrad") == "angle taken along by up to 1.235 rad"
    assert label("impulse_793Nms") == "impulse of the load torque between stops at 793 N*m*s"
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
        "impulse_5s",
        "impulse_5mrad",
        "recent_speed_0s",
        "recent_speed_8.5s",
        "speed",
        "taken_along",
    ):
        assert state_of(name) is None
        assert kind_of(name) == name
    with pytest.raises(ConfigurationError, match=r"recent_speed_x.* or a state such as recent_speed_50s"):
        quantity("recent_speed_x", FRAME)


def test_a_film_is_the_thicker_the_faster_the_colder_and_the_less_loaded() -> None:
    assert viscosity(np.array([40.0, 100.0])) == pytest.approx([100.0, 11.1], rel=1e-3)  # ISO VG 100, index 95
    whole = quantity("film_40Nm", FRAME)
    by = (
        np.log10(viscosity(FRAME.temperature))
        + np.log10(np.abs(FRAME.velocity))
        - np.log10(40.0 + np.abs(FRAME.torque))
    )
    assert whole == pytest.approx(by)
    assert state_of("film_40Nm") == ("film", 40.0)


def test_what_is_made_of_others_lies_where_these_do() -> None:
    assert made_of("film_33Nm") == ("speed", "torque", "temperature")
    assert made_of("load_power") == ("velocity", "torque")
    assert made_of("temperature") == ("temperature",)
    assert "film" not in REMEMBERED
