from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from bench.configuration import load_bench
from bench.safety import (
    Cause,
    Deadlines,
    Inputs,
    LadderState,
    Observation,
    Rung,
    SafetySettings,
    SafetyState,
    climb,
    describe,
    first_rung,
    is_device_fault,
    settings,
    step,
)
from bench.safety.rules import bounds

DT = 5e-4
FloatArray = NDArray[np.float64]
RATIO = 185.0
N = 3000
ENABLED = 0x1237


@pytest.fixture(scope="module")
def limits() -> SafetySettings:
    return settings(load_bench("rh380n").configuration.limits, RATIO, DT, 0.5)


def with_limits(of: SafetySettings, changed: Mapping[Cause, float | None]) -> SafetySettings:
    """Settings with some limits changed."""
    limits = {**of.limits, **changed}
    return replace(of, limits=limits, bounds=bounds(limits))


def healthy(n: int = N, speed: float = 32.0) -> Inputs:
    """A bench that turns steadily under 500 N·m with a little noise everywhere."""
    rng = np.random.default_rng(1)
    motor: FloatArray = (speed * DT) * np.arange(n, dtype=np.float64)
    ones = np.ones(n)
    return Inputs(
        motor_counts=np.round(motor * 8192 / 6.283).astype(np.int64),
        load_counts=np.round(motor / RATIO * 2**25 / 6.283).astype(np.int64),
        torque_counts=np.round(1638 + rng.normal(0, 3, n)).astype(np.int64),
        motor_angle=motor,
        load_angle=motor / RATIO,
        motor_velocity=speed + rng.normal(0, 0.5, n),
        load_velocity=(speed + rng.normal(0, 0.5, n)) / RATIO,
        motor_torque=3.0 + rng.normal(0, 0.1, n),
        load_torque=500.0 + rng.normal(0, 1.0, n),
        load_motor_torque=495.0 + rng.normal(0, 1.0, n),
        temperature=30.0 + rng.normal(0, 0.02, n),
        temperature_age_s=0.02 * ones,
        velocity_setpoint=speed * ones,
        torque_setpoint=495.0 * ones,
        input_status=np.full(n, ENABLED),
        load_status=np.full(n, ENABLED),
        torque_bad=np.zeros(n, bool),
        emergency_stop=np.zeros(n, bool),
        safe_torque_off=np.zeros(n, bool),
        good=np.ones(n, bool),
    )


def with_change(name: str, at: int, value: object) -> Inputs:
    inputs = healthy()
    values = getattr(inputs, name).copy()
    values[at:] = value
    return replace(inputs, **{name: values})


def test_a_healthy_bench_runs_on(limits: SafetySettings) -> None:
    state, verdict = step(SafetyState.fresh(), healthy(), True, limits)
    assert not verdict.tripped
    assert not state.tripped


IMMEDIATE = [
    ("input_status", 0x1218, Cause.INPUT_DRIVE_FAULT),
    ("load_status", 0x1208, Cause.LOAD_DRIVE_FAULT),
    ("torque_bad", True, Cause.TORQUE_SENSOR_RANGE),
    ("emergency_stop", True, Cause.EMERGENCY_STOP),
    ("safe_torque_off", True, Cause.SAFE_TORQUE_OFF),
    ("temperature", np.nan, Cause.TEMPERATURE_SENSOR),
    ("temperature", 71.0, Cause.TEMPERATURE_HIGH),
    ("temperature", 4.0, Cause.TEMPERATURE_LOW),
    ("temperature", 40.0, Cause.TEMPERATURE_RATE),
    ("temperature_age_s", 5.1, Cause.TEMPERATURE_AGE),
    ("load_angle", 100.0, Cause.ENCODER_DISAGREEMENT),
    ("motor_angle", 100.0, Cause.ENCODER_DISAGREEMENT),
]


@pytest.mark.parametrize(("name", "value", "cause"), IMMEDIATE)
@hypothesis_settings(max_examples=15, deadline=None)
@given(at=st.integers(1, N - 1))
def test_trips_in_the_very_cycle(limits: SafetySettings, name: str, value: object, cause: Cause, at: int) -> None:
    _, verdict = step(SafetyState.fresh(), with_change(name, at, value), True, limits)
    assert (verdict.cause, verdict.cycle) == (cause, at)
    assert len(verdict.text) > 20


