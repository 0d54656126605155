"""What the revolutions leave unknown of the series, beside the offset: an error of one coefficient is the same error
in every recording.

A series that steady revolutions calibrated is extrapolated to slow passages and ramps. By its covariance it may be off
there by more than the noise of a row, and its low orders are off alike over half a revolution and in all recordings at
one state, so that their error looks like a function of speed or travel. The few directions of the coefficients that
matter are fitted beside the offset, with the covariance as their prior (marginalised as in Rasmussen and Williams,
Gaussian Processes, 2006, 2.7); what is left is noise of the rows.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.orders.series import Series
from bench.mismatch.regression.noise import ALIKE_RAD
from bench.mismatch.regression.problem import Untold
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.laws import Law, factor
from bench.simulation.waves import kept_by_mean

SURE_OF_PHASE = 0.1
"""variance of an order's phase in rad² up to which its error is linear in the phase: beyond, it is no direction"""
MOST = 24
"""directions that are fitted at most"""
SIGNIFICANT = 1.0
"""variance that a direction adds to the rows, over that of their noise and summed, from which it is fitted"""
LEAST_NOISE = 1e-12
"""rad: simulated recordings may have no noise at all"""

Coefficients = tuple[int, int]
"""direction of the motion and number of an order"""


@dataclass(frozen=True, slots=True)
class Unsure(Untold):
    """Directions of a series' coefficients, ``mixing`` (20, directions) for each direction of motion and order: one
    column each, as large as its standard deviation. ``rate``: samples a second.
    """

    series: Series
    laws: tuple[Law, ...]
    rate: float
    mixing: Mapping[Coefficients, FloatArray]
    words: str = "what the revolutions leave unknown of the harmonic orders"
    equation: str = "TE += sum of dA*sin(f*theta + phi) + A*dphi*cos(f*theta + phi)"

    @property
    def size(self) -> int:
        """Number of directions."""
        return int(next(iter(self.mixing.values())).shape[1])

    def columns(self, frame: Frame) -> FloatArray:
        """Each direction at the rows of a frame (n, directions), rad."""
        out = np.zeros((frame.size, self.size), order="F")
        for key, rows, slopes in _slopes(self.series, self.laws, self.rate, frame, self.mixing):
            out[rows] += slopes @ self.mixing[key]
        return out

    def explained(self, states: FloatArray, direction: FloatArray, span: FloatArray) -> FloatArray:
        """Variance (n,) of the series that the directions hold at ``states`` (n, 3), over all angles and for means over
        angles ``span`` (n,), rad²; nothing of an order whose phase is not known there.
        """
        out = np.zeros(len(states))
        for (side, k), mixing in self.mixing.items():
            rows = np.flatnonzero(direction * side > 0)
            if not rows.size:
                continue
            basis = self.series.scaling[side].monomials(states[rows])
            phase = np.einsum("ni,ij,nj->n", basis, self.series.covariance[side][k, 10:, 10:], basis)
            amplitude = basis @ self.series.amplitude[side][k]
            squares = np.sum((basis @ mixing[:10]) ** 2, axis=1)
            squares += amplitude**2 * np.sum((basis @ mixing[10:]) ** 2, axis=1)
            smear = kept_by_mean(self.series.orders[k], span[rows]) ** 2
            out[rows] += np.where(phase < SURE_OF_PHASE, 0.5 * smear * squares, 0.0)
        return out

    def known(self, coefficients: FloatArray, covariance: FloatArray) -> Series:
        """The series with what a fit says of the directions: their ``coefficients`` (directions,) in standard
        deviations, and ``covariance``.
        """
        series = self.series
        amplitude = {side: values.copy() for side, values in series.amplitude.items()}
        phase = {side: values.copy() for side, values in series.phase.items()}
        of_all = {side: values.copy() for side, values in series.covariance.items()}
        learnt = np.eye(self.size) - covariance
        for (side, k), mixing in self.mixing.items():
            amplitude[side][k] += mixing[:10] @ coefficients
            phase[side][k] += mixing[10:] @ coefficients
            of_all[side][k] -= mixing @ learnt @ mixing.T
        return replace(series, amplitude=amplitude, phase=phase, covariance=of_all)


