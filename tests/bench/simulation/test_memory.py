"""Terms with a memory against closed forms and against what defines them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.simulation.frame import Frame
from bench.simulation.memory import campaign_lag, integral, lag, loss_lag, play, relaxing, warmed_between
from bench.simulation.quantities import QUICK_WARMING_S, SLOW_WARMING_S, WARMING_S, quantity
from bench.simulation.terms import LIBRARY
from bench.simulation.terms.loops import BETWEEN
from tests.bench.simulation.terms.frames import ROWS, STEP_S, frame

FRAME = frame()


@given(half_width=st.floats(0.01, 100.0), swing=st.floats(0.1, 500.0))
def test_play_never_leaves_its_band_and_moves_only_when_pushed(half_width: float, swing: float) -> None:
    x = swing * np.sin(0.7 * FRAME.elapsed)
    p = play(x, FRAME, half_width)
    rounding = 4.0 * np.spacing(np.abs(x).max() + half_width)  # of x - half_width and of the difference asked here
    assert np.all(np.abs(x - p) <= half_width + rounding)
    inside = np.abs(x[1:] - p[:-1]) < half_width * (1.0 - 1e-9)
    same = FRAME.recording[1:] == FRAME.recording[:-1]
    assert np.all(p[1:][inside & same] == p[:-1][inside & same])


def test_play_narrower_than_its_motion_follows_the_flank() -> None:
    x = np.linspace(0.0, 5.0, FRAME.size)
    p = play(x, FRAME, 1.0, "kept")
    assert p[-1] == pytest.approx(4.0)


def test_lag_of_a_step_is_an_exponential() -> None:
    x = np.where(FRAME.elapsed > 0.0, 1.0, 0.0)
    y = lag(x, FRAME, 2.0)
    rows = slice(0, ROWS)
    assert y[rows] == pytest.approx(1.0 - np.exp(-FRAME.elapsed[rows] / 2.0), abs=1e-12)


def test_lag_of_a_constant_is_the_constant() -> None:
    assert lag(np.full(FRAME.size, 7.0), FRAME, 3.0) == pytest.approx(np.full(FRAME.size, 7.0))
    assert campaign_lag(np.full(FRAME.size, 7.0), FRAME, 3.0) == pytest.approx(np.full(FRAME.size, 7.0))


def test_lag_over_the_campaign_forgets_within_a_long_gap() -> None:
    x = FRAME.recording.astype(float)
    y = campaign_lag(x, FRAME, 1.0)
    assert np.abs(y - x).max() < 0.01


def test_integral_of_a_cosine_is_the_sine_and_begins_anew_in_each_recording() -> None:
    y = integral(np.cos(0.4 * FRAME.elapsed), FRAME)
    assert y == pytest.approx(np.sin(0.4 * FRAME.elapsed) / 0.4, abs=STEP_S**2)
    assert np.all(y[[0, ROWS, 2 * ROWS]] == 0.0)


@given(scale=st.floats(0.01, 10.0))
def test_a_relaxing_state_approaches_the_sign_of_motion_with_its_distance(scale: float) -> None:
    x = np.concatenate([np.linspace(0.0, 3.0, ROWS)] * 3)
    z = relaxing(x, FRAME, scale)[:ROWS]
    assert z == pytest.approx(1.0 - np.exp(-x[:ROWS] / scale), abs=1e-9)


def test_a_released_state_follows_its_input_to_zero_between_recordings() -> None:
    x = np.concatenate([np.linspace(0.0, 10.0, 50), np.linspace(3.0, 4.0, 50)])
    frame = replace(FRAME.take(np.zeros(100, dtype=np.int64)), recording=np.repeat([0, 1], 50))
    fresh, kept, released = (play(x, frame, 2.0, between)[50] for between in BETWEEN)
    # 10 leaves the play at 8, released at 2; then 3 is within two of 2 and of neither other
    assert (fresh, kept, released) == (1.0, 5.0, 2.0)


@given(scale=st.floats(0.01, 10.0), height=st.floats(0.5, 3.0), rate=st.floats(0.01, 3.0))
def test_a_state_relaxes_to_its_height_and_stays_at_rest(scale: float, height: float, rate: float) -> None:
    x = np.concatenate([np.linspace(0.0, 3.0, ROWS)] * 3)
    z = relaxing(x, FRAME, scale, height=height)[:ROWS]
    assert z == pytest.approx(height * (1.0 - np.exp(-x[:ROWS] / (height * scale))), abs=1e-9)
    # whatever the speed reads while nothing moves, and however long: nothing is gained
    still = np.where(np.arange(x.size) % ROWS < ROWS // 2, x, 1.0)
    heights = np.where(np.arange(x.size) % 2, height, 1.0)
    kept = relaxing(still, FRAME, scale, "kept", height=heights)
    assert np.all(np.abs(kept) <= max(height, 1.0) + 1e-9)
    z = relaxing(x, FRAME, scale, "fresh", rate, np.full(x.size, height))[:ROWS]
    assert np.all(z <= height + 1e-9)


@given(scale=st.floats(0.05, 10.0), rate=st.floats(0.01, 3.0))
def test_a_state_that_forgets_is_smaller_in_motion_and_gone_at_rest(scale: float, rate: float) -> None:
    speed, turn = 0.3, ROWS // 2
    x = speed * np.minimum(FRAME.elapsed, FRAME.elapsed[turn])
    z = relaxing(x, FRAME, scale, "fresh", rate)[:ROWS]
    share = speed / scale
    moving = share / (share + rate) * (1.0 - np.exp(-(share + rate) * FRAME.elapsed[: turn + 1]))
    assert z[: turn + 1] == pytest.approx(moving, abs=1e-9)
    resting = z[turn] * np.exp(-rate * (FRAME.elapsed[turn:ROWS] - FRAME.elapsed[turn]))
    assert z[turn:] == pytest.approx(resting, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "constant"), [("quick_warming", QUICK_WARMING_S), ("warming", WARMING_S), ("slow_warming", SLOW_WARMING_S)]
)
def test_a_gearbox_that_warms_is_warmer_than_it_was(name: str, constant: float) -> None:
    rate = 0.02
    warm = replace(FRAME, temperature=20.0 + rate * FRAME.time)
    warming = quantity(name, warm)
    # a lag follows a ramp by the time constant times its rate
    expected = rate * constant * (1.0 - np.exp(-(FRAME.time - FRAME.time[0]) / constant))
    assert warming == pytest.approx(expected, rel=1e-6, abs=1e-9)
    assert np.allclose(quantity(name, replace(FRAME, temperature=np.full(FRAME.size, 31.0))), 0.0)


def test_only_rises_between_recordings_are_summed_up() -> None:
    at = FRAME.recording.astype(float)
    begins = np.array([20.0, 23.0, 22.0, 30.0])[: int(FRAME.recording.max()) + 1]
    rows = replace(FRAME, temperature=begins[FRAME.recording] + 1.0 * (FRAME.elapsed > 5.0))
    summed = warmed_between(rows)
    # each recording warms by 1 K itself: what began 3 K above where the last began has been warmed by 2 K between
    expected = np.cumsum(np.maximum(np.diff(begins, prepend=begins[0] + 1.0) - 1.0, 0.0))
    assert np.array_equal(summed, expected[FRAME.recording])
    assert np.array_equal(warmed_between(rows.take(at > 0)), (expected - expected[1])[FRAME.recording[at > 0]])


def test_before_a_recording_that_begins_at_rest_nothing_is_lost() -> None:
    starts = np.flatnonzero(np.diff(FRAME.recording, prepend=-1))
    moving = replace(FRAME, power=np.full(FRAME.size, 50.0))
    assert loss_lag(moving, 3.0) == pytest.approx(campaign_lag(moving.power, moving, 3.0))
    direction = moving.direction.copy()
    direction[starts[1:]] = 0.0
    rests = loss_lag(replace(moving, direction=direction), 3.0)
    # the pause is long: of what was lost before nothing is left, and the lag begins anew
    since = FRAME.elapsed[starts[1] : starts[2]]
    assert rests[starts[1] : starts[2]] == pytest.approx(50.0 * (1.0 - np.exp(-since / 3.0)), abs=0.5)
    assert rests[: starts[1]] == pytest.approx(np.full(starts[1], 50.0))


def test_a_loop_that_follows_its_input_between_recordings_goes_on_as_if_there_were_none() -> None:
    x = 40.0 * np.sin(0.9 * FRAME.elapsed) + 25.0 * FRAME.recording
    whole = replace(FRAME, recording=np.zeros(FRAME.size, dtype=np.int64))
    followed, kept = (relaxing(x, FRAME, 30.0, between) for between in ("followed", "kept"))
    # in one recording a state begins at the first value of its input; before a campaign that is 0
    first = relaxing(np.concatenate(([0.0], x)), _with_a_row_before(whole), 30.0)[1:]
    assert followed == pytest.approx(first, abs=1e-12)
    assert np.abs(kept - followed).max() > 0.1


def _with_a_row_before(one: Frame) -> Frame:
    return one.take(np.concatenate(([0], np.arange(one.size))))


def test_a_loop_is_turned_by_its_load_alone_however_a_recording_is_cut() -> None:
    """A load that is the same in the next recording turns nothing; a sensor's noise is kept from it by a play."""
    load = np.concatenate([np.linspace(0.0, 90.0, 40), np.linspace(90.0, 70.0, 20), np.full(FRAME.size - 60, 70.0)])
    term = LIBRARY["te.hysteresis"]
    uncut = replace(FRAME, torque_level=load, recording=np.zeros(FRAME.size, dtype=np.int64))
    cut = replace(uncut, recording=np.repeat(np.arange(FRAME.size // 10), 10)[: FRAME.size])
    for name in ("bouc_wen_followed", "play_kept", "pair_kept", "stack_kept"):
        form = term.form("transmission_error", name)
        assert form is not None
        point = (40.0, 2.0)[: len(form.nonlinear)]
        assert form.columns(cut, point) == pytest.approx(form.columns(uncut, point), abs=1e-9)
    old = term.form("transmission_error", "bouc_wen_kept")
    assert old is not None
    assert old.grid(uncut) == ()  # files have it, no search looks for it