FILTERED = [
    ("motor_torque", -45.0, Cause.MOTOR_TORQUE, 0.05),
    ("load_torque", 30_000.0, Cause.LOAD_TORQUE, 0.05),
    ("load_torque", 655.0, Cause.TORQUE_DISAGREEMENT, 0.5),
    ("motor_velocity", 45.0, Cause.VELOCITY_ERROR, 0.2),
    ("motor_counts", 7, Cause.MOTOR_ENCODER_FROZEN, 0.6),
    ("load_counts", 7, Cause.LOAD_ENCODER_FROZEN, 0.6),
    ("torque_counts", 7, Cause.TORQUE_SENSOR_FROZEN, 0.6),
    ("motor_velocity", 32.0, Cause.MOTOR_VELOCITY_FROZEN, 0.6),
    ("load_velocity", 0.17, Cause.LOAD_VELOCITY_FROZEN, 0.6),
    ("motor_torque", 3.1, Cause.MOTOR_TORQUE_FROZEN, 0.6),
    ("load_motor_torque", 494.0, Cause.LOAD_MOTOR_TORQUE_FROZEN, 0.6),
    ("load_velocity", 2.0, Cause.LOAD_SPEED, 0.1),
    ("motor_velocity", 200.0, Cause.VELOCITY_ERROR, 0.01),
    ("velocity_setpoint", 36.5, Cause.FOLLOWING_ERROR, 1.3),
    ("load_torque", 950.0, Cause.LOAD_TORQUE_RATE, 0.05),
    ("torque_setpoint", 300.0, Cause.TORQUE_ERROR, 0.3),
    ("motor_torque", 12.0, Cause.FRICTION, 0.3),
]


@pytest.mark.parametrize(("name", "value", "cause", "within_s"), FILTERED)
def test_trips_within_its_filter_time(
    limits: SafetySettings, name: str, value: object, cause: Cause, within_s: float
) -> None:
    at = 500
    _, verdict = step(SafetyState.fresh(), with_change(name, at, value), True, limits)
    assert verdict.cause is cause
    assert at <= verdict.cycle <= at + within_s / DT


@pytest.mark.parametrize(
    ("changes", "cause"),
    [
        ({"motor_velocity": 400.0, "velocity_setpoint": 400.0}, Cause.MOTOR_SPEED),
        ({"load_torque": -1380.0, "load_motor_torque": -1390.0}, Cause.LOAD_TORQUE),
        ({"load_torque": -1250.0, "load_motor_torque": -1500.0}, Cause.LOAD_MOTOR_TORQUE),
    ],
)
def test_what_both_sides_agree_on_is_still_limited(
    limits: SafetySettings, changes: dict[str, float], cause: Cause
) -> None:
    unwatched = (Cause.MOTOR_ACCELERATION, Cause.LOAD_TORQUE_RATE, Cause.FRICTION, Cause.TORQUE_ERROR)
    limits = with_limits(limits, dict.fromkeys(unwatched))
    inputs = healthy()
    changed = {name: np.where(np.arange(N) < 500, getattr(inputs, name), value) for name, value in changes.items()}
    _, verdict = step(SafetyState.fresh(), replace(inputs, **changed), True, limits)
    assert verdict.cause is cause
    assert 500 <= verdict.cycle <= 700


def test_lost_cycles_trip_only_in_a_row(limits: SafetySettings) -> None:
    inputs = healthy()
    good = inputs.good.copy()
    good[10:29] = False
    good[100:200:2] = False
    assert not step(SafetyState.fresh(), replace(inputs, good=good), True, limits)[1].tripped
    good[1000:1020] = False
    _, verdict = step(SafetyState.fresh(), replace(inputs, good=good), True, limits)
    assert (verdict.cause, verdict.cycle) == (Cause.LOST_CYCLES, 1019)


@hypothesis_settings(max_examples=25, deadline=None)
@given(cuts=st.lists(st.integers(1, N - 1), max_size=5), case=st.sampled_from(FILTERED))
def test_blocks_do_not_change_the_verdict(
    limits: SafetySettings, cuts: list[int], case: tuple[str, object, Cause, float]
) -> None:
    inputs = with_change(case[0], 700, case[1])
    _, whole = step(SafetyState.fresh(), inputs, True, limits)
    edges = sorted({0, N, *cuts})
    state = SafetyState.fresh()
    for start, stop in pairwise(edges):
        state, verdict = step(state, inputs.part(start, stop), True, limits)
        if verdict.tripped:
            assert (start + verdict.cycle, verdict.cause) == (whole.cycle, whole.cause)
            return
    pytest.fail("the blocks did not trip where the whole did")


def test_step_is_pure_and_latches(limits: SafetySettings) -> None:
    state = SafetyState.fresh()
    bad = with_change("temperature", 100, 99.0)
    first = step(state, bad, True, limits)
    assert not state.memory.any()
    assert step(state, bad, True, limits)[1] == first[1]
    again, verdict = step(first[0], healthy(), True, limits)
    assert again.tripped
    assert not verdict.tripped


