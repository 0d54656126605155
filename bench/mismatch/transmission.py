"""Search of the transmission error: its offset by regression, its harmonics in the order spectrum, the two in turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.amplitudes import Orders, applied, best_law
from bench.mismatch.columns import RIPPLE_ORDERS
from bench.mismatch.dataset import LIVELY_S, SLOW_S
from bench.mismatch.laws import Complex, Law, factor
from bench.mismatch.linear import ChannelModel, analyse, predict
from bench.mismatch.offset import fit_offset, wavering
from bench.mismatch.peaks import Peak, Spectra, design, pulse_spectrum, search
from bench.mismatch.periodic import NOTHING, Periodic, Pulse
from bench.mismatch.prepare import reduce
from bench.mismatch.rows import Rows
from bench.mismatch.series import Series, as_vectors, calibrate, mask, noise_at
from bench.mismatch.spectrum import Turn, states, turns
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.terms import TRANSMISSION_ERROR, Form, Point, Term

WIDEST_SPEED = 1.1
SLOPE_STEP = 3e-4
SLOWEST_SPEED = 0.9
"""the polynomials hold between the campaign's slowest and fastest steady revolution, and a little beyond: not while the
bench starts, stops or turns round
"""


@dataclass(slots=True)
class Harmonics:
    """Everything periodic in the angle: the series, the law its amplitudes follow, peaks, and the turns they were seen
    in.
    """

    series: Series
    plain: Series
    """the series calibrated alone, without law"""
    law: Law | None
    peaks: list[Peak]
    turns: list[Turn]
    orders: Orders | None
    given: Periodic = NOTHING
    """laws of the simulation given (its pulses are taken off the rows before)"""

    def evaluate(self, frame: Frame, whole: bool = True) -> FloatArray:
        """Sum of the harmonics at the rows of a frame, rad; ``whole`` includes what was found."""
        out = self._series(frame, whole)
        if not whole:
            return out
        x = np.column_stack([frame.torque, frame.velocity, frame.temperature])
        for peak in self.peaks:
            out = out + _peak(peak, frame, x, self.series)
        return out

    def slope(self, frame: Frame, whole: bool = True) -> FloatArray:
        """Change of the harmonics with the angle at the rows of a frame, rad/rad."""
        ahead, behind = (replace(frame, theta=frame.theta + step) for step in (SLOPE_STEP, -SLOPE_STEP))
        return (self.evaluate(ahead, whole) - self.evaluate(behind, whole)) / (2.0 * SLOPE_STEP)

    def _series(self, frame: Frame, whole: bool) -> FloatArray:
        series = self.series if whole else self.plain
        law = self.law if whole else None
        if law is None and not self.given.laws:
            return series.evaluate(frame)
        out = np.zeros(frame.size)
        x = np.column_stack([frame.torque, frame.velocity, frame.temperature])
        vectors = series.vectors(x, frame.last_direction) * self.given.factor(x, frame.time, series.orders)
        if law is not None:
            vectors = vectors * factor(law, x, frame.time, series.orders)
        for k, order in enumerate(series.orders):
            angle = order * frame.theta
            out += vectors[:, k].real * np.sin(angle) + vectors[:, k].imag * np.cos(angle)
        return out


def _peak(peak: Peak, frame: Frame, x: FloatArray, series: Series) -> FloatArray:
    if peak.kind == "pulse":
        # the same pulse as in the spectrum: its mean and the orders the simulation has are the simulation's
        return Pulse(peak.angle, peak.width, peak.height).evaluate(frame.theta)
    carrier = None
    if peak.kind == "sideband":
        carrier = series.vectors(x, frame.last_direction)[:, series.orders.index(float(peak.carrier))]
    vectors = design(peak.model, x, frame.last_direction, carrier)
    out = np.zeros(frame.size)
    for order, coefficients in zip(peak.orders, peak.coefficients, strict=True):
        vector = vectors @ coefficients
        out += vector.real * np.sin(order * frame.theta) + vector.imag * np.cos(order * frame.theta)
    return out


@dataclass(slots=True)
class TransmissionModel:
    """The transmission error's model: offset (slow rows) and harmonics (angle rows)."""

    angle: Rows
    inside: NDArray[np.bool_]
    """angle rows within the bounds in which the polynomials hold"""
    offset: ChannelModel
    harmonics: Harmonics | None
    slow_inside: NDArray[np.bool_]
    """blocks of the offset's rows within the bounds"""

    def predict(self, frame: Frame, whole: bool = True, rows: NDArray[np.bool_] | None = None) -> FloatArray:
        """Transmission error at the rows of a frame (those marked), rad; memories run through all of them."""
        out = predict(self.offset, frame, whole)
        chosen = frame if rows is None else frame.take(rows)
        out = out if rows is None else out[rows]
        return out + self.harmonics.evaluate(chosen, whole) if self.harmonics is not None else out


def slow_rows(rows: Rows, y: FloatArray, inside: NDArray[np.bool_]) -> tuple[Rows, NDArray[np.bool_]]:
    """Average angle rows over a quarter of a second (finer just after a reversal); and which blocks lie ``inside``."""
    frame = rows.frame
    lively = (frame.reversal_time < 1.5) & (frame.reversal_travel < 0.05)
    width = np.where(lively, LIVELY_S, SLOW_S)
    number = np.floor(np.cumsum(frame.step / width))
    change = np.diff(number) != 0
    change |= np.diff(frame.recording) != 0
    change |= np.diff(frame.steady) != 0
    change |= np.diff(frame.direction) != 0
    change |= np.diff(inside) != 0
    edges = np.concatenate(([0], np.flatnonzero(change) + 1)).astype(np.int64)
    weight = rows.number
    total = np.add.reduceat(weight, edges)
    mean = np.add.reduceat(y * weight, edges) / np.maximum(total, 1.0)
    width_rows = np.diff(np.append(edges, y.size))
    within = np.maximum(np.add.reduceat(y**2 * weight, edges) / np.maximum(total, 1.0) - mean**2, 0.0) * total
    return Rows(reduce(frame, edges), mean, total, within / np.maximum(width_rows - 1, 1)), inside[edges]


