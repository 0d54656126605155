"""The mechanical part behind an order."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.simulation.model import Gearbox

NO_PART = "none"


def part_of(order: float, gearbox: Gearbox, notch_orders: Sequence[int] = (150, 300)) -> str:
    """Name the mechanical part an order belongs to, ``none`` where it fits none.

    Of the parts whose first order divides it, the one with the smallest multiple; low orders that fit nothing else
    are the output shaft's.
    """
    if order in notch_orders:
        return "load motor"
    z1, z2, z3, z4 = gearbox.z1, gearbox.z2, gearbox.z3, gearbox.z4
    # The listed orders of the load motor's ripple are multiples of 6 times its pole pairs.
    ripple = float(np.gcd.reduce(np.asarray(notch_orders))) if len(notch_orders) else None
    slowest = min(z for z in (z3, z4, 45) if z)
    # part, order of its first harmonic, highest multiple that is still its own, in order of preference
    parts: tuple[tuple[str, float | None, int], ...] = (
        ("motor shaft", gearbox.ratio, 1000),
        ("cycloid stage", z4, 12),
        ("cycloid disc", z3, 12),
        ("input gear", z1, 6),
        ("planetary stage", z2 / z1 if z1 and z2 else None, 3),
        ("output shaft", 1.0, slowest - 1),
        ("load motor", ripple, 4),
    )
    fits = [
        (round(order / base), -rank, name)
        for rank, (name, base, most) in enumerate(parts)
        if base and abs(order / base - round(order / base)) < 1e-6 and 1 <= round(order / base) <= most
    ]
    return min(fits)[2] if fits else NO_PART
