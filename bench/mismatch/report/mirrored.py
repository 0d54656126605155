"""What the torque sensor misreads comes back in the motor torque: as a load that the motor does not feel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch.discovery import UNNAMED, ChannelOutcome, Discovery
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE

MOST_LEFT = 0.1
"""share of its energy that a misread load leaves of what the motor torque shows: the rest is nine tenths, what a report
calls the same elsewhere too
"""


def mirrored(outcomes: Sequence[ChannelOutcome], ratio: float) -> bool:
    """Whether what has no name in the motor torque is that of the load torque over the gear ratio, with the opposite
    sign: the sensor reads a load that is not there, and the motor does not deliver it.
    """
    by_channel = {o.channel: o for o in outcomes}
    if not {LOAD_TORQUE, MOTOR_TORQUE} <= set(by_channel):
        return False
    load, motor = by_channel[LOAD_TORQUE], by_channel[MOTOR_TORQUE]
    read, shown = _unnamed(load), _unnamed(motor)
    if not read or not shown:
        return False
    number = np.where(motor.usable, motor.rows.number, 0.0)
    misread = np.interp(motor.rows.frame.time, load.rows.frame.time, np.sum([d.added for d in read], axis=0))
    explained = np.sum([d.added for d in shown], axis=0)
    energy = float(np.sum(number * explained**2))
    return energy > 0.0 and float(np.sum(number * (explained + misread / ratio) ** 2)) <= MOST_LEFT * energy


def _unnamed(outcome: ChannelOutcome) -> list[Discovery]:
    return [d for d in outcome.discoveries if d.effect == UNNAMED]
