"""A frame made by hand: three recordings of a bench that turns both ways, warms up and changes its load."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.simulation.frame import ARRAYS, FloatArray, Frame, concatenate

STEP_S = 0.05
ROWS = 400


def frame(ratio: float = 185.0) -> Frame:
    """Three recordings of ``ROWS`` rows: forward cold, backward warm, a reversal in between; torque swings in all."""
    parts = [_recording(0, 0.17, 25.0), _recording(1, -0.09, 33.0), _recording(2, 0.13, 41.0, reverses=True)]
    joined = {name: np.concatenate([part[name] for part in parts]) for name in ARRAYS}
    return Frame(ratio=ratio, **joined)


def _recording(number: int, speed: float, temperature: float, reverses: bool = False) -> dict[str, FloatArray]:
    n = ROWS
    elapsed = STEP_S * np.arange(n)
    direction = np.sign(speed) * np.where(reverses & (elapsed > elapsed[-1] / 2), -1.0, 1.0)
    velocity = abs(speed) * direction
    theta = np.cumsum(velocity) * STEP_S
    torque = 300.0 * np.sin(0.4 * elapsed + number)
    since = np.where(reverses & (elapsed > elapsed[-1] / 2), elapsed - elapsed[-1] / 2, elapsed)
    zeros = np.zeros(n)
    return {
        "recording": np.full(n, number, dtype=np.int64),
        "count": np.full(n, 25.0),
        "time": 600.0 * number + elapsed,
        "elapsed": elapsed,
        "theta": theta,
        "q": theta - torque / 4e6,
        "velocity": velocity,
        "acceleration": np.gradient(velocity * 185.0, STEP_S),
        "load_acceleration": np.gradient(velocity, STEP_S),
        "direction": direction,
        "last_direction": direction,
        "torque": torque,
        "torque_level": torque,
        "load_motor_level": torque - 8.0 * direction,
        "torque_rate": 120.0 * np.cos(0.4 * elapsed + number),
        "temperature": temperature + 0.02 * elapsed,
        "motor_torque": torque / 185.0 + 0.5 * direction,
        "load_motor_torque": torque - 8.0 * direction,
        "power": np.abs(0.5 * velocity * 185.0) * np.where(elapsed > elapsed[-1] / 3, 1.5, 1.0),
        "lead": zeros,
        "kept": zeros,
        "followed": np.ones(zeros.size),
        "kinetic": zeros,
        "travel": 5.0 * number + np.cumsum(np.abs(velocity)) * STEP_S,
        "reversal_travel": np.abs(velocity) * since,
        "reversal_time": since,
        "reversed_before": np.full(n, 1.0) if reverses else zeros,
        "steady": np.ones(n),
        "step": np.concatenate(([0.0], np.full(n - 1, STEP_S))),
    }


def at_loads_and_speeds(path: FloatArray, loads: Sequence[float], speeds: Sequence[float]) -> Frame:
    """Recordings of as many rows as ``path`` (n,), which scales the load in each, at some loads and speeds in both
    directions.
    """
    one = frame().take(np.arange(path.size))
    parts = []
    for number, (load, speed, turn) in enumerate(itertools.product(loads, speeds, (1.0, -1.0))):
        parts.append(
            replace(
                one,
                recording=np.full(path.size, number),
                time=one.elapsed + 100.0 * number,
                torque=load * path,
                torque_level=load * path,
                velocity=np.full(path.size, turn * speed),
                direction=np.full(path.size, turn),
                last_direction=np.full(path.size, turn),
                temperature=np.full(path.size, 25.0 + 4.0 * (number % 5)),
                steady=np.ones(path.size),
            )
        )
    return concatenate(parts)
