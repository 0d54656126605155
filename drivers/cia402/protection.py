"""How a bus process stops servo drives by itself, and the limits it watches meanwhile."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.cia402.sequence import Goal
from drivers.cia402.servo_drive import ServoDrive
from drivers.ethercat.process import Condition, Protection, RemoteBus, StopStep, Watch

_POWERED = 0x0004
"""Bit of the status word 0x6041 that is set in every state in which there may be torque."""
_SPEED_MARGIN, _TORQUE_MARGIN = 1.1, 1.2
"""Above the drives' own limits, which are above the rig's: the one who can explain itself acts first."""


def protection(
    bus: RemoteBus,
    drives: Sequence[ServoDrive],
    quick_stop_s: float,
    disable_s: float,
    patience_s: float,
    bad_cycles: int,
) -> Protection:
    """Return a protection: quick stop of all drives, then voltage off, each until no drive has power any more.

    Uses row 0 of the bus's outputs; call it when the drives are attached and configured.

    Parameters
    ----------
    quick_stop_s, disable_s : longest time of the two steps.
    patience_s : how long a drive's speed or torque may be beyond its limit.
    bad_cycles : cycles in a row with a wrong working counter.
    """
    off = tuple(Condition(drive.name, "6041:00", _POWERED, 0) for drive in drives)
    steps = []
    for goal, longest_s in ((Goal.QUICK_STOP, quick_stop_s), (Goal.DISABLED, disable_s)):
        for drive in drives:
            drive.command(goal, 0)
        steps.append(StopStep(bus.row(0), math.ceil(longest_s / bus.cycle_time_s), off))
    patience = max(1, round(patience_s / bus.cycle_time_s))
    watches = tuple(watch for drive in drives for watch in _watches(drive, patience))
    return Protection(tuple(steps), watches, bad_cycles)


def _watches(drive: ServoDrive, patience: int) -> list[Watch]:
    limits, units, inputs = drive.config.limits, drive.units, {entry.name for entry in drive.spec.inputs}
    wanted = (
        ("606C:00", _SPEED_MARGIN * limits.speed_rad_s / units.velocity_rad_s),
        ("6077:00", _TORQUE_MARGIN * limits.torque_nm / units.torque_nm),
    )
    found = []
    for entry, counts in wanted:
        if entry in inputs:
            bound = math.ceil(abs(counts))
            found.append(Watch(drive.name, entry, -bound, bound, patience))
    return found
