"""The quantities of a sample, and the frame made of them: as formulas, and as numbers by the same rules.

What a program cannot measure (direction, distance since a reversal) is made of what it can, from sample to sample.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from bench.exchange import formula
from bench.exchange.formula import const
from bench.simulation.frame import ARRAYS, Frame
from bench.simulation.quantities import AUXILIARY

INPUTS: dict[str, tuple[str, str]] = {
    "motor_angle": ("rad", "angle of the motor's shaft"),
    "motor_velocity": ("rad/s", "speed of the motor's shaft"),
    "motor_acceleration": ("rad/s^2", "acceleration of the motor's shaft"),
    "motor_torque": ("N*m", "torque of the motor at its shaft"),
    "load_angle": ("rad", "angle of the output"),
    "load_velocity": ("rad/s", "speed of the output"),
    "load_acceleration": ("rad/s^2", "acceleration of the output"),
    "load_torque": ("N*m", "torque of the gearbox on the load side"),
    "load_torque_rate": ("N*m/s", "its rate of change"),
    "load_motor_torque": ("N*m", "torque of the load motor"),
    "temperature": ("degC", "temperature of the lubricant"),
}
"""quantities that a sample has: unit and meaning"""
STANDSTILL = "standstill"
"""parameter: motor speed below which it stands, rad/s"""


def loss(frame: Frame, torque: Any, less: Any = 0.0) -> Any:
    """Power that the gearbox loses, as a formula, at a load torque, ``less`` some W of what goes in."""
    return np.abs(frame.motor_torque * frame.omega - torque * formula.reference("input", "load_velocity") - less)


def formula_frame(ratio: float) -> Frame:
    """The quantities of a frame as formulas of those that a sample has."""
    has = {name: formula.reference("input", name) for name in (*INPUTS, "time")}
    omega = has["motor_velocity"]
    standstill = formula.reference("parameter", STANDSTILL)
    direction = formula.where(np.abs(omega) > standstill, np.sign(omega), 0.0)
    theta = has["motor_angle"] / ratio
    elapsed = has["time"]
    last = direction.remembered("held")
    path = theta.remembered("distance")
    arrays: dict[str, Any] = {
        "time": has["time"],
        "elapsed": elapsed,
        "theta": theta,
        "q": has["load_angle"],
        "velocity": omega / ratio,
        "acceleration": has["motor_acceleration"],
        "load_acceleration": has["load_acceleration"],
        "direction": direction,
        "last_direction": last,
        "torque": has["load_torque"],
        "torque_level": has["load_torque"],
        "torque_rate": has["load_torque_rate"],
        "temperature": has["temperature"],
        "motor_torque": has["motor_torque"],
        "load_motor_torque": has["load_motor_torque"],
        "load_motor_level": has["load_motor_torque"],
        "kept": const(0.0),
        "followed": const(1.0),
        "lead": const(0.0),
        "travel": path,
        # since the motion last began
        "reversal_travel": path - formula.node("begun", (path, direction)),
        "reversal_time": elapsed - formula.node("begun", (elapsed, direction)),
        "reversed_before": last.remembered("reversals"),
        "steady": const(0.0),
    }
    missing = {name: np.zeros(1) for name in ARRAYS if name not in arrays}
    plain = Frame(ratio=ratio, **{**missing, **arrays, "recording": np.zeros(1, dtype=np.int64)})
    return replace(plain, power=loss(plain, plain.torque))


def frame_of(inputs: dict[str, Any], ratio: float, standstill: float) -> Frame:
    """The frame of samples (n,) by the same rules, for :class:`bench.mismatch.prediction.Predictor`."""
    time = inputs["time"]
    zeros = np.zeros(time.size)
    has = {name: inputs.get(name, zeros) for name in INPUTS}
    omega = has["motor_velocity"]
    direction = np.where(np.abs(omega) > standstill, np.sign(omega), 0.0)
    moved = np.maximum.accumulate(np.where(direction != 0, np.arange(time.size), -1))
    last = np.where(moved >= 0, direction[moved], 0.0)
    theta = has["motor_angle"] / ratio
    path = np.cumsum(np.abs(np.diff(theta, prepend=theta[0])))
    begins = (direction != 0) & (direction != np.concatenate(([0.0], direction[:-1])))
    start = np.maximum.accumulate(np.where(begins, np.arange(time.size), 0))
    reversals = np.concatenate(([False], (last[1:] != last[:-1]) & (last[:-1] != 0)))
    torque = has["load_torque"]
    return Frame(
        ratio=ratio,
        recording=np.zeros(time.size, dtype=np.int64),
        count=np.ones(time.size),
        time=time,
        elapsed=time,
        theta=theta,
        q=has["load_angle"],
        velocity=omega / ratio,
        acceleration=has["motor_acceleration"],
        load_acceleration=has["load_acceleration"],
        direction=direction,
        last_direction=last,
        torque=torque,
        torque_level=torque,
        kept=zeros,
        followed=np.ones(time.size),
        torque_rate=has["load_torque_rate"],
        temperature=has["temperature"],
        motor_torque=has["motor_torque"],
        load_motor_torque=has["load_motor_torque"],
        load_motor_level=has["load_motor_torque"],
        power=np.abs(has["motor_torque"] * omega - torque * has["load_velocity"]),
        lead=zeros,
        kinetic=omega * has["motor_acceleration"],
        travel=path,
        reversal_travel=path - path[start],
        reversal_time=time - time[start],
        reversed_before=(np.cumsum(reversals) > 0).astype(np.float64),
        steady=zeros,
        step=np.diff(time, prepend=time[0]),
        aux={name.removeprefix(AUXILIARY): values for name, values in inputs.items() if name.startswith(AUXILIARY)},
    )
