"""Numbers a mapping needs that the data themselves give: rates, units of time, overflows, the gear ratio."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bench.importing.looking.column import Column
from bench.importing.units import si_of, unit_of
from bench.importing.wraps import jumps_of

FloatArray = NDArray[np.float64]
_POSIX = 4e8, 5e9
_EPOCHS = (("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9))
_FULL = 0.97
_SLOW_STEP = 1.0
_CLOSE = 0.02
STRETCH, _TOGETHER = 20, 0.99
"""samples over which an angle and the integral of a speed are compared, and how well they have to go together"""
_BOTH = 0.01
"""least share of the samples on either side for numbers to be taken as without their sign"""
_LEAST_SIGN_BIT, _MOST_BITS = 7, 32
"""bits that may be a sign: that of a byte, to that of 32 bits (``sign_bit`` of a mapping goes to 31)"""
_SIZES = 5
"""sizes that numbers of either sign have at least; fewer are states or set values, not something measured"""
_CHANGES = 3
"""changes of sign from which numbers tell one: a single jump may be a change of level"""
_NEAR_ZERO, _OF_JUMP = 0.67, 0.25
"""What numbers are where the sign changes: each at most this share of the largest of its sign (normal noise about zero
is so in 19 of 20 places; a counter that starts again and a change of level come from the largest), and the step at most
this share of that in the file (where an unsigned counter passes the bit it is many times as large)."""
_SAME_RESOLUTION = 0.01
"""how near a number of counts has to be to a power of two for that to be it (relative); the next is twice as large"""
_LEAST_STEPS = 10
"""steps from which numbers tell of a clock, or of rows that are counted"""
_EVEN, _MOSTLY = 0.25, 0.9
"""how far a clock's step may be from its usual one, and how many of its steps are no farther"""


def rises_evenly(column: Column) -> bool:
    """Whether a column is a clock by its numbers alone: it never stays or falls, and its steps are much alike."""
    steps = np.diff(column.seconds)
    if steps.size < _LEAST_STEPS or not np.isfinite(steps).all() or not np.all(steps > 0.0):
        return False
    usual = float(np.median(steps))
    return float(np.mean(np.abs(steps - usual) <= _EVEN * usual)) >= _MOSTLY


def counts_by_one(column: Column) -> bool:
    """Whether a column rises by one in each row, as row numbers do."""
    steps = np.diff(column.seconds)
    return not column.stamps and steps.size >= _LEAST_STEPS and bool(np.all(steps == 1.0))


def step_of(column: Column) -> float | None:
    """Usual step of a column that rises, in its own unit; None where it does not."""
    steps = np.diff(column.seconds)
    steps = steps[np.isfinite(steps)]
    rising = steps[steps > 0]
    if not steps.size or rising.size < 0.5 * steps.size or np.sum(steps < 0) > max(2, 0.01 * steps.size):
        return None
    return float(np.median(rising))


def unit_of_time(column: Column) -> tuple[str, bool]:
    """Unit of a clock that says none, and whether that is sure; ``?`` where it may be several."""
    if column.stamps:
        return "s", True
    first, step = float(column.seconds[0]), step_of(column) or 0.0
    for unit, factor in _EPOCHS:
        if _POSIX[0] * factor < first < _POSIX[1] * factor:
            return unit, True
    return ("?", False) if step >= _SLOW_STEP else ("s", False)


def overflow(column: Column, unit: str, counted: bool) -> float | None:
    """After how much an angle starts again, in its own unit; None where it does not, or its motion would not go on
    evenly there.
    """
    jumps = jumps_of(column.seconds)
    if jumps is None:
        return None
    if counted:
        return jumps.period()
    if si_of(unit) != "rad":
        return None
    revolution = float(f"{2 * math.pi / unit_of(unit, column.name).factor:.12g}")
    return revolution if _FULL * revolution < jumps.span <= 1.001 * revolution and jumps.over(revolution) else None


def power_of_two(counts: float) -> float | None:
    """The power of two that a number of counts nearly is, as encoders have them; None where it is none."""
    near = 2.0 ** round(math.log2(counts)) if counts > 1.0 else 1.0
    return near if abs(counts / near - 1.0) < _SAME_RESOLUTION else None


