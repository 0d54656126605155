"""The load motor's ripple as a folder has it: its orders, and how late the torque sensor tells it.

A torque that is told late has the phase of a ripple where the shaft was. At one speed no one sees that; while a shaft
starts, the ripple taken off is turned against the one that is measured, and leaves waves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bench.mismatch.recordings.late import lag_of
from bench.mismatch.recordings.notch import orders_of, steady_lines
from bench.recording import Recording


@dataclass(frozen=True, slots=True)
class Ripple:
    """``orders`` per output revolution; ``lag``: s by which the sensor tells it late, 0 where none is seen."""

    orders: tuple[float, ...] = ()
    lag: float = 0.0


def ripple_of(recordings: Sequence[Recording]) -> Ripple:
    """The load motor's ripple of some recordings."""
    lines = steady_lines(recordings)
    orders = () if lines is None else orders_of(lines)
    if lines is None or not orders:
        return Ripple()
    return Ripple(orders, lag_of(lines.torque[:, [round(f) for f in orders]], lines.one, lines.speed, orders))
