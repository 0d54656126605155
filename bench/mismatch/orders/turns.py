"""Steady revolutions: complex amplitudes of orders in each, by least squares, and the spectrum of what is left.

y(theta) = b_0 + b_1*s + sum of a_f*cos(f*theta) + b_f*sin(f*theta) is fitted to all rows of a steady segment at once,
s a line through it. For whole orders the normal equations are sums of exp(j*f*theta) at sums and differences of the
orders, which one non-uniform FFT gives; so a hundred orders cost little more than one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import finufft
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.mismatch import criteria
from bench.mismatch.recordings.notch import spectrum
from bench.mismatch.recordings.rows import ANGLE_STEP, Rows
from bench.mismatch.regression.noise import Mixture, fitted, robust_spread
from bench.simulation.frame import FloatArray, Frame

Complex = NDArray[np.complex128]

HIGHEST_ORDER = 1500
PARTS = 12
"""of an order: halves, thirds, quarters and sixths stand between the whole ones where ratios are no whole numbers"""
HIGHEST_BETWEEN = 600
"""order up to which such are looked for"""
LEAST_TURN = 0.97 * 2.0 * np.pi
"""rad: a segment that falls short of a revolution by a smoothing window still counts"""
LEAST_PART = 0.1 * 2.0 * np.pi
"""rad: a steady segment that turns less says next to nothing of most orders"""
_NEIGHBOURS = 61
"""orders whose median tells the noise at an order"""
_LOW = 45
"""orders up to which noise is not taken to be level"""
_MIDDLE = 80
"""how many orders above these tell a recording's own level"""
_BINS = 16
"""of frequency, in which the recordings' spectra are pooled"""
_FEWEST = 12
"""values of a bin"""
_FEWEST_ALIKE = 4
"""revolutions of a direction from which their mean is taken off"""


@dataclass(frozen=True, slots=True)
class Turn:
    """One steady segment of at least a revolution: its rows, the mean state, when, which way."""

    recording: int
    rows: slice
    torque: float
    velocity: float
    temperature: float
    time: float
    direction: float
    revolutions: float
    duration: float


@dataclass(frozen=True, slots=True)
class Seen:
    """What the turns show: ``vectors`` (turns, orders) b + j*a of the fitted ``orders``; ``left`` (turns,
    HIGHEST_ORDER + 1) the same of the residual at every whole order; ``sigma`` standard deviation of each component
    there; ``white`` (turns,) of a row; ``between`` (turns, HIGHEST_BETWEEN*PARTS + 1) the residual at parts of an
    order.
    """

    orders: tuple[float, ...]
    vectors: Complex
    left: Complex
    sigma: FloatArray
    white: FloatArray
    between: Complex

    def noise(self, orders: Sequence[float]) -> FloatArray:
        """Standard deviation of a component at some orders (turns, k)."""
        place = [int(min(round(f), self.sigma.shape[1] - 1)) for f in orders]
        return self.sigma[:, place]


def states(turns: Sequence[Turn]) -> FloatArray:
    """Torque, velocity and temperature of the turns (turns, 3)."""
    return np.array([[t.torque, t.velocity, t.temperature] for t in turns]).reshape(len(turns), 3)


def directions(turns: Sequence[Turn]) -> FloatArray:
    """Direction of motion of the turns (turns,)."""
    return np.array([t.direction for t in turns])


