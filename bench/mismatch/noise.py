"""Noise of a channel's rows, estimated on what even a flexible model cannot explain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.bank import Bank, Noise
from bench.mismatch.columns import Layout, is_integral
from bench.mismatch.rows import Rows
from bench.simulation.frame import FloatArray, Frame, IntArray

CLASSES = 4
LADDER = (0.03, 0.1, 0.25, 0.5, 0.8, 1.2, 1.8, 2.7, 4.0, 6.0, 10.0, 20.0, 40.0)
"""variances of the recordings' offsets that are tried, times the scatter of the recordings' means"""


def classes(frame: Frame) -> IntArray:
    """Kind of motion of each row: 0 steady, 1 moving but not steady, 2 just after a start or reversal, 3 standstill."""
    kind = np.where(frame.steady > 0.5, 0, 1)
    lively = (frame.reversal_time < 1.5) & (frame.reversal_travel < 0.05) & (frame.steady < 0.5)
    kind = np.where(lively, 2, kind)
    return np.asarray(np.where(frame.direction == 0, 3, kind), dtype=np.int64)


def robust_spread(values: FloatArray) -> float:
    """Standard deviation of the bulk: the values beyond four spreads (by the median) are clipped."""
    if values.size < 4:
        return float(np.std(values)) if values.size else 1.0
    middle = float(np.median(values))
    spread = 1.4826 * float(np.median(np.abs(values - middle)))
    if spread == 0.0:
        return float(np.std(values)) or 1e-12
    return float(np.sqrt(np.mean(np.clip(values - middle, -4 * spread, 4 * spread) ** 2)))


def _correlation(residual: FloatArray, chosen: NDArray[np.bool_], joined: NDArray[np.bool_]) -> float:
    pairs = chosen[1:] & chosen[:-1] & joined[1:]
    if pairs.sum() < 30:
        return 0.0
    a, b = residual[1:][pairs], residual[:-1][pairs]
    limit = 4.0 * robust_spread(np.concatenate([a, b]))
    a, b = np.clip(a, -limit, limit), np.clip(b, -limit, limit)
    return float(np.clip(np.mean(a * b) / max(float(np.mean(a * a)), 1e-300), 0.0, 0.95))


def _steps(frame: Frame, chosen: NDArray[np.bool_]) -> FloatArray:
    """Time from the row before to each of the rows chosen, in usual steps of their kind, one at least: rows between may
    be missing.
    """
    since = np.abs(np.diff(frame.elapsed, prepend=frame.elapsed[0]))[chosen]
    usual = max(float(np.median(since)), 1e-9)
    return np.clip(since / usual, 1.0, 1e3)


def first_guess(rows: Rows) -> Noise:
    """Noise before any fit: the samples' own scatter inside the blocks."""
    inner = np.sqrt(np.maximum(rows.within, 0.0) / np.maximum(rows.number, 1.0))
    floor = np.median(inner[inner > 0]) if np.any(inner > 0) else 1.0
    return Noise(np.maximum(inner, floor), np.zeros(rows.y.size))


def estimate(channel: str, rows: Rows, layout: Layout, starts: IntArray, beside: Sequence[FloatArray] = ()) -> Noise:
    """Noise from the residual of the simulation with every free-form rival beside it, a class of motion each; and with
    further columns ``beside``.

    Rows are weighted by their samples; the offset a recording is given as a ladder of variances, from none to what the
    recordings' means scatter, of which the fits choose the likeliest.
    """
    noise = first_guess(rows)
    index = np.array([*layout.base, *(i for entry in layout.free if entry.common for i in entry.index)], dtype=np.int64)
    columns = np.hstack([layout.columns[:, index], *beside])
    further = np.zeros(columns.shape[1] - index.size)
    prior, precision = np.append(layout.prior[index], further), np.append(layout.precision[index], further)
    together = np.zeros(starts.size - 1, dtype=np.int64)  # nothing is left out here: one fold
    variance: tuple[float, ...] = (np.inf,) if is_integral(channel) else (0.0,)
    kind = classes(rows.frame)
    joined = np.append(False, rows.frame.recording[1:] == rows.frame.recording[:-1])
    residual = np.zeros(rows.y.size)
    for _ in range(3):
        noise = Noise(noise.sigma, noise.correlation, variance)
        bank = Bank(rows.y, starts, together, columns, prior, noise, precision)
        fit = bank.fit(range(bank.size), leave_out=False)
        residual = rows.y - columns @ fit.coefficients
        means = _means(residual, starts)
        centred = residual - np.repeat(means, np.diff(starts)) if is_integral(channel) else residual
        sigma = np.empty(rows.y.size)
        rho = np.zeros(rows.y.size)
        for c in range(CLASSES):
            chosen = kind == c
            if not chosen.any():
                continue
            typical = np.sqrt(np.median(rows.number[chosen]) / np.maximum(rows.number[chosen], 1.0))
            sigma[chosen] = robust_spread(centred[chosen] / typical) * np.clip(typical, 0.3, 5.0)
            rho[chosen] = _correlation(centred / max(float(np.median(sigma[chosen])), 1e-300), chosen, joined)
            rho[chosen] **= _steps(rows.frame, chosen)
        sigma = np.maximum(sigma, 0.3 * max(float(np.median(sigma)), 1e-12))
        noise = Noise(sigma, rho, variance)
    if is_integral(channel):
        return noise
    scatter = float(np.var(_means(residual, starts)))
    return Noise(noise.sigma, noise.correlation, (0.0, *(scatter * f for f in LADDER)))


def quick_variance(residual: FloatArray, rows: Rows, used: NDArray[np.bool_], lag_s: float) -> float:
    """Variance (a sample's, times one) of what differs between rows ``lag_s`` apart in steady motion.

    Noise has forgotten itself by then; whatever lasts longer than the lag, and no model follows, is not counted. Not a
    number where there are too few pairs.
    """
    frame = rows.frame
    place = np.flatnonzero(used & (frame.steady > 0.5) & (rows.number > 0))
    if place.size < 50:
        return float("nan")
    step = float(np.median(np.diff(frame.elapsed[place])[np.diff(frame.recording[place]) == 0]))
    k = max(1, round(lag_s / max(step, 1e-9)))
    a, b = place[:-k], place[k:]
    apart = frame.elapsed[b] - frame.elapsed[a]
    pairs = (frame.recording[a] == frame.recording[b]) & (np.abs(apart - lag_s) < 0.25 * lag_s)
    if pairs.sum() < 50:
        return float("nan")
    change = (residual[b] - residual[a])[pairs] * np.sqrt(0.5 * (rows.number[a] + rows.number[b])[pairs])
    return robust_spread(change) ** 2 / 2.0


def _means(residual: FloatArray, starts: IntArray) -> FloatArray:
    sums = np.add.reduceat(residual, starts[:-1])
    return np.asarray(sums / np.maximum(np.diff(starts), 1))
