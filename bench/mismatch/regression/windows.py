"""Where over the output angle a function of the angle acts: few windows, or the orders that draw it."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, IntArray

BINS = 90
"""parts of a revolution"""
HELD = 0.9
"""share of the energy that the windows hold: the report's contract on places"""
WIDEST = 0.5
"""share of a revolution from which a function is no longer told by windows, but by its orders"""
FEW = 3
"""orders that still are a place: more are a shape"""
HIGHEST = 20
"""order up to which those of a function are told: its table has no finer knots"""


def acting(angle: FloatArray, course: FloatArray, number: FloatArray) -> tuple[tuple[float, float], ...]:
    """Windows (rad, begin to end in the sense of rotation) of the output angle in which a ``course`` (n,) acts.

    The smallest that hold nine tenths of its energy on samples (``number`` a row); none where they would be more than
    half a revolution, or where the rows leave a part of the revolution out.
    """
    mean = _density(angle, course, number)
    if mean is None:
        return ()
    # a calibration takes the mean off: what stands at the usual level does not act
    density = (mean - np.median(mean)) ** 2
    most = strongest(density)
    if not 0 < most.size <= WIDEST * BINS:
        return ()
    inside = np.zeros(BINS, dtype=bool)
    inside[most] = True
    # a passage through zero is no end of a window
    inside |= np.roll(inside, 1) & np.roll(inside, -1)
    step = 2.0 * np.pi / BINS
    begins = np.flatnonzero(inside & ~np.roll(inside, 1))
    out = []
    for begin in begins.tolist():
        length = next(k for k in range(1, BINS + 1) if not inside[(begin + k) % BINS])
        out.append((begin * step, (begin + length) * step))
    return tuple(out)


def followed(angle: FloatArray, course: FloatArray, factor: FloatArray, number: FloatArray) -> float:
    """Energy of a ``course`` (n,) that a function of the output angle, times a ``factor`` (n,), follows."""
    weight = np.where(factor != 0.0, number * factor**2, 0.0)
    mean = _density(angle, np.divide(course, factor, out=np.zeros(course.size), where=factor != 0.0), weight)
    if mean is None:
        return 0.0
    fitted = mean[_bins(angle)]
    return float(np.sum(weight * fitted**2))


def orders(angle: FloatArray, course: FloatArray, number: FloatArray) -> tuple[float, ...]:
    """Whole orders of a ``course`` (n,) over the output angle that hold nine tenths of its energy, strongest first."""
    mean = _density(angle, course, number)
    if mean is None:
        return ()
    return tuple(float(k + 1) for k in strongest(np.abs(np.fft.rfft(mean)[1 : HIGHEST + 1]) ** 2))


def orders_of_each(angle: FloatArray, values: FloatArray, number: FloatArray, recording: IntArray) -> tuple[float, ...]:
    """Whole orders that hold nine tenths of what recordings have over the output angle, each with a phase and size of
    its own, strongest first; none where these are more than :data:`FEW`, or the recordings' means are among them.
    """
    power = np.zeros(BINS // 2 + 1)
    for rows in (recording == r for r in np.unique(recording)):
        mean = _density(angle[rows], values[rows], number[rows])
        if mean is not None:
            power += np.abs(np.fft.rfft(mean)) ** 2 * np.append(1.0, np.full(BINS // 2, 2.0)) * number[rows].sum()
    rows = strongest(power)
    known = rows.size <= FEW and np.all((rows > 0) & (rows <= HIGHEST))
    return tuple(float(k) for k in rows) if known else ()


def strongest(energy: FloatArray) -> IntArray:
    """Numbers of the fewest parts that hold nine tenths of an energy (n,), strongest first; none if it is nil."""
    order = np.argsort(-energy, kind="stable")
    held = np.cumsum(energy[order])
    return order[: int(np.searchsorted(held, HELD * held[-1])) + 1 if held[-1] > 0.0 else 0]


def _density(angle: FloatArray, values: FloatArray, number: FloatArray) -> FloatArray | None:
    """Mean of values (n,) in each part of a revolution; None where a part has no sample."""
    counted = number > 0
    bin_of_row = _bins(angle[counted])
    weight = np.bincount(bin_of_row, number[counted], BINS)
    if not np.all(weight > 0.0):
        return None
    return np.asarray(np.bincount(bin_of_row, number[counted] * values[counted], BINS) / weight)


def _bins(angle: FloatArray) -> IntArray:
    """The part of a revolution that each angle (n,) lies in."""
    return np.floor(np.mod(angle, 2.0 * np.pi) / (2.0 * np.pi) * BINS).astype(np.int64) % BINS