def found_in(frame: Frame, least: float = LEAST_TURN, most: float = np.inf) -> list[Turn]:
    """Steady segments in which load and speed keep their level, of at least ``least`` and less than ``most`` rad."""
    steady = frame.steady > 0.5
    begins = np.append(True, ~steady[:-1]) | np.append(True, np.diff(frame.recording) != 0)
    start = np.flatnonzero(steady & begins)
    ends = np.flatnonzero(np.append(~steady[1:], True) | np.append(np.diff(frame.recording) != 0, True))
    largest = float(np.percentile(np.abs(frame.torque), 99)) if frame.size else 0.0
    out = []
    for a in start:
        b = int(ends[np.searchsorted(ends, a)]) + 1
        rows = slice(int(a), b)
        angle = abs(float(frame.theta[b - 1] - frame.theta[a]))
        if not least <= angle < most or b - int(a) < 50:
            continue
        if not _rests(frame.torque[rows], largest) or not _rests(frame.velocity[rows], 0.0):
            continue
        velocity = float(np.mean(frame.velocity[rows]))
        out.append(
            Turn(
                int(frame.recording[a]),
                rows,
                float(np.mean(frame.torque[rows])),
                velocity,
                float(np.mean(frame.temperature[rows])),
                float(np.mean(frame.time[rows])),
                float(np.sign(velocity)),
                max(np.floor(angle / (2.0 * np.pi) + 0.03), 1.0),
                angle / max(abs(velocity), 1e-12),
            )
        )
    return out


def _rests(values: FloatArray, scale: float) -> bool:
    """Whether a quantity keeps its level through a segment: amplitudes over a ramp are those of no state."""
    return float(np.std(values)) <= criteria.WAVERING * max(scale, float(np.abs(values.mean())))


def seen(rows: Rows, turns: Sequence[Turn], y: FloatArray, orders: Sequence[float]) -> Seen:
    """Fit ``orders`` to ``y`` (n,) in each turn; the residual's spectrum and its noise."""
    own = tuple(float(f) for f in orders)
    vectors = np.zeros((len(turns), len(own)), dtype=np.complex128)
    left = np.zeros((len(turns), HIGHEST_ORDER + 1), dtype=np.complex128)
    between = np.zeros((len(turns), HIGHEST_BETWEEN * PARTS + 1), dtype=np.complex128)
    white = np.zeros(len(turns))
    for k, turn in enumerate(turns):
        vectors[k], left[k], between[k], white[k] = _one(rows, turn, y, own)
    scatter = scattered(left, turns)
    sigma = _levels(scatter, own)
    return Seen(own, vectors, left, _coloured(scatter, sigma, turns, own), white, between)


def scattered(left: Complex, turns: Sequence[Turn]) -> Complex:
    """Revolutions against each other: spectra (turns, orders) less their mean in the same direction, as large as noise
    alone would be.

    A pulse stands in every order of every revolution, alike; the median over orders would take it for noise.
    """
    out = left.copy()
    direction = directions(turns)
    for side in (1.0, -1.0):
        own = direction == side
        number = int(own.sum())
        if number >= _FEWEST_ALIKE:
            out[own] = (left[own] - left[own].mean(axis=0)) * np.sqrt(number / (number - 1.0))
    return out


def _one(rows: Rows, turn: Turn, y: FloatArray, orders: tuple[float, ...]) -> tuple[Complex, Complex, Complex, float]:
    theta = rows.frame.theta[turn.rows]
    number = rows.number[turn.rows]
    values = y[turn.rows]
    line = (theta - theta.mean()) / max(float(np.ptp(theta)), 1e-9)
    weight = number / max(float(number.max()), 1.0)
    known = np.asarray(orders)
    beta = _fit(theta, line, values, weight, known)
    residual = values - _sum(theta, line, beta, known)
    spread = robust_spread(residual[number > 0])
    # a wild row stands alone: a pulse of the gearbox is as large in its neighbours
    far = np.abs(residual - median_filter(residual, 5, mode="nearest")) > criteria.SPIKE * spread
    if far[number > 0].any():  # rows far off the first fit are left out of a second
        weight = np.where(far, 0.0, weight)
        beta = _fit(theta, line, values, weight, known)
        residual = values - _sum(theta, line, beta, known)
    smear = np.sinc(known * ANGLE_STEP / (2.0 * np.pi))
    k = known.size
    vectors = (beta[2 + k :] + 1j * beta[2 : 2 + k]) / smear
    whole = (np.abs(theta - theta[0]) <= turn.revolutions * 2.0 * np.pi) & (weight > 0.0)
    total = max(float(weight[whole].sum()), 1e-12)
    values = residual[whole] * weight[whole]
    rest = 2.0 / total * spectrum(theta[whole], values, HIGHEST_ORDER)
    rest /= np.maximum(np.sinc(np.arange(HIGHEST_ORDER + 1.0) * ANGLE_STEP / (2.0 * np.pi)), 0.2)
    parts = 2.0 / total * spectrum(theta[whole] / PARTS, values, HIGHEST_BETWEEN * PARTS)
    return np.asarray(vectors, dtype=np.complex128), 1j * np.conj(rest), 1j * np.conj(parts), spread


