"""Order spectra of the transmission error: complex amplitudes of known orders and the spectrum of what is left, a
revolution each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import finufft
import numba
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.mismatch.noise import robust_spread
from bench.mismatch.rows import Rows
from bench.simulation.frame import FloatArray, Frame, IntArray

Complex = NDArray[np.complex128]
HIGHEST_ORDER = 1500
LOW_ORDERS = 45
"""orders up to which noise is not taken to be level"""
MIDDLE_ORDERS = 80
"""how many orders above these tell a recording's own level"""
FREQUENCY_BINS, FEWEST_IN_A_BIN = 16, 12
WAVERING = 0.08
"""standard deviation of torque (speed) inside a revolution, of the largest torque (its mean), that still is a state"""
MOST_SQUARES = 10
LEAST_TURN = 0.97 * 2.0 * np.pi


@dataclass(frozen=True, slots=True)
class Turn:
    """One steady segment of at least a revolution.

    ``amplitude[k]`` c_k in TE = Σ Re(c_k·exp(−j·f_k·θ)) + …: c = a + j·b for a·cos + b·sin; ``spectrum[f]`` the same of
    the residual at every integer order f = 0 … HIGHEST_ORDER; ``sigma[f]`` standard deviation of its real and imaginary
    part.
    """

    recording: int
    torque: float
    velocity: float
    temperature: float
    time: float
    direction: float
    amplitude: Complex
    spectrum: Complex
    sigma: FloatArray
    rows: slice
    white: float
    duration: float
    """of the whole revolutions the spectrum is made of, s"""


def states(turns: Sequence[Turn]) -> FloatArray:
    """Torque, velocity and temperature of the turns, (turns, 3)."""
    return np.array([[t.torque, t.velocity, t.temperature] for t in turns]).reshape(len(turns), 3)


def _segments(frame: Frame) -> list[slice]:
    steady = frame.steady > 0.5
    start = np.flatnonzero(steady & (np.append(True, ~steady[:-1]) | np.append(True, np.diff(frame.recording) != 0)))
    out: list[slice] = []
    for a in start:
        stop = int(a)
        own = frame.recording[a]
        ends = np.flatnonzero(~steady[a:] | (frame.recording[a:] != own))
        stop = int(a) + (int(ends[0]) if ends.size else frame.size - int(a))
        if abs(frame.theta[stop - 1] - frame.theta[a]) >= LEAST_TURN:
            out.append(slice(int(a), stop))
    return out


def _rests(values: FloatArray, scale: float) -> bool:
    """Whether a quantity keeps its level through a segment: amplitudes over a ramp are those of no state."""
    return float(np.std(values)) <= WAVERING * max(scale, float(np.abs(values.mean())))


def waves(theta: FloatArray, orders: Sequence[float] | FloatArray) -> FloatArray:
    """cos and sin of the orders, (n, 2·orders): first all cosines, then all sines."""
    out = np.empty((theta.size, 2 * len(orders)))
    _fill(np.ascontiguousarray(theta), np.asarray(orders, dtype=np.float64), out)
    return out


@numba.njit(cache=True)
def _fill(theta: FloatArray, orders: FloatArray, out: FloatArray) -> None:
    """Whole orders are products of exp(j·θ), squared again and again: less than half the work of as many sines."""
    k = orders.size
    power = np.empty(MOST_SQUARES, dtype=np.complex128)
    for i in range(theta.size):
        power[0] = complex(np.cos(theta[i]), np.sin(theta[i]))
        for m in range(1, MOST_SQUARES):
            power[m] = power[m - 1] * power[m - 1]
        for j in range(k):
            left = int(orders[j])
            if left != orders[j] or left < 0 or left >= 1 << MOST_SQUARES:
                out[i, j], out[i, k + j] = np.cos(orders[j] * theta[i]), np.sin(orders[j] * theta[i])
                continue
            value = complex(1.0, 0.0)
            m = 0
            while left:
                if left & 1:
                    value *= power[m]
                left >>= 1
                m += 1
            out[i, j], out[i, k + j] = value.real, value.imag


def _smearing(theta: FloatArray, orders: FloatArray) -> FloatArray:
    """Factor by which averaging over a row's angle lowers the amplitude of an order."""
    width = float(np.median(np.abs(np.diff(theta)))) if theta.size > 1 else 0.0
    return np.asarray(np.sinc(orders * width / (2.0 * np.pi)))


def nufft(theta: FloatArray, values: FloatArray, highest: int) -> Complex:
    """Σ values·exp(j·f·θ) for f = 0 … highest (non-uniform FFT, relative accuracy 1e-9)."""
    full = finufft.nufft1d1(
        np.ascontiguousarray(np.mod(theta, 2.0 * np.pi)),
        np.ascontiguousarray(values.astype(np.complex128)),
        2 * highest + 1,
        eps=1e-9,
        isign=1,
        nthreads=1,
    )
    return np.asarray(full[highest:])


