"""A channel made by hand: recordings at constant speeds, a torque with known coefficients, white noise of known
size.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.bank import Bank, Whitening
from bench.mismatch.regression.model import Block, add_base
from bench.mismatch.regression.noise import RowNoise
from bench.mismatch.regression.problem import BaseTerm, ChannelProblem
from bench.mismatch.regression.regressors import Named
from bench.simulation.frame import ARRAYS, FloatArray, Frame, concatenate, recording_starts
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE

RATIO = 185.0
EACH = 30
"""rows a recording"""


def campaign(recordings: int = 24, seed: int = 0) -> Frame:
    """Recordings at speeds from 0.003 to 0.17 rad/s in turn, both directions, loads and temperatures drawn."""
    rng = np.random.default_rng(seed)
    speeds = np.geomspace(0.003, 0.17, recordings)
    parts = []
    for number in range(recordings):
        side = 1.0 if number % 2 == 0 else -1.0
        elapsed = np.arange(EACH, dtype=np.float64)
        values: dict[str, FloatArray] = {name: np.zeros(EACH) for name in ARRAYS}
        speed = float(speeds[number])
        values |= {
            "count": np.full(EACH, 100.0),
            "time": 600.0 * number + elapsed,
            "elapsed": elapsed,
            "theta": side * speed * elapsed,
            "q": side * speed * elapsed,
            "velocity": np.full(EACH, side * speed),
            "direction": np.full(EACH, side),
            "last_direction": np.full(EACH, side),
            "torque": np.full(EACH, float(rng.uniform(-800.0, 800.0))),
            "temperature": np.full(EACH, float(rng.uniform(22.0, 40.0))),
            "travel": 2.0 * number + speed * elapsed,
            "reversal_travel": 1.0 + speed * elapsed,
            "reversal_time": 100.0 + elapsed,
            "steady": np.ones(EACH),
            "step": np.where(elapsed > 0, 1.0, 0.0),
        }
        values["torque_level"] = values["torque"]
        parts.append(Frame(ratio=RATIO, **values | {"recording": np.full(EACH, number, dtype=np.int64)}))  # type: ignore[arg-type]
    return concatenate(parts)


def problem(frame: Frame, y: FloatArray) -> ChannelProblem:
    """A motor torque whose simulation has dry and viscous friction; every recording is a fold."""
    base = tuple(
        BaseTerm(Named(LIBRARY[effect], MOTOR_TORQUE, LIBRARY[effect].forms[MOTOR_TORQUE][0]))
        for effect in ("friction.coulomb", "friction.viscous")
    )
    rows = Rows(frame, y, frame.count)
    folds = np.arange(int(frame.recording.max()) + 1, dtype=np.int64)
    return ChannelProblem(MOTOR_TORQUE, rows, np.ones(frame.size, dtype=bool), folds, base)


def banked(own: ChannelProblem, sigma: float, correlation: float = 0.0) -> tuple[Bank, list[Block]]:
    """The problem's bank for rows of noise ``sigma`` N·m, each correlated with the one before, and its base."""
    size = own.rows.size
    starts = recording_starts(own.rows.frame)
    rho = np.full(size, correlation)
    rho[starts[:-1]] = 0.0
    bank = Bank(own.rows.y, Whitening(RowNoise(np.full(size, sigma), rho, 1.0), starts))
    return bank, add_base(own, bank)


def with_y(own: ChannelProblem, y: FloatArray) -> ChannelProblem:
    """The same problem with other measured values (n,)."""
    return replace(own, rows=replace(own.rows, y=y))