def analyse_transmission(
    angle: Rows,
    fold_of: IntArray,
    orders: Sequence[float],
    switched_off: Sequence[str] = (),
    known: Sequence[tuple[Term, Form, Point]] = (),
    given: Periodic = NOTHING,
) -> TransmissionModel:
    """Find what the transmission error's simulation lacks, on the training recordings (fold ≥ 0).

    ``known`` terms of the offset, pulses and laws in ``given`` are the simulation's own.
    """
    # the load motor's ripple twists the gearbox, too: orders like the series', known to any simulation
    orders = [*orders, *RIPPLE_ORDERS]
    train = {int(r) for r in np.flatnonzero(fold_of >= 0)}
    angle = replace(angle, y=angle.y - given.pulses_at(angle.frame))
    inside = _within_bounds(angle, orders)
    rows = angle.take(inside)
    first = turns(rows, orders)
    harmonics: Harmonics | None = None
    if sum(t.recording in train for t in first) >= 4:
        offset0 = fit_offset(rows.frame, rows.y, first, train)
        quiet = replace(rows, y=rows.y - wavering(rows.frame, offset0))
        harmonics = _calibrated(quiet, orders, train, given)
    for step in range(2):
        periodic = harmonics.evaluate(angle.frame) if harmonics is not None else np.zeros(angle.y.size)
        slow, usable = slow_rows(angle, angle.y - periodic, inside)
        offset = analyse(TRANSMISSION_ERROR, slow, usable, fold_of, switched_off, known)
        if harmonics is None:
            break
        if step == 0:
            offset_only = replace(rows, y=rows.y - predict(offset, angle.frame)[inside])
            harmonics = _searched(offset_only, orders, train, given)
            if harmonics.law is None and not harmonics.peaks and not offset.found:
                break
    return TransmissionModel(angle, inside, offset, harmonics, usable)


def _within_bounds(angle: Rows, orders: Sequence[float]) -> NDArray[np.bool_]:
    """Rows whose speed lies within that of the steady revolutions (all that move, where there is none)."""
    speed = np.abs(angle.frame.velocity)
    good = angle.number > 0
    driven = [abs(t.velocity) for t in turns(angle.take(good), orders)]
    if not driven:
        return np.asarray(good & (angle.frame.direction != 0))
    return np.asarray(good & (speed > SLOWEST_SPEED * min(driven)) & (speed < WIDEST_SPEED * max(driven)))


def _vectors(seen: Sequence[Turn], orders: Sequence[float], given: Periodic) -> tuple[Complex, Complex]:
    """Vectors of the turns at the orders, what the given laws do to them divided out; and that factor."""
    time = np.array([t.time for t in seen])
    factor_given = given.factor(states(seen), time, orders)
    return as_vectors(seen) / factor_given, factor_given


def _calibrated(quiet: Rows, orders: Sequence[float], train: set[int], given: Periodic) -> Harmonics:
    seen = turns(quiet, orders)
    chosen = mask(seen, train)
    vectors, touched = _vectors(seen, orders, given)
    noise = noise_at(seen, orders)[chosen] / np.abs(touched[chosen])
    series = calibrate([t for t, k in zip(seen, chosen, strict=True) if k], vectors[chosen], orders, noise)
    return Harmonics(series, series, None, [], seen, None, given)


def _searched(quiet: Rows, orders: Sequence[float], train: set[int], given: Periodic) -> Harmonics:
    """Calibrate the series on rows without their offset; then its laws, then peaks in what is left."""
    plain = _calibrated(quiet, orders, train, given)
    seen, series = plain.turns, plain.series
    chosen = mask(seen, train)
    x, direction = states(seen), np.array([t.direction for t in seen])
    smooth = series.vectors(x, direction)
    left = turns(replace(quiet, y=quiet.y - plain.evaluate(quiet.frame)), orders)
    vectors, known = _vectors(seen, orders, given)
    data = Orders(
        vectors,
        noise_at(left, orders) / np.abs(known),
        x,
        direction,
        np.array([t.time for t in seen]),
        tuple(float(f) for f in orders),
        chosen,
        series,
        smooth,
        float(np.median([t.white for t in left])),
        tuple(left),
    )
    law = best_law(data)
    out = Harmonics(series, series, law, [], seen, data, given)
    if law is not None:
        touched = applied(law, data)
        tidy = calibrate(
            [t for t, k in zip(seen, chosen, strict=True) if k],
            vectors[chosen] / touched[chosen],
            orders,
            data.sigma[chosen] / np.abs(touched[chosen]),
        )
        out = Harmonics(tidy, series, law, [], seen, data, given)
        left = turns(replace(quiet, y=quiet.y - out.evaluate(quiet.frame)), orders)
    carriers = {int(f): out.series.vectors(x, direction)[:, k] for k, f in enumerate(orders)}
    spectra = Spectra.of(left, chosen, orders, carriers)
    out.peaks = search(spectra)
    return out


__all__ = ["Harmonics", "TransmissionModel", "analyse_transmission", "pulse_spectrum"]
