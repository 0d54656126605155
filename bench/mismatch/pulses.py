"""The shape of a pulse over the angle, fitted to what all recordings show there on the average.

The order spectrum finds where a pulse is and about how wide; triangles, half sines and doublets are then described by
one to three Gaussians, fitted over the angle itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from bench.mismatch.peaks import Peak
from bench.mismatch.periodic import Pulse
from bench.mismatch.rows import Rows
from bench.simulation.frame import FloatArray

MOST_GAUSSIANS = 3
WINDOW = 5.0
"""half width of the window that is fitted, in widths of its widest pulse"""
BINS = 120
PENALTY = 12.0
"""chi-square asked of each further Gaussian"""


def at(peaks: Sequence[Peak], theta: FloatArray) -> FloatArray:
    """Sum of the pulses among ``peaks`` at angles (n,), rad."""
    out = np.zeros(theta.size)
    for peak in peaks:
        if peak.kind == "pulse":
            out += Pulse(peak.angle, peak.width, peak.height).evaluate(theta)
    return out


def _apart(angle: FloatArray | float, centre: float) -> FloatArray:
    return np.asarray(np.mod(np.asarray(angle) - centre + np.pi, 2.0 * np.pi) - np.pi)


def clusters(peaks: Sequence[Peak]) -> list[list[Peak]]:
    """Pulses that overlap, together; strongest first."""
    out: list[list[Peak]] = []
    for peak in sorted(peaks, key=lambda p: -p.gain):
        for group in out:
            first = group[0]
            if abs(float(_apart(peak.angle, first.angle))) < WINDOW * max(peak.width, first.width):
                group.append(peak)
                break
        else:
            out.append([peak])
    return out


def fitted(peaks: Sequence[Peak], rows: Rows, chosen: NDArray[np.bool_]) -> list[Peak]:
    """Pulses fitted to ``rows.y`` (less everything else that is known) of the rows ``chosen``."""
    out: list[Peak] = []
    for group in clusters([p for p in peaks if p.kind == "pulse"]):
        out += _one_place(group, rows, chosen)
    return out


def _one_place(group: Sequence[Peak], rows: Rows, chosen: NDArray[np.bool_]) -> list[Peak]:
    first = group[0]
    half = min(WINDOW * max(p.width for p in group), 1.0)
    x = _apart(rows.frame.theta, first.angle)
    near = chosen & (np.abs(x) < half) & (rows.number > 0)
    if near.sum() < 50:
        return list(group)
    number = np.clip(((x[near] + half) / (2.0 * half) * BINS).astype(np.int64), 0, BINS - 1)
    weight = np.bincount(number, rows.number[near], BINS)
    mean = np.bincount(number, rows.y[near] * rows.number[near], BINS) / np.maximum(weight, 1e-9)
    centre = np.bincount(number, x[near] * rows.number[near], BINS) / np.maximum(weight, 1e-9)
    square = np.bincount(number, rows.y[near] ** 2 * rows.number[near], BINS) / np.maximum(weight, 1e-9)
    seen = weight > 0
    count = np.bincount(number, minlength=BINS)[seen]
    scatter = np.sqrt(max(float(np.median((square - mean**2)[seen])), 1e-30))
    centre, mean, error = centre[seen], mean[seen], scatter / np.sqrt(np.maximum(count, 1))
    best: tuple[float, FloatArray] | None = None
    begin = np.zeros(0)
    left = mean - np.median(mean)
    for number_of in range(1, MOST_GAUSSIANS + 1):
        place = int(np.argmax(np.abs(left) / error))
        width = first.width if number_of == 1 else 0.7 * first.width
        begin = np.append(begin, [left[place], centre[place], np.log(width)])
        begin, squares = _least_squares(np.append(begin, 0.0), centre, mean, error, half)
        cost = squares + PENALTY * number_of
        if best is None or cost < best[0]:
            best = (cost, begin)
        left = mean - _shape(np.append(begin, 0.0), centre)
        left = left - np.median(left)
    assert best is not None
    share = sum(p.gain for p in group) / (best[1].size // 3)
    return [
        replace(
            first,
            angle=float(np.mod(first.angle + a, 2.0 * np.pi)),
            width=float(np.exp(w)),
            height=float(h),
            gain=share,
        )
        for h, a, w in best[1].reshape(-1, 3)
    ]


def _shape(parameters: FloatArray, x: FloatArray) -> FloatArray:
    out = np.full(x.size, parameters[-1])
    for height, angle, log_width in parameters[:-1].reshape(-1, 3):
        out += height * np.exp(-0.5 * ((x - angle) / np.exp(log_width)) ** 2)
    return out


def _least_squares(
    begin: FloatArray, x: FloatArray, y: FloatArray, error: FloatArray, half: float
) -> tuple[FloatArray, float]:
    scale = float(np.abs(y).max()) or 1.0
    narrow = np.log(half / 60.0)
    number = begin.size // 3
    lower = np.append(np.tile([-5.0 * scale, -half, narrow], number), -scale)
    upper = np.append(np.tile([5.0 * scale, half, np.log(half / 2.0)], number), scale)
    units = np.append(np.tile([scale, half / 10.0, 0.3], number), scale)

    def misfit(parameters: FloatArray) -> FloatArray:
        return (_shape(parameters, x) - y) / error

    found = least_squares(
        misfit,
        np.clip(begin, lower + 1e-9 * units, upper - 1e-9 * units),
        bounds=(lower, upper),
        x_scale=units,
        max_nfev=60,
    )
    return np.asarray(found.x[:-1]), 2.0 * float(found.cost)
