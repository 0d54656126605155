"""Detection limits: which effects the recordings could not have shown, channel by channel.

A report that finds nothing says how small and how quick that nothing may be.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.orders.look import HIGHEST_ORDER
from bench.mismatch.orders.revolutions import found_in
from bench.mismatch.orders.swings import bounds
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.motion import NEARLY_ALL, share_of_one_way
from bench.mismatch.recordings.output_orders import HIGHEST_OUTPUT_ORDER
from bench.mismatch.recordings.vibration import HIGHEST_SHAFT_ORDER
from bench.simulation.terms import CHANNEL_UNITS, LOAD_TORQUE, MOTOR_TORQUE, TRANSMISSION_ERROR


def limits(outcome: ChannelOutcome, data: Dataset) -> str:
    """One sentence: below what size effects, and above what order, a channel's recordings could not have shown any."""
    unit = CHANNEL_UNITS[outcome.channel]
    acts, overall = criteria.LEAST_STRENGTH * outcome.floor, criteria.LEAST_OVERALL * outcome.floor
    lines = [f"effects below {acts:.2g} {unit} where they act or {overall:.2g} {unit} over all samples"]
    if not data.linear:
        lines += _orders(outcome, data)
    return f"{outcome.channel}: these recordings could not have shown {', nor '.join(lines)}"


def one_way(outcome: ChannelOutcome) -> list[str]:
    """A sentence where nearly all motion that the motor torque is compared in goes one way."""
    frame, number = outcome.rows.frame, np.where(outcome.usable, outcome.rows.number, 0.0)
    most = share_of_one_way(frame.direction, number)
    if outcome.channel != MOTOR_TORQUE or most is None or most < NEARLY_ALL:
        return []
    share = "all" if most == 1.0 else f"{most:.3g}"
    return [
        f"{outcome.channel}: {share} of the compared motion goes one way, so friction is not told"
        " from a torque that keeps its sign when the motion turns round, such as gravity or cogging"
    ]


def _in_swings(outcome: ChannelOutcome, data: Dataset) -> bool:
    """Whether orders of a channel were looked for in swings, as no steady part of it covers a revolution."""
    if outcome.channel == TRANSMISSION_ERROR:
        return not found_in(outcome.rows.frame)
    return outcome.channel == MOTOR_TORQUE and not data.output.get(MOTOR_TORQUE) and not data.shaft


def _of_swings(outcome: ChannelOutcome) -> str:
    fitted = np.flatnonzero(outcome.usable & ~outcome.held_out)
    found = bounds(outcome.rows.frame.take(fitted))
    why = "no steady part has a whole revolution"
    if found is None:
        return f"single orders of the output, but for functions of the angle ({why}, and the swings are too short)"
    below = f"below {found[0]:.0f}, which are parts of functions of the angle, or " if found[0] >= 1.0 else ""
    return f"orders {below}above {found[1]:.0f} per output revolution ({why}: they were looked for in the swings)"


def _orders(outcome: ChannelOutcome, data: Dataset) -> Sequence[str]:
    if _in_swings(outcome, data):
        return [_of_swings(outcome)]
    if outcome.channel == TRANSMISSION_ERROR:
        highest = float(HIGHEST_ORDER)
    elif outcome.channel in (MOTOR_TORQUE, LOAD_TORQUE):
        if not data.output.get(outcome.channel):
            return [
                "single orders of the output, but for functions of the angle (no steady part has a whole revolution)"
            ]
        highest = float(HIGHEST_OUTPUT_ORDER)
    else:
        return []
    frame = outcome.rows.frame
    speed = np.abs(frame.velocity[outcome.usable & (frame.steady > 0.5)])
    slowest = float(speed.min(initial=np.inf))
    rate = max(m.recording.sample_rate for m in data.members)
    # half the samples of a revolution at the slowest speed
    sampled = np.pi * rate / slowest if 0.0 < slowest < np.inf else highest
    shaft = ""
    if outcome.channel == MOTOR_TORQUE and data.shaft:
        shaft = f", but for whole orders of the motor's shaft up to {HIGHEST_SHAFT_ORDER}"
    return [f"orders above {min(highest, sampled):.0f} per output revolution{shaft}"]