def turns(rows: Rows, orders: Sequence[float]) -> list[Turn]:
    """Amplitudes of ``orders`` and residual spectrum of every steady segment that makes a revolution.

    Offset and a linear trend are fitted beside the orders and taken out.
    """
    frame = rows.frame
    known = np.asarray(orders, dtype=np.float64)
    out: list[Turn] = []
    largest = float(np.percentile(np.abs(frame.torque), 99)) if frame.size else 0.0
    for part in _segments(frame):
        theta = frame.theta[part]
        if not _rests(frame.torque[part], largest) or not _rests(frame.velocity[part], 0.0):
            continue
        keep = rows.number[part] > 0
        weight = np.sqrt(rows.number[part])
        trend = (theta - theta.mean()) / max(np.ptp(theta), 1e-9)
        design = np.empty((theta.size, 2 + 2 * known.size))
        design[:, 0], design[:, 1] = 1.0, trend
        _fill(np.ascontiguousarray(theta), known, design[:, 2:])
        y = rows.y[part]
        chosen = keep
        beta: FloatArray = np.zeros(design.shape[1])
        for _ in range(2):  # twice: rows far off the first fit are left out of the second
            own = np.where(chosen, weight, 0.0)
            lhs = design * own[:, None]
            # normal equations: cosines over a revolution are all but orthogonal
            normal = lhs.T @ lhs
            normal[np.diag_indices_from(normal)] *= 1.0 + 1e-10
            beta = np.asarray(np.linalg.solve(normal, lhs.T @ (y * own)))
            residual = y - design @ beta
            chosen = keep & (np.abs(residual) < 8.0 * robust_spread(residual[keep]))
        k = known.size
        amplitude = (beta[2 : 2 + k] + 1j * beta[2 + k : 2 + 2 * k]) / _smearing(theta, known)
        span = np.floor(abs(theta[-1] - theta[0]) / (2.0 * np.pi) + 0.03) * 2.0 * np.pi
        inside = chosen & (np.abs(theta - theta[0]) <= span)
        spectrum = 2.0 / max(inside.sum(), 1) * nufft(theta[inside], residual[inside], HIGHEST_ORDER)
        spectrum /= np.maximum(_smearing(theta, np.arange(HIGHEST_ORDER + 1.0)), 0.2)
        out.append(
            Turn(
                int(frame.recording[part.start]),
                float(np.mean(frame.torque[part])),
                float(np.mean(frame.velocity[part])),
                float(np.mean(frame.temperature[part])),
                float(np.mean(frame.time[part])),
                float(np.sign(np.mean(frame.velocity[part]))),
                amplitude.astype(np.complex128),
                spectrum,
                _level(spectrum, known),
                part,
                robust_spread(residual[keep]),
                span / max(abs(float(np.mean(frame.velocity[part]))), 1e-9),
            )
        )
    return coloured(out, known)


def coloured(turn_list: list[Turn], known: FloatArray) -> list[Turn]:
    """Raise the noise of low orders to what the recordings show there: disturbances of a rig are not white.

    They have a spectrum over time, not over the angle: power density is pooled over all recordings by frequency f·|v|
    (medians, so that one missing harmonic is not taken for noise), made to fall with frequency, and put beside each
    recording's own level at middle orders.
    """
    if not turn_list:
        return turn_list
    low, middle = np.arange(1, LOW_ORDERS + 1), np.arange(LOW_ORDERS, LOW_ORDERS + MIDDLE_ORDERS)
    free = np.array([f for f in range(1, LOW_ORDERS + MIDDLE_ORDERS) if f not in known])
    hertz = np.array([abs(t.velocity) / (2.0 * np.pi) for t in turn_list])
    density = np.array([np.abs(t.spectrum[free]) ** 2 * t.duration for t in turn_list])
    grid, level = _falling((hertz[:, None] * free[None, :]).ravel(), density.ravel())
    out = []
    for turn, per_order in zip(turn_list, hertz, strict=True):

        def pooled(orders: IntArray, per_order: float = per_order) -> FloatArray:
            return np.asarray(np.exp(np.interp(np.log(orders * per_order), grid, level)))

        shape = pooled(low) / float(np.mean(pooled(middle)))
        sigma = turn.sigma.copy()
        sigma[low] *= np.sqrt(np.maximum(shape, 1.0))
        sigma[0] = sigma[1]
        out.append(replace(turn, sigma=sigma))
    return out


def _falling(frequency: FloatArray, density: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Logarithms of frequency and of power density, the latter never rising (pooled adjacent violators)."""
    edges = np.geomspace(frequency.min(), frequency.max() * 1.0001, FREQUENCY_BINS + 1)
    number = np.digitize(frequency, edges) - 1
    values: list[float] = []
    weights: list[float] = []
    members: list[list[float]] = []
    for b in range(FREQUENCY_BINS):
        own = density[number == b]
        if own.size < FEWEST_IN_A_BIN:
            continue
        # the median of an exponential variable is ln 2 of its mean
        values.append(float(np.log(np.median(own) / np.log(2.0) + 1e-300)))
        weights.append(float(own.size))
        members.append([float(np.log(np.sqrt(edges[b] * edges[b + 1])))])
        while len(values) > 1 and values[-1] > values[-2]:
            total = weights[-1] + weights[-2]
            values[-2] = (values[-1] * weights[-1] + values[-2] * weights[-2]) / total
            weights[-2] = total
            members[-2] += members[-1]
            del values[-1], weights[-1], members[-1]
    grid = [x for group in members for x in group]
    level = [v for v, group in zip(values, members, strict=True) for _ in group]
    return (np.asarray(grid), np.asarray(level)) if grid else (np.zeros(1), np.zeros(1))


def _level(spectrum: Complex, known: FloatArray) -> FloatArray:
    """Standard deviation of one component of the spectrum at each order, from the median of its neighbours."""
    power = np.abs(spectrum) ** 2
    free = power.copy()
    near = known[known < power.size].astype(int)
    free[near] = np.nan
    free[0] = np.nan
    filled = np.where(np.isfinite(free), free, np.nanmedian(free))
    # the median of an exponential variable is ln 2 of its mean
    level = median_filter(filled, 61, mode="nearest") / np.log(2.0)
    level[: LOW_ORDERS + 1] = np.median(filled[LOW_ORDERS : LOW_ORDERS + MIDDLE_ORDERS]) / np.log(2.0)
    return np.asarray(np.sqrt(np.maximum(level, 1e-300) / 2.0))
