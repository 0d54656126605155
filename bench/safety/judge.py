"""The safety step: pure, over a block of cycles, every cycle looked at.

``step(state, inputs, limits)`` returns the state after the last cycle that was still good and the verdict. A bench that
takes blocks goes back to the start of the block on a trip and replays up to that very cycle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.configuration.operation import Limits
from bench.safety._observe import gains
from bench.safety._scan import gather, scan
from bench.safety._slots import LIVE, STATE_SIZE
from bench.safety.causes import Cause, describe
from bench.safety.rules import bounds, compile_rules

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.integer[Any]]
_LOAD_SPEED_MARGIN = 1.2
"""Over the motor's limit at the load side, where no limit of its own is given."""


@dataclass(frozen=True, slots=True)
class Inputs:
    """What the safety step sees of a block of n cycles; every array has the shape (n,), SI units, bench signs.

    ``operating`` is False in cycles in which the drives are not yet, or no longer, meant to be in operation: then set
    values and status words are not judged.
    """

    motor_counts: IntArray
    load_counts: IntArray
    torque_counts: IntArray
    motor_angle: FloatArray
    load_angle: FloatArray
    motor_velocity: FloatArray
    load_velocity: FloatArray
    motor_torque: FloatArray
    load_torque: FloatArray
    load_motor_torque: FloatArray
    temperature: FloatArray
    """NaN where the thermometer has no valid reading."""
    temperature_age_s: FloatArray
    velocity_setpoint: FloatArray
    """Motor shaft, rad/s."""
    torque_setpoint: FloatArray
    """Load motor, N·m."""
    input_status: IntArray
    load_status: IntArray
    torque_bad: NDArray[np.bool_]
    """Where the torque terminal does not vouch for its reading, or it is saturated."""
    emergency_stop: NDArray[np.bool_]
    """Whether the emergency stop circuit is open; False where the bench has no such input."""
    safe_torque_off: NDArray[np.bool_]
    """The same of the safe torque off circuit."""
    good: NDArray[np.bool_]
    """Whether the cycle's working counter was right."""

    @property
    def size(self) -> int:
        """Number of cycles."""
        return int(self.good.size)

    def part(self, start: int, stop: int) -> Inputs:
        """Return the cycles from ``start`` to ``stop``."""
        return Inputs(**{f.name: getattr(self, f.name)[start:stop] for f in fields(self)})


_FIELDS = tuple(field.name for field in fields(Inputs))
_RULES = compile_rules()
_PIECE = 512
"""Cycles looked at in one go: few enough for their signals to stay in the processor's cache."""


@dataclass(frozen=True, slots=True)
class SafetyState:
    """Memory of the safety step between blocks: filters, counters, references. Values are not for outside use."""

    memory: FloatArray
    tripped: bool = False

    @staticmethod
    def fresh() -> SafetyState:
        """Return the state before the first cycle."""
        return SafetyState(np.zeros(STATE_SIZE))


@dataclass(frozen=True, slots=True)
class Verdict:
    """What a block showed. ``cycle`` is the index of the first bad cycle, or −1."""

    cycle: int = -1
    cause: Cause = Cause.NONE
    value: float = 0.0
    limit: float = 0.0

    @property
    def tripped(self) -> bool:
        """Whether any cycle broke a limit."""
        return self.cause is not Cause.NONE

    @property
    def text(self) -> str:
        """The sentence for the operator."""
        return describe(self.cause, self.value, self.limit) if self.tripped else "within all limits"


@dataclass(frozen=True, slots=True)
class SafetySettings:
    """Limits as the compiled check takes them, made once a campaign."""

    ratio: float
    cycle_time_s: float
    standstill: float
    limits: Mapping[Cause, float | None]
    """By cause, SI; None or absent where nothing is watched, or nothing is asked for."""
    bounds: FloatArray
    """Of each rule (:func:`bench.safety.rules.bounds`)."""
    follow: FloatArray
    """Gains of the filters."""


def settings(limits: Limits, ratio: float, cycle_time_s: float, standstill: float) -> SafetySettings:
    """Collect limits (SI) for :func:`step`; ``standstill`` is a motor speed in rad/s."""
    chosen: dict[Cause, float | None] = {
        Cause.MOTOR_SPEED: limits.motor_speed,
        Cause.MOTOR_TORQUE: limits.motor_torque,
        Cause.LOAD_TORQUE: limits.load_torque,
        Cause.LOAD_MOTOR_TORQUE: limits.load_motor_torque,
        Cause.TEMPERATURE_HIGH: limits.temperature,
        Cause.TEMPERATURE_LOW: limits.temperature_minimum,
        Cause.TEMPERATURE_RATE: limits.temperature_rate,
        Cause.LOAD_POSITION: limits.load_position,
        Cause.VELOCITY_ERROR: limits.velocity_error,
        Cause.TORQUE_DISAGREEMENT: limits.torque_disagreement,
        Cause.ENCODER_DISAGREEMENT: limits.encoder_disagreement,
        Cause.TEMPERATURE_AGE: limits.slow_reading_age,
        Cause.LOST_CYCLES: float(limits.lost_cycles),
        Cause.LOST_SHARE: limits.lost_share,
        Cause.LOAD_SPEED: limits.load_speed or _LOAD_SPEED_MARGIN * limits.motor_speed / ratio,
        Cause.MOTOR_ACCELERATION: limits.motor_acceleration,
        Cause.LOAD_TORQUE_RATE: limits.load_torque_rate,
        Cause.FOLLOWING_ERROR: limits.following_error,
        Cause.TORQUE_ERROR: limits.torque_error,
        Cause.TORQUE_DRIFT: limits.torque_drift,
        Cause.FRICTION: limits.friction_torque,
        **dict.fromkeys(LIVE, limits.frozen_signal),
        Cause.TEMPERATURE_FROZEN: limits.frozen_temperature,
    }
    return SafetySettings(ratio, cycle_time_s, standstill, chosen, bounds(chosen), gains(cycle_time_s))


def step(state: SafetyState, inputs: Inputs, operating: bool, limits: SafetySettings) -> tuple[SafetyState, Verdict]:
    """Look at every cycle of a block.

    Returns the state after the last good cycle and the verdict on the block. Neither argument is changed. A state that
    has tripped stays tripped: only a new state, made by an operator's act, clears it.
    """
    if state.tripped or inputs.size == 0:
        return state, Verdict()
    memory, arrays = state.memory.copy(), tuple(getattr(inputs, name) for name in _FIELDS)
    for start in range(0, inputs.size, _PIECE):
        signals = np.empty((len(_FIELDS), min(_PIECE, inputs.size - start)))
        gather(arrays, start, signals)
        cycle, cause, value = scan(
            memory,
            signals,
            operating,
            limits.ratio,
            limits.cycle_time_s,
            limits.standstill,
            limits.follow,
            _RULES,
            limits.bounds,
        )
        if cause:
            verdict = Verdict(start + cycle, Cause(cause), value, limits.limits.get(Cause(cause)) or 0.0)
            return SafetyState(memory, tripped=True), verdict
    return SafetyState(memory), Verdict()