def test_status_words_are_not_judged_before_operation(limits: SafetySettings) -> None:
    inputs = with_change("input_status", 0, 0x0250)
    assert not step(SafetyState.fresh(), inputs, False, limits)[1].tripped


def test_a_failed_device_is_told_from_a_broken_limit() -> None:
    assert is_device_fault(Cause.LOAD_DRIVE_FAULT)
    assert is_device_fault(Cause.LOST_CYCLES)
    assert not is_device_fault(Cause.MOTOR_SPEED)
    assert not is_device_fault(Cause.OPERATOR)


def test_every_cause_has_a_sentence_and_a_rung() -> None:
    for cause in Cause:
        if cause is not Cause.NONE:
            assert first_rung(cause) in (
                Rung.CONTROLLED_RAMP,
                Rung.QUICK_STOP,
                Rung.DISABLE_VOLTAGE,
                Rung.STOP_SENDING,
            )


DEADLINES = Deadlines(1.0, 0.5, 2.0)
observations = st.builds(Observation, st.booleans(), st.booleans(), st.booleans(), st.booleans())


@given(st.sampled_from([Rung.CONTROLLED_RAMP, Rung.QUICK_STOP, Rung.DISABLE_VOLTAGE]), st.lists(observations))
def test_the_ladder_only_climbs(start: Rung, seen: list[Observation]) -> None:
    state = LadderState(start)
    for observation in seen:
        after = climb(state, observation, 0.1, DEADLINES)
        assert after.rung >= state.rung
        state = after


@given(st.sampled_from([Rung.CONTROLLED_RAMP, Rung.QUICK_STOP, Rung.DISABLE_VOLTAGE]))
def test_a_bench_that_never_answers_ends_in_silence_in_time(start: Rung) -> None:
    state, time = LadderState(start), 0.0
    stuck = Observation(at_rest=False, load_off=False, drives_off=False)
    while state.rung is not Rung.FINISHED:
        state = climb(state, stuck, 0.01, DEADLINES)
        time += 0.01
        assert time < 1.0 + 0.5 + 2.0 + 0.1


def test_a_good_stop_ends_without_voltage() -> None:
    state = LadderState(Rung.CONTROLLED_RAMP)
    state = climb(state, Observation(False, True, False), 0.1, DEADLINES)
    assert state.rung is Rung.CONTROLLED_RAMP
    state = climb(state, Observation(True, True, False), 0.1, DEADLINES)
    assert state.rung is Rung.DISABLE_VOLTAGE
    state = climb(state, Observation(True, True, True), 0.1, DEADLINES)
    assert state.rung is Rung.FINISHED


def test_a_dead_bus_leaves_only_silence() -> None:
    state = climb(LadderState(Rung.CONTROLLED_RAMP), Observation(False, False, False, bus_alive=False), 0.1, DEADLINES)
    assert state.rung is Rung.STOP_SENDING


@pytest.mark.parametrize(
    ("cause", "value", "limit", "text"),
    [
        (Cause.LOAD_TORQUE, 356.2, 355.0, "load torque 356.2 N·m is beyond limits.load_torque = 355 N·m by 1.2 N·m"),
        (
            Cause.LOAD_TORQUE,
            -355.04,
            355.0,
            "load torque -355.04 N·m is beyond limits.load_torque = 355 N·m by 0.04 N·m",
        ),
        (
            Cause.LOAD_TORQUE,
            355.0001,
            355.0,
            "load torque 355.0001 N·m is beyond limits.load_torque = 355 N·m by 0.0001",
        ),
        (Cause.TEMPERATURE_LOW, -3.0, 5.0, "temperature -3 °C is beyond limits.temperature_minimum = 5 °C by 8 °C"),
        (Cause.LOST_CYCLES, 20.0, 20.0, "number of lost cycles in a row 20 has reached limits.lost_cycles = 20"),
        (Cause.MOTOR_SPEED, 1234.5, 105.0, "is beyond limits.motor_speed = 105 rad/s by 1130 rad/s"),
    ],
)
def test_a_sentence_tells_how_far_with_numbers_that_differ(cause: Cause, value: float, limit: float, text: str) -> None:
    assert text in describe(cause, value, limit)


@given(st.floats(1e-3, 1e4), st.floats(1e-9, 10.0), st.sampled_from([-1.0, 1.0]))
def test_the_two_numbers_of_a_sentence_always_differ(limit: float, beyond: float, sign: float) -> None:
    value = sign * (limit + beyond)
    if value != sign * limit:
        seen, _, rest = describe(Cause.LOAD_TORQUE, value, limit).removeprefix("load torque ").partition(" ")
        allowed = rest.partition("= ")[2].partition(" ")[0]
        assert abs(float(seen)) > float(allowed)
