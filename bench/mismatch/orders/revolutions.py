"""Steady revolutions: complex amplitudes of orders in each (:mod:`bench.mismatch.orders.look`), the spectrum of what is
left, and its noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.mismatch import criteria
from bench.mismatch.orders.look import HIGHEST_ORDER, PARTS, Look, Rest
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.noise import Mixture, fitted
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.laws import Law, factor

Complex = NDArray[np.complex128]

HIGHEST_BETWEEN = 600
"""order up to which such are looked for"""
SHORTEST_REVOLUTION = 0.97 * 2.0 * np.pi
"""rad: a segment that falls short of a revolution by a smoothing window still counts"""
LEAST_PART = 0.05 * 2.0 * np.pi
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
class Revolution:
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
    """What the revolutions show: ``vectors`` (revolutions, orders) b + j*a of the fitted ``orders``; ``left``
    (revolutions, HIGHEST_ORDER + 1) the same of the residual at every whole order; ``sigma`` standard deviation of each
    component there; ``white`` (revolutions,) of a row; ``rest`` (revolutions,) the residual itself.
    """

    orders: tuple[float, ...]
    vectors: Complex
    left: Complex
    sigma: FloatArray
    white: FloatArray
    rest: tuple[Rest, ...]

    def between(self) -> Complex:
        """Vectors of the residual at parts of an order (revolutions, HIGHEST_BETWEEN*PARTS + 1)."""
        power = np.array([rest.between(HIGHEST_BETWEEN * PARTS) for rest in self.rest])
        return np.asarray(power.reshape(len(self.rest), HIGHEST_BETWEEN * PARTS + 1))

    def noise(self, orders: Sequence[float]) -> FloatArray:
        """Standard deviation of a component at some orders (revolutions, k)."""
        columns = [int(min(round(f), self.sigma.shape[1] - 1)) for f in orders]
        return self.sigma[:, columns]


def looks(rows: Rows, revolutions: Sequence[Revolution]) -> tuple[Look, ...]:
    """The revolutions' rows, to be looked at for orders."""
    return tuple(
        Look(rows.frame.theta[t.rows], rows.number[t.rows], t.rows, t.revolutions * 2.0 * np.pi) for t in revolutions
    )


def states(revolutions: Sequence[Revolution]) -> FloatArray:
    """Torque, velocity and temperature of the revolutions (revolutions, 3)."""
    return np.array([[t.torque, t.velocity, t.temperature] for t in revolutions]).reshape(len(revolutions), 3)


def states_of(values: FloatArray, apart: float) -> int:
    """How many of some values (n,) can be chosen so that each two are more than ``apart``: a sweep through many speeds
    has no gap between two, and has many.
    """
    number, last = 0, -np.inf
    for value in np.sort(values):
        if value - last > apart:
            number, last = number + 1, float(value)
    return number


def passed(laws: Sequence[Law], revolutions: Sequence[Revolution], orders: Sequence[float]) -> Complex:
    """What some laws together multiply the vectors of ``orders`` by in the revolutions (revolutions, k)."""
    out = np.ones((len(revolutions), len(orders)), dtype=np.complex128)
    time = np.array([t.time for t in revolutions])
    for law in laws:
        out *= factor(law, states(revolutions), time, orders)
    return out


def directions(revolutions: Sequence[Revolution]) -> FloatArray:
    """Direction of motion of the revolutions (revolutions,)."""
    return np.array([t.direction for t in revolutions])


def found_in(frame: Frame, least: float = SHORTEST_REVOLUTION, most: float = np.inf) -> list[Revolution]:
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
            Revolution(
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


def seen(looks: Sequence[Look], revolutions: Sequence[Revolution], y: FloatArray, orders: Sequence[float]) -> Seen:
    """Fit ``orders`` to ``y`` (n,) in each revolution; the residual's spectrum and its noise."""
    fitted = tuple(float(f) for f in orders)
    shown = [look.fitted(y, np.asarray(fitted)) for look in looks]
    vectors = np.array([one.vectors for one in shown]).reshape(len(revolutions), len(fitted))
    left = np.array([one.left for one in shown]).reshape(len(revolutions), HIGHEST_ORDER + 1)
    scatter = scattered(left, revolutions)
    sigma = _levels(scatter, fitted)
    noise = _coloured(scatter, sigma, revolutions, fitted)
    return Seen(fitted, vectors, left, noise, np.array([one.white for one in shown]), tuple(one.rest for one in shown))


def scattered(left: Complex, revolutions: Sequence[Revolution]) -> Complex:
    """Revolutions against each other: spectra (revolutions, orders) less their mean in the same direction, as large as
    noise alone would be.

    A pulse stands in every order of every revolution, alike; the median over orders would take it for noise.
    """
    out = left.copy()
    direction = directions(revolutions)
    for side in (1.0, -1.0):
        on_side = direction == side
        number = int(on_side.sum())
        if number >= _FEWEST_ALIKE:
            out[on_side] = (left[on_side] - left[on_side].mean(axis=0)) * np.sqrt(number / (number - 1.0))
    return out


def _levels(left: Complex, orders: Sequence[float]) -> FloatArray:
    """Standard deviation of a component at each order (revolutions, orders), from the median of the orders about it
    that are not fitted.
    """
    fitted = {0, *(round(f) for f in orders)}
    free = np.array([f for f in range(left.shape[1]) if f not in fitted], dtype=np.int64)
    power = np.abs(left[:, free]) ** 2
    # the median of an exponential variable is ln 2 of its mean
    # row by row: of one dimension it is ten times as quick
    level = np.array([median_filter(line, _NEIGHBOURS, mode="mirror") for line in power]).reshape(power.shape)
    level /= np.log(2.0)
    middle = (free >= _LOW) & (free < _LOW + _MIDDLE)
    if middle.any():
        level[:, free <= _LOW] = np.median(power[:, middle], axis=1, keepdims=True) / np.log(2.0)
    every = np.arange(left.shape[1])
    level = np.stack([np.interp(every, free, line) for line in level]) if len(level) else np.zeros(left.shape)
    return np.asarray(np.sqrt(np.maximum(level, 1e-300) / 2.0))


def _coloured(
    left: Complex, sigma: FloatArray, revolutions: Sequence[Revolution], orders: Sequence[float]
) -> FloatArray:
    """Noise with that of low orders raised to what the recordings show there: disturbances of a rig are not white.

    They have a spectrum over time, not over the angle: power density is pooled over all recordings by frequency f*|v|
    (medians, so that one missing order is not taken for noise); noise with a memory, which says as well what is below
    the lowest order that is not fitted, is put beside each recording's own level at middle orders.
    """
    if len(revolutions) < 3:
        return sigma
    known = {round(f) for f in orders}
    low, middle = np.arange(1, _LOW + 1), np.arange(_LOW, _LOW + _MIDDLE)
    free = np.array([f for f in range(1, _LOW + _MIDDLE) if f not in known])
    if not free.size:
        return sigma
    hertz = np.array([abs(t.velocity) / (2.0 * np.pi) for t in revolutions])
    duration = np.array([t.revolutions for t in revolutions]) / hertz
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
    binned = [(b, density[number == b]) for b in range(_BINS)]
    kept = [(b, values) for b, values in binned if values.size >= _FEWEST] or [(0, density)]
    centre = np.array([np.sqrt(edges[b] * edges[b + 1]) for b, _ in kept])
    level = np.array([np.median(values) / np.log(2.0) for _, values in kept])
    return fitted(centre, np.maximum(level, 1e-300), 1.0)