def unsigned_bits(column: Column) -> int | None:
    """Bits of integers that were written without their sign: all are near 0 or near the largest there is, and both."""
    values = column.values
    if values.dtype.kind not in "iu" or not values.size or int(values.min()) < 0:
        return None
    for bits in (8, 16, 32):
        span = 2**bits
        if int(values.max()) < span:
            high, low = float(np.mean(values >= 0.75 * span)), float(np.mean(values < 0.25 * span))
            return bits if high + low == 1.0 and min(high, low) >= _BOTH else None
    return None


def sign_bit(column: Column) -> int | None:
    """The bit that is the sign of whole numbers with their size in the bits below it; None where none seems to be.

    Without the bit's value the numbers go on evenly through zero where it changes, in nearly all places.
    """
    values = column.seconds[np.isfinite(column.seconds)]
    if not column.whole or values.min() < 0.0 or not 2.0**_LEAST_SIGN_BIT <= values.max() < 2.0**_MOST_BITS:
        return None
    bit = int(values.max()).bit_length() - 1
    negative, signed = values >= 2.0**bit, of_sign_and_size(values, bit)
    changes = np.flatnonzero(negative[1:] != negative[:-1])
    sizes = min(np.unique(signed[negative]).size, np.unique(signed[~negative]).size)
    if min(np.mean(negative), np.mean(~negative)) < _BOTH or sizes < _SIZES or changes.size < _CHANGES:
        return None
    steps, jumps = (np.abs(np.diff(numbers))[changes] for numbers in (signed, values))
    largest = np.where(signed < 0.0, -signed.min(), signed.max())
    near_zero = np.abs(signed) <= _NEAR_ZERO * largest
    through_zero = near_zero[changes] & near_zero[changes + 1] & (steps <= _OF_JUMP * jumps)
    return bit if float(np.mean(through_zero)) >= _MOSTLY else None


def of_sign_and_size(values: FloatArray, bit: int) -> FloatArray:
    """Numbers with their sign, of those that have it in a bit."""
    return np.where(values >= 2.0**bit, 2.0**bit - values, values)


def rate_of(angle: FloatArray, velocity: FloatArray) -> float | None:
    """Samples per second at which a speed in rad/s (m/s) is the rate of an angle in rad (m); None where it is none."""
    if angle.size <= STRETCH or not (np.isfinite(angle).all() and np.isfinite(velocity).all()):
        return None
    run = integral(np.arange(velocity.size, dtype=np.float64), velocity)
    turned, said = (values[STRETCH:] - values[:-STRETCH] for values in (angle, run))
    if np.std(turned) == 0.0 or np.std(said) == 0.0 or np.corrcoef(turned, said)[0, 1] < _TOGETHER:
        return None
    return float(f"{np.std(said) / np.std(turned):.3g}")


def integral(time: FloatArray, velocity: FloatArray) -> FloatArray:
    """Angle run through at a velocity, from 0 (trapezoids); samples that are no number count as the one before."""
    good = np.isfinite(time) & np.isfinite(velocity)
    run = np.zeros(time.size)
    if np.sum(good) > 1:
        t, v = time[good], velocity[good]
        sums = np.concatenate(([0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))))
        run = sums[np.clip(np.cumsum(good) - 1, 0, None)]
    return run


def ratio_of(motor: FloatArray, load: FloatArray) -> float | None:
    """Gear ratio from the motor's angle and the output's, both in rad; None where they do not go together."""
    good = np.isfinite(motor) & np.isfinite(load)
    if np.sum(good) < 10 or np.ptp(load[good]) == 0.0:
        return None
    slope, start = np.polyfit(load[good], motor[good], 1)
    left = motor[good] - start - slope * load[good]
    if np.std(left) > _CLOSE * np.std(motor[good]) or abs(slope) < 1e-3:
        return None
    whole = round(float(slope))
    return float(whole) if whole and abs(slope / whole - 1.0) < 1e-3 else float(f"{slope:.6g}")
