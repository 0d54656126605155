"""A location in words, for people: degrees, degrees a second, °C."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.mismatch.report.location import BOTH, Location
from bench.mismatch.report.variables import RANGES, TEMPERATURE, TORQUE, VELOCITY

HARDLY = 0.05
"""share of the samples: a range that leaves fewer beyond an end is open at that end, in words"""
AROUND_ZERO = 0.1
"""of its width: a range of torque whose middle is nearer to zero is one about zero"""
MOST_ORDERS = 8


@dataclass(frozen=True, slots=True)
class Unit:
    """How a range is written: unit, how many of it in an SI unit, format, and what all of it is called."""

    name: str
    scale: float
    form: str
    all: str


_ROTATING = {
    VELOCITY: Unit("deg/s", float(np.degrees(1.0)), ".3g", "all speeds"),
    TORQUE: Unit("N·m", 1.0, ".0f", "all loads"),
    TEMPERATURE: Unit("°C", 1.0, ".1f", "all temperatures"),
}
_LINEAR = _ROTATING | {
    VELOCITY: Unit("mm/s", 1000.0, ".3g", "all speeds"),
    TORQUE: Unit("N", 1.0, ".0f", "all loads"),
}


def text(where: Location, linear: bool = False) -> str:
    """The location in words; ``linear``: of a linear axis."""
    units = _LINEAR if linear else _ROTATING
    parts = [*_orders(where), *_windows(where)]
    parts += [_range(where, name, units[name]) for name in where.depends if name not in where.in_words]
    if where.time_window_iso is not None:
        begin, end = (t.replace("T", " ").rstrip("Z") for t in where.time_window_iso)
        parts.append(f"from {begin} to {end} UTC")
    parts += where.words
    parts.append("both directions" if where.direction == BOTH else f"{where.direction} direction")
    parts += [units[n].all for n in RANGES if n not in where.depends and where.span[n][1] > where.span[n][0]]
    return ", ".join(parts)


def _range(where: Location, name: str, unit: Unit) -> str:
    low, high = (unit.scale * v for v in where.ranges[name])
    below, above = where.outside[name]
    if below < HARDLY and above < HARDLY:
        return unit.all
    if name == TORQUE and abs(low + high) < AROUND_ZERO * (high - low):
        return f"within ±{max(-low, high):{unit.form}} {unit.name}"
    if below < HARDLY:
        return f"below {high:{unit.form}} {unit.name}"
    if above < HARDLY:
        return f"above {low:{unit.form}} {unit.name}"
    ends = f"{low:{unit.form}}", f"{high:{unit.form}}"
    return f"at {ends[0]} {unit.name}" if ends[0] == ends[1] else f"{ends[0]} to {ends[1]} {unit.name}"


def _orders(where: Location) -> list[str]:
    if not where.orders:
        return []
    shown = ", ".join(f"{f:g}" for f in where.orders[:MOST_ORDERS])
    more = len(where.orders) - MOST_ORDERS
    listed = shown + (f" and {more} more" if more > 0 else "")
    return [f"at order{'s' if len(where.orders) > 1 else ''} {listed}"]


def _windows(where: Location) -> list[str]:
    if not where.angle_windows:
        return []
    shown = ", ".join(f"{np.degrees(a):.1f} to {np.degrees(b):.1f}°" for a, b in where.angle_windows)
    return [f"at {shown} of the output angle"]
