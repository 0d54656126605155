"""What stops a bench: the table of rules, in the order in which they are looked at.

A rule is a cause, the slot of the memory it looks at (most are filtered signals, :mod:`bench.safety._observe`), the
condition that breaks it, and when it applies. :func:`compiled` and :func:`bounds` turn the table into what the loop
reads, once.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from bench.safety._slots import FROZEN, LIVE, Slot
from bench.safety.causes import Cause


class Condition(IntEnum):
    """What breaks a rule; the limit is that of its cause."""

    MAGNITUDE_ABOVE = 0
    ABOVE = 1
    BELOW = 2
    AT_LEAST = 3
    IS_SET = 4
    """Not 0; there is no limit."""


class When(IntEnum):
    """In which cycles a rule applies."""

    EVERY_CYCLE = 0
    """Also in one without a right working counter."""
    GOOD_CYCLE = 1
    OPERATING = 2
    """In a good cycle, while the drives are meant to be in operation."""


@dataclass(frozen=True, slots=True)
class Rule:
    """One reason to stop; ``reported`` is the slot whose value stands in the sentence, by default ``slot`` itself."""

    cause: Cause
    slot: Slot
    condition: Condition = Condition.MAGNITUDE_ABOVE
    when: When = When.GOOD_CYCLE
    reported: Slot | None = None


_OPERATING = When.OPERATING

RULES: tuple[Rule, ...] = (
    Rule(Cause.LOST_CYCLES, Slot.LOST_IN_A_ROW, Condition.AT_LEAST, When.EVERY_CYCLE),
    Rule(Cause.LOST_SHARE, Slot.LOST_SHARE, Condition.ABOVE, When.EVERY_CYCLE),
    # people first: what the safety circuit says is looked at before any measurement
    Rule(Cause.EMERGENCY_STOP, Slot.EMERGENCY_STOP, Condition.IS_SET),
    Rule(Cause.SAFE_TORQUE_OFF, Slot.SAFE_TORQUE_OFF, Condition.IS_SET),
    Rule(Cause.INPUT_DRIVE_FAULT, Slot.INPUT_IS_OUT, Condition.IS_SET, _OPERATING, Slot.INPUT_STATUS),
    Rule(Cause.LOAD_DRIVE_FAULT, Slot.LOAD_IS_OUT, Condition.IS_SET, _OPERATING, Slot.LOAD_STATUS),
    Rule(Cause.TORQUE_SENSOR_RANGE, Slot.TORQUE_BAD, Condition.IS_SET, reported=Slot.TORQUE_READING),
    Rule(Cause.TEMPERATURE_SENSOR, Slot.TEMPERATURE_INVALID, Condition.IS_SET, reported=Slot.TEMPERATURE),
    Rule(Cause.MOTOR_SPEED, Slot.SPEED),
    Rule(Cause.LOAD_SPEED, Slot.LOAD_SPEED),
    Rule(Cause.MOTOR_TORQUE, Slot.MOTOR_TORQUE),
    Rule(Cause.LOAD_TORQUE, Slot.LOAD_TORQUE),
    Rule(Cause.LOAD_MOTOR_TORQUE, Slot.LOAD_MOTOR_TORQUE),
    Rule(Cause.TEMPERATURE_HIGH, Slot.TEMPERATURE, Condition.ABOVE),
    Rule(Cause.TEMPERATURE_LOW, Slot.TEMPERATURE, Condition.BELOW),
    Rule(Cause.TEMPERATURE_RATE, Slot.TEMPERATURE_JUMP),
    Rule(Cause.LOAD_POSITION, Slot.LOAD_ANGLE),
    Rule(Cause.VELOCITY_ERROR, Slot.VELOCITY_ERROR, when=_OPERATING),
    Rule(Cause.FOLLOWING_ERROR, Slot.FOLLOWING, when=_OPERATING),
    Rule(Cause.MOTOR_ACCELERATION, Slot.ACCELERATION, when=_OPERATING),
    Rule(Cause.TORQUE_ERROR, Slot.TORQUE_ERROR, when=_OPERATING),
    Rule(Cause.LOAD_TORQUE_RATE, Slot.TORQUE_RATE),
    Rule(Cause.TORQUE_DISAGREEMENT, Slot.DISAGREEMENT),
    Rule(Cause.ENCODER_DISAGREEMENT, Slot.ENCODER_DIFFERENCE),
    Rule(Cause.FRICTION, Slot.FRICTION),
    Rule(Cause.TORQUE_DRIFT, Slot.TORQUE_DRIFT),
    *(Rule(cause, Slot(FROZEN + k), Condition.ABOVE) for k, cause in enumerate(LIVE)),
    Rule(Cause.TEMPERATURE_AGE, Slot.TEMPERATURE_AGE, Condition.ABOVE),
)

CAUSE, SLOT, WHEN, REPORTED = range(4)
"""Columns of the compiled table."""


def compile_rules(rules: tuple[Rule, ...] = RULES) -> NDArray[np.int64]:
    """Return the table as the loop reads it, one row a rule."""
    slots = [rule.slot if rule.reported is None else rule.reported for rule in rules]
    return np.array(
        [[rule.cause, rule.slot, rule.when, slot] for rule, slot in zip(rules, slots, strict=True)], np.int64
    )


def bounds(limits: Mapping[Cause, float | None], rules: tuple[Rule, ...] = RULES) -> NDArray[np.float64]:
    """Return between which two values, both allowed, each rule's slot has to be, (2, rules).

    ``limits`` are by cause, SI; a rule whose cause has none (absent or None) is never broken, but for one that asks for
    no limit.
    """
    return np.array([_bounds(rule.condition, limits.get(rule.cause)) for rule in rules]).T.copy()


def _bounds(condition: Condition, limit: float | None) -> tuple[float, float]:
    if condition is Condition.IS_SET:
        return 0.0, 0.0
    if limit is None:
        return -math.inf, math.inf
    return {
        Condition.MAGNITUDE_ABOVE: (-limit, limit),
        Condition.ABOVE: (-math.inf, limit),
        Condition.BELOW: (limit, math.inf),
        Condition.AT_LEAST: (-math.inf, math.nextafter(limit, -math.inf)),
    }[condition]