def unsure(
    series: Series, laws: Sequence[Law], rate: float, frame: Frame, noise: FloatArray, chosen: NDArray[np.bool_]
) -> Unsure | None:
    """The directions that matter at the ``chosen`` rows (n,) of a frame, whose means have a variance ``noise`` (n,);
    None where none does.
    """
    low = [k for k, f in enumerate(series.orders) if f * ALIKE_RAD < 2.0 * np.pi]
    keys = [(side, k) for side in series.amplitude for k in low]
    part = frame.take(np.flatnonzero(chosen))
    spread = np.sqrt(np.maximum(noise[chosen], LEAST_NOISE**2))
    parts: dict[Coefficients, tuple[FloatArray, FloatArray]] = {}
    for key, rows, slopes in _slopes(series, tuple(laws), rate, part, keys):
        side, k = key
        root = _root(series.covariance[side][k])
        seen = np.zeros((part.size, root.shape[1]))
        seen[rows] = (slopes @ root) / spread[rows, None]
        rotation, large = _largest(seen, SIGNIFICANT / max(len(keys), 1))
        if large.size:
            parts[key] = root @ rotation, seen @ rotation
    if not parts:
        return None
    together = np.hstack([columns for _, columns in parts.values()])
    rotation, large = _largest(together, SIGNIFICANT)
    if not large.size:
        return None
    first = 0
    mixing: dict[Coefficients, FloatArray] = {}
    for key, (root, columns) in parts.items():
        mixing[key] = root @ rotation[first : first + columns.shape[1]]
        first += columns.shape[1]
    return Unsure(series, tuple(laws), rate, mixing)


def angle_of_rows(frame: Frame, rate: float) -> FloatArray:
    """Angle (n,) that each row is a mean over, rad; ``rate``: samples a second."""
    return np.asarray(np.abs(frame.velocity) * frame.count / rate)


def _largest(columns: FloatArray, least: float) -> tuple[FloatArray, FloatArray]:
    """Directions (k, m) of columns (n, k) whose squares sum to more than ``least``, the largest :data:`MOST`, and these
    sums (m,).
    """
    values, vectors = np.linalg.eigh(columns.T @ columns)
    keep = np.flatnonzero(values > least)[::-1][:MOST]
    return vectors[:, keep], values[keep]


def _root(covariance: FloatArray) -> FloatArray:
    """R (20, m) with R*R' the covariance, m its rank."""
    spread = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(spread, spread))
    keep = values > 1e-9
    return np.asarray(spread[:, None] * vectors[:, keep] * np.sqrt(values[keep]))


def _slopes(
    series: Series, laws: Sequence[Law], rate: float, frame: Frame, keys: Iterable[Coefficients]
) -> Iterator[tuple[Coefficients, NDArray[np.intp], FloatArray]]:
    """How an order moves the rows' means with its coefficients: place, rows of its direction, slopes (rows, 20)."""
    for side, k in keys:
        rows = np.flatnonzero(frame.last_direction * side > 0)
        if not rows.size:
            continue
        part = frame.take(rows)
        x = part.states
        basis = series.scaling[side].monomials(x)
        order = series.orders[k]
        rotation = np.exp(1j * (order * part.theta + basis @ series.phase[side][k]))
        for law in laws:
            rotation = rotation * factor(law, x, part.time, [order])[:, 0]
        rotation = rotation * kept_by_mean(order, angle_of_rows(part, rate))
        amplitude = basis @ series.amplitude[side][k]
        yield (side, k), rows, np.hstack([basis * rotation.imag[:, None], basis * (amplitude * rotation.real)[:, None]])
