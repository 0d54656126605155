"""The motor's ripple in the load torque: the gearbox passes it on, and what it leaves there is no effect of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import UNNAMED, ChannelOutcome, Discovery
from bench.mismatch.orders.shaft import RIPPLE
from bench.mismatch.recordings.vibration import NYQUIST_SHARE, Density

ABOUT = 40
"""bins to either side of a line that tell the level of noise there"""
WAVERS = 0.01
"""of its frequency, by which a line is wide where the speed is not quite one"""


def without_passed_on(load: ChannelOutcome, motor: ChannelOutcome, densities: Sequence[Density]) -> None:
    """Take out of the load torque what is left without an explanation, where most of it lies at the orders of the
    ripple that was found in the ``motor`` torque; with a note. ``densities``: densities of the load torque.
    """
    orders = [order for d in motor.discoveries if d.effect == RIPPLE for order in d.orders]
    left = [d for d in load.discoveries if _scatter(d)]
    if not orders or not left or not densities:
        return
    lines = float(np.median([sum(line_power(one, order) for order in orders) for one in densities]))
    size = max(float(p["value"]) for d in left for p in d.parameters if p["symbol"] == "rms")
    if lines < criteria.EITHER * size**2:
        return
    load.discoveries = [d for d in load.discoveries if not _scatter(d)]
    load.notes.append(
        f"what is left of the load torque is at the orders of the motor's ripple, {np.sqrt(lines):.3g} N*m rms: the"
        " gearbox passes it on; the simulation does not say how much"
    )


def line_power(one: Density, order: float) -> float:
    """Mean square of an order of the output shaft in a recording, above the noise about it; 0 where it is too fast."""
    centre = order * one.rotation_rate / one.step
    wide = max(2, int(np.ceil(WAVERS * centre)))
    if one.rotation_rate <= 0.0 or order * one.rotation_rate > NYQUIST_SHARE * one.rate:
        return 0.0
    a, b = round(centre) - wide, round(centre) + wide + 1
    if a < 1 or b > one.power.size:
        return 0.0
    beside = np.concatenate([one.power[max(a - ABOUT, 1) : a], one.power[b : b + ABOUT]]).astype(np.float64)
    # the middle of a spectrum of noise is ln 2 of its mean
    level = float(np.median(beside)) / np.log(2.0) if beside.size else 0.0
    return max(float(np.sum(one.power[a:b].astype(np.float64) - level)) * one.step, 0.0)


def _scatter(found: Discovery) -> bool:
    """Whether it is what is left and nothing recorded predicts."""
    return found.effect == UNNAMED and found.gain == 0.0 and any(p["symbol"] == "rms" for p in found.parameters)
