"""Every rule of the table, at its limit from both sides."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from bench.configuration import load_bench
from bench.safety import Cause, Inputs, SafetySettings, SafetyState, settings, step
from bench.safety._observe import LOW_PASSES, Signal
from bench.safety._scan import first_broken
from bench.safety._slots import STATE_SIZE, Slot
from bench.safety.causes import describe
from bench.safety.rules import RULES, Condition, Rule, When, bounds, compile_rules
from tests.bench.safety.test_judge import DT, healthy, with_limits

ENABLED = 0x1237
LIMIT = 10.0
TABLE = compile_rules()
IDS = [rule.cause.name for rule in RULES]


def judged(rule: Rule, value: float, lost: bool = False, operating: bool = True, limit: float = LIMIT) -> Cause:
    """Which cause a memory gives in which only this rule's slot has a value, and only its cause a limit."""
    memory = np.zeros(STATE_SIZE)
    memory[rule.slot] = value
    broken = first_broken(memory, TABLE, bounds({rule.cause: limit}), lost, operating)
    return Cause.NONE if broken < 0 else RULES[broken].cause


def sides(rule: Rule) -> tuple[list[float], list[float]]:
    """Values that are just within, and just beyond."""
    above, below = math.nextafter(LIMIT, math.inf), math.nextafter(LIMIT, -math.inf)
    match rule.condition:
        case Condition.MAGNITUDE_ABOVE:
            return [LIMIT, -LIMIT, 0.0], [above, -above, math.inf, -math.inf]
        case Condition.ABOVE:
            return [LIMIT, -1e9], [above, math.inf]
        case Condition.BELOW:
            return [LIMIT, 1e9], [below, -math.inf]
        case Condition.AT_LEAST:
            return [below, 0.0], [LIMIT, above]
        case Condition.IS_SET:
            return [0.0], [1.0, -1.0]


@pytest.mark.parametrize("rule", RULES, ids=IDS)
def test_a_rule_holds_to_its_limit_and_not_beyond(rule: Rule) -> None:
    within, beyond = sides(rule)
    for value in within:
        assert judged(rule, value) is Cause.NONE, value
    for value in beyond:
        assert judged(rule, value) is rule.cause, value


@pytest.mark.parametrize("rule", RULES, ids=IDS)
def test_a_rule_applies_when_it_says(rule: Rule) -> None:
    bad = sides(rule)[1][0]
    assert (judged(rule, bad, lost=True) is rule.cause) == (rule.when is When.EVERY_CYCLE)
    assert (judged(rule, bad, operating=False) is rule.cause) == (rule.when is not When.OPERATING)


def test_every_rule_has_a_sentence_and_every_cause_of_the_signals_a_rule() -> None:
    assert len({rule.cause for rule in RULES}) == len(RULES)
    not_of_signals = {cause for cause in Cause if cause >= Cause.RECORDER} | {Cause.NONE}
    assert {rule.cause for rule in RULES} == set(Cause) - not_of_signals
    for rule in RULES:
        assert len(describe(rule.cause, 20.0, 10.0)) > 20


def test_what_is_people_s_comes_before_every_measurement() -> None:
    order = [rule.cause for rule in RULES]
    assert order[2:4] == [Cause.EMERGENCY_STOP, Cause.SAFE_TORQUE_OFF]
    assert all(rule.when is When.EVERY_CYCLE for rule in RULES[:2])


def test_signals_and_low_passes_are_where_the_loop_takes_them() -> None:
    assert [field.name for field in fields(Inputs)] == [
        *(signal.name.lower() for signal in Signal if signal <= Signal.TEMPERATURE),
        "temperature_age_s",
        *(signal.name.lower() for signal in Signal if signal > Signal.TEMPERATURE_AGE),
    ]
    assert [slot for slot, _ in LOW_PASSES] == [Slot(Slot.SPEED + k) for k in range(len(LOW_PASSES))]


STEADY: list[tuple[Cause, str, float]] = [
    (Cause.MOTOR_SPEED, "motor_velocity", 1.0),
    (Cause.LOAD_SPEED, "load_velocity", 1.0),
    (Cause.MOTOR_TORQUE, "motor_torque", 1.0),
    (Cause.LOAD_TORQUE, "load_torque", 1.0),
    (Cause.LOAD_MOTOR_TORQUE, "load_motor_torque", 1.0),
    (Cause.LOAD_POSITION, "load_angle", 1.0),
    (Cause.TEMPERATURE_HIGH, "temperature", 1.0),
    (Cause.TEMPERATURE_LOW, "temperature", -1.0),
    (Cause.TEMPERATURE_AGE, "temperature_age_s", 1.0),
    (Cause.TORQUE_DISAGREEMENT, "load_torque", 1.0),
    (Cause.VELOCITY_ERROR, "motor_velocity", 1.0),
    (Cause.FRICTION, "motor_torque", 1.0),
]
"""Signals of which the first cycle counts as it is, and to which side they break their limit."""


@pytest.mark.parametrize(("cause", "name", "sign"), STEADY, ids=[case[0].name for case in STEADY])
@pytest.mark.parametrize("limit", [0.375, 26.0])
def test_a_signal_trips_just_beyond_its_limit(cause: Cause, name: str, sign: float, limit: float) -> None:
    only = with_limits(wide(), {**dict.fromkeys(Cause), cause: limit})
    quiet = still(1)
    for step_beyond, expected in ((0.0, Cause.NONE), (sign, cause)):
        value = limit if not step_beyond else math.nextafter(limit, step_beyond * math.inf)
        inputs = replace(quiet, **{name: np.full(1, value)})
        assert step(SafetyState.fresh(), inputs, True, only)[1].cause is expected


def wide() -> SafetySettings:
    return settings(load_bench("rh380n").configuration.limits, 185.0, DT, 0.5)


def still(n: int) -> Inputs:
    """Nothing moves, nothing is loaded, every word is right."""
    zeros = {field.name: np.zeros(n) for field in fields(Inputs)}
    words = np.full(n, ENABLED)
    return replace(Inputs(**zeros), input_status=words, load_status=words, good=np.ones(n))


@pytest.mark.parametrize("word", range(1 << 7))
def test_a_drive_is_in_operation_by_the_bits_that_say_so(word: int) -> None:
    # of the status word bits 0 … 3, 5 and 6 count: x01x 0111 is operation enabled, and bit 4 says nothing of it
    enabled = word & 0x6F == 0x27
    inputs = replace(still(1), input_status=np.full(1, word | 0x1200))
    verdict = step(SafetyState.fresh(), inputs, True, with_limits(wide(), dict.fromkeys(Cause)))[1]
    assert verdict.cause is (Cause.NONE if enabled else Cause.INPUT_DRIVE_FAULT)
    assert enabled or verdict.value == word | 0x1200


@pytest.mark.parametrize(("every", "trips"), [(20, True), (3, True), (2, True), (6, False), (10**6, False)])
def test_a_share_of_lost_cycles_counts_as_well_as_a_row(every: int, trips: bool) -> None:
    n = 16_000
    # all but one of ``every`` cycles are lost, or with 6 one of them: never 20 in a row
    number = np.arange(n)
    good = number % every == 0 if trips else number % every != 0
    _, verdict = step(SafetyState.fresh(), replace(healthy(n), good=good), True, wide())
    assert verdict.cause is (Cause.LOST_SHARE if trips else Cause.NONE)
    if trips:
        assert verdict.cycle * DT < 1.0
        assert "share of lost cycles" in verdict.text
