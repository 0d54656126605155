"""Everything in the transmission error that is periodic in the angle: the series, laws of its amplitudes, new orders,
pulses; and the search for them.

A new order, once found, stands in the series like the known ones: its amplitude and phase may follow torque, speed and
temperature as far as the recordings' evidence says. Search and calibration go in turns, for what is not known yet leaks
into its neighbours' amplitudes wherever a segment is not a whole number of revolutions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.amplitudes import Orders, best_law
from bench.mismatch.peaks import Peak, Spectra, search
from bench.mismatch.periodic import NOTHING, Periodic
from bench.mismatch.pulses import at as pulses_at
from bench.mismatch.pulses import fitted
from bench.mismatch.rows import Rows
from bench.mismatch.series import ROWS_AT_ONCE, Series, as_vectors, calibrate, mask, noise_at
from bench.mismatch.spectrum import Turn, states, turns
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.laws import Complex, Law, factor

SLOPE_STEP = 3e-4
ROUNDS = 4


@dataclass(slots=True)
class Harmonics:
    """Everything periodic in the angle: the series, the law its amplitudes follow, peaks, and the turns they were seen
    in.
    """

    series: Series
    """with the orders found, under the law"""
    plain: Series
    """the given orders alone, without law"""
    lawless: Series
    """with the orders found, without law"""
    law: Law | None
    peaks: list[Peak]
    turns: list[Turn]
    given: Periodic = NOTHING
    """laws of the simulation given (its pulses are taken off the rows before)"""

    def evaluate(self, frame: Frame, whole: bool = True) -> FloatArray:
        """Sum of the harmonics at the rows of a frame, rad; ``whole`` includes what was found."""
        if not whole:
            return self._series(self.plain, None, frame)
        return self._series(self.series, self.law, frame) + pulses_at(self.peaks, frame.theta)

    def slope(self, frame: Frame, whole: bool = True) -> FloatArray:
        """Change of the harmonics with the angle at the rows of a frame, rad/rad."""
        if not self.given.laws and (self.law is None or not whole):
            out = (self.series if whole else self.plain).slope(frame, SLOPE_STEP)
            if whole and any(p.kind == "pulse" for p in self.peaks):
                ends = [pulses_at(self.peaks, frame.theta + step) for step in (SLOPE_STEP, -SLOPE_STEP)]
                out += (ends[0] - ends[1]) / (2.0 * SLOPE_STEP)
            return out
        ahead, behind = (replace(frame, theta=frame.theta + step) for step in (SLOPE_STEP, -SLOPE_STEP))
        return (self.evaluate(ahead, whole) - self.evaluate(behind, whole)) / (2.0 * SLOPE_STEP)

    def without_law(self) -> Harmonics:
        """The same, the law taken back."""
        return replace(self, series=self.lawless, law=None)

    def without(self, peaks: Sequence[Peak]) -> Harmonics:
        """The same, some peaks taken back; the others stay as they are."""
        kept = [p for p in self.peaks if p not in peaks]
        gone = {float(f) for p in peaks for f in p.orders} - {float(f) for p in kept for f in p.orders}
        gone -= set(self.plain.orders)
        return replace(self, series=self.series.less(gone), lawless=self.lawless.less(gone), peaks=kept)

    def _series(self, series: Series, law: Law | None, frame: Frame) -> FloatArray:
        if law is None and not self.given.laws:
            return series.evaluate(frame)
        out = np.zeros(frame.size)
        # some rows at a time: a complex number for each row and order of a long campaign fills gigabytes
        for a in range(0, frame.size, ROWS_AT_ONCE):
            own = slice(a, a + ROWS_AT_ONCE)
            x = np.column_stack([frame.torque[own], frame.velocity[own], frame.temperature[own]])
            vectors = series.vectors(x, frame.last_direction[own])
            vectors *= self.given.factor(x, frame.time[own], series.orders)
            if law is not None:
                vectors *= factor(law, x, frame.time[own], series.orders)
            for k, order in enumerate(series.orders):
                angle = order * frame.theta[own]
                out[own] += vectors[:, k].real * np.sin(angle) + vectors[:, k].imag * np.cos(angle)
        return out


@dataclass(frozen=True, slots=True)
class _Seen:
    """The turns of some rows, their vectors at the orders with the given laws divided out, and who trains."""

    turns: list[Turn]
    vectors: Complex
    touched: Complex
    chosen: NDArray[np.bool_]

    @classmethod
    def of(cls, rows: Rows, orders: Sequence[float], train: set[int], given: Periodic) -> _Seen:
        seen = turns(rows, orders)
        time = np.array([t.time for t in seen])
        touched = given.factor(states(seen), time, orders)
        return cls(seen, as_vectors(seen) / touched, touched, mask(seen, train))

    def series(self, orders: Sequence[float], law: Complex | None = None) -> Series:
        touched = self.touched if law is None else self.touched * law
        vectors = self.vectors if law is None else self.vectors / law
        own = [t for t, k in zip(self.turns, self.chosen, strict=True) if k]
        noise = noise_at(self.turns, orders)[self.chosen] / np.abs(touched[self.chosen])
        return calibrate(own, vectors[self.chosen], orders, noise)


def calibrated(rows: Rows, orders: Sequence[float], train: set[int], given: Periodic) -> Harmonics:
    """The series alone, calibrated on the training recordings."""
    seen = _Seen.of(rows, orders, train, given)
    series = seen.series(orders)
    return Harmonics(series, series, series, None, [], seen.turns, given)


def searched(rows: Rows, orders: Sequence[float], train: set[int], given: Periodic) -> Harmonics:
    """Calibrate the series on rows without their offset; search laws and peaks; and again with what was found."""
    out = calibrated(rows, orders, train, given)
    training = np.isin(rows.frame.recording, list(train)) & (rows.frame.steady > 0.5)
    plain = out.series
    for number in range(ROUNDS):
        known = [*orders, *(f for f in _new_orders(out.peaks) if f not in orders)]
        bare = replace(rows, y=rows.y - pulses_at(out.peaks, rows.frame.theta))
        seen = _Seen.of(bare, known, train, given)
        lawless = seen.series(known)
        left = turns(
            replace(bare, y=bare.y - replace(out, series=lawless, law=None, peaks=[]).evaluate(rows.frame)), known
        )
        x, direction = states(left), np.array([t.direction for t in left])
        smooth = lawless.vectors(x, direction)
        data = Orders(
            seen.vectors,
            noise_at(left, known) / np.abs(seen.touched),
            x,
            direction,
            np.array([t.time for t in left]),
            tuple(float(f) for f in known),
            seen.chosen,
            lawless,
            smooth,
            float(np.median([t.white for t in left])),
            tuple(left),
        )
        law = best_law(data)
        series = lawless
        if law is not None:
            series = seen.series(known, factor(law, x, data.time, known))
        out = Harmonics(series, plain, lawless, law, out.peaks, left, given)
        left = turns(replace(bare, y=bare.y - replace(out, peaks=[]).evaluate(rows.frame)), known)
        out.turns = left
        carriers = {int(f): series.vectors(x, direction)[:, k] for k, f in enumerate(orders)}
        fresh = search(Spectra.of(left, seen.chosen, known, carriers))
        pulses = [p for p in (*out.peaks, *fresh) if p.kind == "pulse"]
        if pulses:
            rest = replace(rows, y=rows.y - replace(out, peaks=[]).evaluate(rows.frame))
            pulses = fitted(pulses, rest, training)
        out.peaks = [*(p for p in (*out.peaks, *fresh) if p.kind != "pulse"), *pulses]
        if (not fresh and number > 0) or not out.peaks:
            break
    return out


def _new_orders(peaks: Sequence[Peak]) -> list[float]:
    return sorted({float(f) for p in peaks for f in p.orders})
