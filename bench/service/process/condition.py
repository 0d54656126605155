"""How the bench is right now: values, drive states, safety inputs, bus; the same while it runs, waits, or is paused."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from bench.cycle.view import View

Message = dict[str, Any]

SHOWN: tuple[str, ...] = (
    "motor_velocity_setpoint",
    "motor_velocity",
    "load_velocity",
    "motor_torque",
    "load_motor_torque_setpoint",
    "load_torque",
    "load_motor_torque",
    "temperature",
    "ambient_temperature",
    "motor_angle",
    "load_angle",
)
"""Channels whose values go to the page."""
_AS_LAST = frozenset({"motor_angle", "load_angle", "motor_velocity_setpoint", "load_motor_torque_setpoint"})
"""Of these the last value is meant, of the others the mean of the last block of cycles."""
_CIRCUITS = ("emergency_stop", "safe_torque_off")


def condition(view: View, source: str) -> Message | None:
    """Return the last block of a bench as a message, None if nothing has been read yet; sends nothing to the bench.

    Parameters
    ----------
    view : the bench in operation.
    source : ``run`` or ``idle``, who reads it.

    Values are in SI (°C for temperatures). ``drives`` holds the state of each drive (CiA 402) by role, ``inputs``
    whether a safety circuit demands a stop, for those the bench has. ``bus`` is about the last block alone: cycles,
    those with a wrong working counter, how late the latest was in s (None where nobody measures it); and the age in s
    of the lubricant's reading.
    """
    last = view.link.last
    if last is None or not last.size:
        return None
    scaling, values = view.scaling, {}
    for name in SHOWN:
        raw = last.raw.get(name)
        if raw is None or not raw.size or name not in scaling.specs:
            continue
        counts = float(raw[-1]) if name in _AS_LAST else float(np.mean(raw))
        values[name] = float(f"{counts * scaling.scale(name) + scaling.offset(name):.9g}")
    inputs, safety = last.inputs, view.link.assembly.safety
    return {
        "type": "condition",
        "source": source,
        "at": time.time(),
        "cycle": view.link.cycle,
        "values": {name: value for name, value in values.items() if np.isfinite(value)},
        "drives": view.drive_states,
        "inputs": {
            name: bool(getattr(inputs, name)[-1]) for name in _CIRCUITS if safety is not None and name in safety.names
        },
        "bus": {
            "cycles": last.size,
            "bad": int(np.count_nonzero(~inputs.good)),
            "late_s": None if last.late_s is None else float(last.late_s.max()),
            "temperature_age_s": _finite(float(inputs.temperature_age_s[-1])),
        },
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
