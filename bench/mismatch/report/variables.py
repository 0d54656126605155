"""Quantities a finding depends on: to which range of its location each belongs, and how it is drawn."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.linear import in_metres
from bench.simulation.quantities import ABOUT_ZERO, QUANTITIES, REMEMBERED, SHORTEST_TRAVEL, quantity, state_of

VELOCITY, TORQUE, TEMPERATURE, TIME, ANGLE = "velocity", "load_torque", "temperature", "time", "angle"
RANGES = (VELOCITY, TORQUE, TEMPERATURE)
"""ranges of a location"""
SECONDS_AN_HOUR = 3600.0


@dataclass(frozen=True, slots=True)
class Variable:
    """A quantity: the range of the location it belongs to (empty: none), the axis of a plot and its values (n,),
    whether the axis is logarithmic; and in words where the finding acts, where no range says so.
    """

    range: str
    axis: str
    values: Callable[[Frame], FloatArray]
    logarithmic: bool = False
    words: str = ""


def _degrees(values: FloatArray) -> FloatArray:
    return np.asarray(np.degrees(values))


_SPEED = Variable(VELOCITY, "speed / (deg/s)", lambda f: _degrees(np.abs(f.velocity)))
_TORQUE = Variable(TORQUE, "load torque / N·m", lambda f: f.torque_level)
_START = Variable("", "time since the recording began / s", lambda f: f.elapsed, words="in the time after a start")


def _warming(name: str, what: str) -> Variable:
    """How much warmer the lubricant is than it was, while ``what`` warms up."""
    label = f"{QUANTITIES[name].label} / {QUANTITIES[name].unit}"
    return Variable("", label, lambda f: quantity(name, f), words=f"while the {what} warms up or cools down")


VARIABLES: dict[str, Variable] = {
    "speed": _SPEED,
    "velocity": Variable(VELOCITY, "velocity / (deg/s)", lambda f: _degrees(f.velocity)),
    "order_frequency": _SPEED,
    "direction": Variable("", "velocity / (deg/s)", lambda f: _degrees(f.velocity)),
    "torque": _TORQUE,
    "torque_path": _TORQUE,
    "load": Variable(TORQUE, "size of the load torque / N·m", lambda f: np.abs(f.torque_level)),
    "motor_torque": Variable(TORQUE, "motor torque / N·m", lambda f: f.motor_torque),
    "load_motor_torque": Variable(TORQUE, "load motor's torque / N·m", lambda f: f.load_motor_level),
    "torque_rate": Variable(
        "", "change of the load torque / (N·m/s)", lambda f: f.torque_rate, words="where the load changes"
    ),
    "temperature": Variable(TEMPERATURE, "lubricant temperature / °C", lambda f: f.temperature),
    "quick_warming": _warming("quick_warming", "gearbox"),
    "warming": _warming("warming", "gearbox"),
    "slow_warming": _warming("slow_warming", "bench"),
    "time": Variable(TIME, "time since the campaign began / h", lambda f: f.time / SECONDS_AN_HOUR),
    "travel": Variable(TIME, "distance run / revolutions", lambda f: f.travel / (2.0 * np.pi)),
    "angle": Variable(ANGLE, "output angle / deg", lambda f: _degrees(np.mod(f.theta, 2.0 * np.pi))),
    ABOUT_ZERO: Variable(ANGLE, "output angle / deg", lambda f: _degrees(quantity(ABOUT_ZERO, f))),
    "since_reversal": Variable(
        "",
        "distance since start or reversal / deg",
        lambda f: _degrees(f.reversal_travel + SHORTEST_TRAVEL),
        True,
        "after a start or a reversal",
    ),
    "elapsed": _START,
    "transient": _START,
    "speeding_up": Variable(
        "", "acceleration of the motor / (rad/s²)", lambda f: f.acceleration, words="where the speed changes"
    ),
    "acceleration": Variable(
        "", "acceleration of the motor / (rad/s²)", lambda f: f.acceleration, words="where the speed changes"
    ),
}


_MM_S = 1000.0
_LINEAR_SPEED = Variable(VELOCITY, "speed / (mm/s)", lambda f: _MM_S * np.abs(f.velocity))
LINEAR: dict[str, Variable] = {
    "speed": _LINEAR_SPEED,
    "velocity": Variable(VELOCITY, "velocity / (mm/s)", lambda f: _MM_S * f.velocity),
    "order_frequency": _LINEAR_SPEED,
    "direction": Variable("", "velocity / (mm/s)", lambda f: _MM_S * f.velocity),
    "travel": Variable(TIME, "distance run / m", lambda f: f.travel),
    "angle": Variable(ANGLE, "position / m", lambda f: f.theta),
    ABOUT_ZERO: Variable(ANGLE, "position / m", lambda f: f.theta),
    "since_reversal": Variable(
        "",
        "distance since start or reversal / m",
        lambda f: f.reversal_travel + SHORTEST_TRAVEL,
        True,
        "after a start or a reversal",
    ),
}
"""quantities of a linear axis that are drawn in other units"""


def variable(name: str, linear: bool = False) -> Variable:
    """A quantity by its name, ``linear`` of an axis in metres; one of no special kind belongs to no range.

    Raises ConfigurationError for no quantity.
    """
    known = LINEAR.get(name) if linear else None
    if known is None and name in VARIABLES:
        known = VARIABLES[name]
    if known is None:
        label = f"{QUANTITIES[name].label} / {QUANTITIES[name].unit}" if name in QUANTITIES else name
        state = state_of(name)
        before = "temperature" if state is not None and state[0] == "risen" else "motion and load"
        words = f"depending on the {before} before" if state is not None and state[0] in REMEMBERED else ""
        known = Variable("", label, lambda f: quantity(name, f), words=words)
    return replace(known, axis=in_metres(known.axis)) if linear else known


def levels(frame: Frame, name: str) -> FloatArray:
    """Values (n,) of a range of the location: |velocity| in rad/s, load torque in N·m, temperature in °C, time in s.

    A steady stretch of motion has one speed: what an encoder's counts make of it is no location.
    """
    if name == VELOCITY:
        return _steady_level(frame, np.abs(frame.velocity))
    if name == TORQUE:
        return frame.torque_level
    return frame.temperature if name == TEMPERATURE else frame.time


def _steady_level(frame: Frame, values: FloatArray) -> FloatArray:
    steady = frame.steady > 0.5
    parted = (np.diff(frame.recording) != 0) | (np.diff(steady.astype(int)) != 0) | (np.diff(frame.direction) != 0)
    run = np.concatenate(([0], np.cumsum(parted)))
    weight = np.maximum(frame.count, 1e-9)
    mean = np.bincount(run, values * weight) / np.bincount(run, weight)
    return np.asarray(np.where(steady, mean[run], values))
