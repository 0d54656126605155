"""Quantities recorded beside the bench that are one of its own channels once more: another device's reading of the same
torque, the same angle in other units. Nothing depends on them but by that channel.
"""

from __future__ import annotations

import numpy as np

from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.sensitivity import is_carried
from bench.simulation.composed import parts_of
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import AUXILIARY

SAME = 1e-3
"""share of a quantity's variance that the compared channel leaves, below which it is that channel read once more: a
thousandth is the accuracy of plain sensors
"""
ALONG = 1e-5
"""the same of an angle, which is run through a hundred times as far as it differs"""


def copies(problem: ChannelProblem) -> dict[str, str]:
    """Auxiliary quantities that are a channel once more, by name, with that channel."""
    train = problem.train
    frame = problem.rows.frame.take(train)
    channels = (
        (problem.channel, problem.rows.y[train], SAME),
        ("motor_angle", frame.theta, ALONG),
        ("load_angle", frame.q, ALONG),
        ("motor_velocity", frame.velocity, SAME),
    )
    out = {}
    for name, values in frame.aux.items():
        if is_carried(name) or parts_of(name) != (name,):
            continue
        for channel, measured, most in channels:
            if _left(values, measured) < most:
                out[name] = channel
                break
    return out


def notes_of(found: dict[str, str]) -> list[str]:
    """A note for each of them."""
    reason = "once more: nothing is said to depend on it"
    return [f"{AUXILIARY}{name} is {channel} {reason}" for name, channel in found.items()]


def _left(values: FloatArray, measured: FloatArray) -> float:
    """Share of the variance of ``values`` (n,) that a straight line over ``own`` (n,) leaves; 1 where one of both is
    constant.
    """
    spread = float(np.std(values)) * float(np.std(measured))
    if not np.isfinite(values).all() or spread <= 0.0:
        return 1.0
    return 1.0 - float(np.mean((values - values.mean()) * (measured - measured.mean())) / spread) ** 2