def _fit(theta: FloatArray, line: FloatArray, y: FloatArray, weight: FloatArray, orders: FloatArray) -> FloatArray:
    """Coefficients: constant, line, cosines, sines."""
    parts = _parts(orders)
    if parts and float(orders.max()) <= HIGHEST_ORDER:
        normal, right = _by_fft(theta / parts, line, y, weight, np.round(orders * parts).astype(np.int64))
    else:
        design = np.column_stack([np.ones(theta.size), line, *(np.cos(f * theta) for f in orders)])
        design = np.column_stack([design, *(np.sin(f * theta) for f in orders)])
        weighted = design * weight[:, None]
        normal, right = weighted.T @ design, weighted.T @ y
    normal[np.diag_indices_from(normal)] *= 1.0 + 1e-10
    return np.asarray(np.linalg.solve(normal, right))


def _parts(orders: FloatArray) -> int:
    """1 where all orders are whole, PARTS where they are whole numbers of such parts, else 0."""
    if not orders.size:
        return 0
    for parts in (1, PARTS):
        if np.all(np.abs(orders * parts - np.round(orders * parts)) < 1e-9):
            return parts
    return 0


def _by_fft(
    theta: FloatArray, line: FloatArray, y: FloatArray, weight: FloatArray, orders: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    highest = int(orders.max())
    w = spectrum(theta, weight, 2 * highest)
    ws, wy = spectrum(theta, weight * line, highest), spectrum(theta, weight * y, highest)
    k = orders.size
    difference, total = orders[:, None] - orders[None, :], orders[:, None] + orders[None, :]
    c_minus, s_minus = w.real[np.abs(difference)], np.sign(difference) * w.imag[np.abs(difference)]
    c_plus, s_plus = w.real[total], w.imag[total]
    normal = np.empty((2 * k + 2, 2 * k + 2))
    normal[2 : 2 + k, 2 : 2 + k] = 0.5 * (c_minus + c_plus)
    normal[2 + k :, 2 + k :] = 0.5 * (c_minus - c_plus)
    # cos(f)*sin(g) = (sin(g + f) + sin(g - f))/2
    normal[2 : 2 + k, 2 + k :] = 0.5 * (s_plus - s_minus)
    normal[2 + k :, 2 : 2 + k] = normal[2 : 2 + k, 2 + k :].T
    normal[0, 0], normal[0, 1], normal[1, 1] = w[0].real, ws[0].real, float(np.sum(weight * line**2))
    normal[1, 0] = normal[0, 1]
    normal[0, 2:] = np.concatenate([w.real[orders], w.imag[orders]])
    normal[1, 2:] = np.concatenate([ws.real[orders], ws.imag[orders]])
    normal[2:, 0], normal[2:, 1] = normal[0, 2:], normal[1, 2:]
    right = np.concatenate([[wy[0].real, float(np.sum(weight * line * y))], wy.real[orders], wy.imag[orders]])
    return normal, right


def _sum(theta: FloatArray, line: FloatArray, beta: FloatArray, orders: FloatArray) -> FloatArray:
    """The fitted waves at the rows."""
    k = orders.size
    out = np.asarray(beta[0] + beta[1] * line)
    if not k:
        return out
    parts = _parts(orders)
    if parts:
        whole = np.round(orders * parts).astype(np.int64)
        highest = int(whole.max())
        modes = np.zeros(2 * highest + 1, dtype=np.complex128)
        # a*cos + b*sin = Re((a - j*b)*exp(j*f*theta))
        modes[highest + whole] = beta[2 : 2 + k] - 1j * beta[2 + k :]
        angle = np.ascontiguousarray(np.mod(theta / parts, 2.0 * np.pi))
        wave = finufft.nufft1d2(angle, modes, eps=1e-9, isign=1, nthreads=1)
        return np.asarray(out + np.real(wave))
    for a, b, f in zip(beta[2 : 2 + k], beta[2 + k :], orders, strict=True):
        out = out + a * np.cos(f * theta) + b * np.sin(f * theta)
    return np.asarray(out)


def _levels(left: Complex, orders: Sequence[float]) -> FloatArray:
    """Standard deviation of a component at each order (turns, orders), from the median of the orders about it that are
    not fitted.
    """
    fitted = {0, *(round(f) for f in orders)}
    free = np.array([f for f in range(left.shape[1]) if f not in fitted], dtype=np.int64)
    power = np.abs(left[:, free]) ** 2
    # the median of an exponential variable is ln 2 of its mean
    level = median_filter(power, (1, _NEIGHBOURS), mode="nearest") / np.log(2.0)
    middle = (free >= _LOW) & (free < _LOW + _MIDDLE)
    if middle.any():
        level[:, free <= _LOW] = np.median(power[:, middle], axis=1, keepdims=True) / np.log(2.0)
    every = np.arange(left.shape[1])
    level = np.stack([np.interp(every, free, own) for own in level]) if len(level) else np.zeros(left.shape)
    return np.asarray(np.sqrt(np.maximum(level, 1e-300) / 2.0))


def _coloured(left: Complex, sigma: FloatArray, turns: Sequence[Turn], orders: Sequence[float]) -> FloatArray:
    """Noise with that of low orders raised to what the recordings show there: disturbances of a rig are not white.

    They have a spectrum over time, not over the angle: power density is pooled over all recordings by frequency f*|v|
    (medians, so that one missing order is not taken for noise); noise with a memory, which says as well what is below
    the lowest order that is not fitted, is put beside each recording's own level at middle orders.
    """
    if len(turns) < 3:
        return sigma
    known = {round(f) for f in orders}
    low, middle = np.arange(1, _LOW + 1), np.arange(_LOW, _LOW + _MIDDLE)
    free = np.array([f for f in range(1, _LOW + _MIDDLE) if f not in known])
    if not free.size:
        return sigma
    hertz = np.array([abs(t.velocity) / (2.0 * np.pi) for t in turns])
    duration = np.array([t.revolutions for t in turns]) / hertz
    # a component of the spectrum is noise of density P over the time T: |R|^2 = 2*P/T
    density = 0.5 * np.abs(left[:, free]) ** 2 * duration[:, None]
    pooled = _pooled((hertz[:, None] * free[None, :]).ravel(), density.ravel())
    out = sigma.copy()
    for k, per_order in enumerate(hertz):
        raised = pooled.density(low * per_order) / float(np.mean(pooled.density(middle * per_order)))
        out[k, low] *= np.sqrt(np.maximum(raised, 1.0))
        out[k, 0] = out[k, 1]
    return out


def _pooled(frequency: FloatArray, density: FloatArray) -> Mixture:
    """Noise whose spectrum comes nearest to the medians of ``density`` (n,) over ``frequency`` (n,) Hz."""
    edges = np.geomspace(frequency.min(), frequency.max() * 1.0001, _BINS + 1)
    number = np.digitize(frequency, edges) - 1
    own = [(b, density[number == b]) for b in range(_BINS)]
    kept = [(b, values) for b, values in own if values.size >= _FEWEST] or [(0, density)]
    centre = np.array([np.sqrt(edges[b] * edges[b + 1]) for b, _ in kept])
    level = np.array([np.median(values) / np.log(2.0) for _, values in kept])
    return fitted(centre, np.maximum(level, 1e-300), 1.0)
