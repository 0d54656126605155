"""Everything in the transmission error that is periodic in the angle, as one function of the rows of a frame."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from bench.mismatch.orders.revolutions import Complex, Revolution, directions, passed, states
from bench.mismatch.orders.series import Series
from bench.mismatch.orders.weak import WeakOrder, design
from bench.mismatch.regression.bank import RIDGE
from bench.simulation import waves
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.free_oscillation import free_oscillation, over_angle
from bench.simulation.laws import RESONANCE, Law, factor
from bench.simulation.sines import summed_vectors
from bench.simulation.waves import ROWS_AT_ONCE, Wave

SLOPE_STEP = 3e-4
"""rad to either side over which a slope is taken where it is not known in closed form"""


@dataclass(frozen=True, slots=True)
class Pulse:
    """A Gaussian pulse of the transmission error: angle and width (standard deviation) in rad, height in rad; with
    their standard deviations where they were estimated.
    """

    angle: float
    width: float
    height: float
    std: tuple[float, float, float] | None = None

    def evaluate(self, theta: FloatArray) -> FloatArray:
        """The pulse at angles (n,), rad."""
        distance = waves.angle_from(theta, self.angle)
        return np.asarray(self.height * np.exp(-0.5 * (distance / self.width) ** 2))

    def slope(self, theta: FloatArray) -> FloatArray:
        """Its change with the angle at angles (n,), rad/rad."""
        distance = waves.angle_from(theta, self.angle)
        return np.asarray(-distance / self.width**2 * self.evaluate(theta))

    def vectors(self, orders: FloatArray) -> Complex:
        """Vectors b + j*a of the pulse at orders (k,), the constant left out."""
        shape = self.height * self.width * np.sqrt(2.0 / np.pi) * np.exp(-0.5 * (orders * self.width) ** 2)
        out = shape * (np.sin(orders * self.angle) + 1j * np.cos(orders * self.angle))
        return np.asarray(np.where(orders > 0, out, 0.0))


@dataclass(frozen=True, slots=True)
class Sideband:
    """Modulation of a carrier by order m: vectors at carrier - m and carrier + m, in units of the carrier's own."""

    carrier: float
    modulation: float
    lower: complex
    upper: complex
    std: tuple[float, float] | None = None

    @property
    def orders(self) -> tuple[float, float]:
        """The pair."""
        return self.carrier - self.modulation, self.carrier + self.modulation


@dataclass(frozen=True, slots=True)
class Periodic:
    """The series (whose orders the laws multiply), further orders, pulses and sidebands of its orders."""

    series: Series
    weak: tuple[WeakOrder, ...] = ()
    waves: tuple[Wave, ...] = ()
    pulses: tuple[Pulse, ...] = ()
    sidebands: tuple[Sideband, ...] = ()
    laws: tuple[Law, ...] = field(default=())

    def evaluate(self, frame: Frame) -> FloatArray:
        """Sum of everything periodic at the rows of a frame (n,), rad; of modes also what they swing by freely."""
        out = self._steady(frame)
        return out + self.swinging(frame) if any(law.swings for law in self.laws) else out

    def _steady(self, frame: Frame) -> FloatArray:
        out = self.series.evaluate(frame) if not self.laws else self._by_vectors(frame)
        if self.sidebands:
            out = out + self._modulated(frame)
        for pulse in self.pulses:
            out = out + pulse.evaluate(frame.theta)
        further = [*self.waves, *(w for order in self.weak for w in order.waves())]
        return out + waves.evaluate(further, frame.theta, frame) if further else out

    def slope(self, frame: Frame) -> FloatArray:
        """Change of everything periodic with the angle at the rows of a frame (n,), rad/rad."""
        if self.laws or self.pulses or self.sidebands:
            ahead, behind = (replace(frame, theta=frame.theta + step) for step in (SLOPE_STEP, -SLOPE_STEP))
            return (self._steady(ahead) - self._steady(behind)) / (2.0 * SLOPE_STEP) + self._swinging_slope(frame)
        steeper = [w.slope for w in (*self.waves, *(w for order in self.weak for w in order.waves()))]
        out = self.series.slope(frame)
        return out + waves.evaluate(steeper, frame.theta, frame) if steeper else out

    def slope_of_rows(self, frame: Frame) -> FloatArray:
        """Mean of the slope over the angle that each row of a frame turns through (n,), rad/rad."""
        half = np.maximum(0.5 * np.abs(frame.velocity) * frame.step, SLOPE_STEP)
        ahead, behind = (replace(frame, theta=frame.theta + shift) for shift in (half, -half))
        return (self._steady(ahead) - self._steady(behind)) / (2.0 * half) + self._swinging_slope(frame)

    def _swinging_slope(self, frame: Frame) -> FloatArray:
        swings = any(law.swings for law in self.laws)
        return over_angle(self.swinging(frame), frame) if swings else np.zeros(frame.size)

    def less(self, orders: Collection[float]) -> Periodic:
        """The same without some orders, and without what modulates them."""
        return replace(
            self,
            series=self.series.less(orders),
            weak=tuple(w for w in self.weak if w.order not in orders),
            waves=tuple(w for w in self.waves if w.order not in orders),
            sidebands=tuple(b for b in self.sidebands if b.carrier not in orders),
        )

    def at_revolutions(self, revolutions: Sequence[Revolution], orders: Sequence[float]) -> Complex:
        """Vectors b + j*a of some orders in the revolutions (revolutions, k)."""
        out = np.zeros((len(revolutions), len(orders)), dtype=np.complex128)
        column = {float(f): k for k, f in enumerate(orders)}
        x, side = states(revolutions), directions(revolutions)
        vectors = self.series.vectors(x, side) * passed(self.laws, revolutions, self.series.orders)
        for k, f in enumerate(self.series.orders):
            if f in column:
                out[:, column[f]] += vectors[:, k]
        for order in self.weak:
            if order.order in column:
                out[:, column[order.order]] += order.at(design(order.model, revolutions))
        for band in self.sidebands:
            carrier = vectors[:, self.series.orders.index(band.carrier)]
            for f, ratio in zip(band.orders, (band.lower, band.upper), strict=True):
                if f in column:
                    out[:, column[f]] += ratio * carrier
        for pulse in self.pulses:
            out += pulse.vectors(np.asarray(orders))[None, :]
        return out

    def beyond_series(
        self, law: Law, frame: Frame, numbers: Sequence[FloatArray], known: Collection[float] | None = None
    ) -> list[FloatArray]:
        """What a law adds at the rows of a frame (n,) that no series without it says, rad, for each of some ``numbers``
        (n,) of samples in the rows.

        The law's orders at all rows are fitted with the ten monomials of either direction by linear least squares: what
        is left depends on the law and the points that were run alone. An order that is not ``known`` (None: all are) to
        the simulation is none of its series: all that the law adds to it is beyond.
        """
        columns = [self.series.orders.index(f) for f in law.orders]
        new = np.array([known is not None and f not in known for f in law.orders])
        without = replace(
            self, laws=tuple(other for other in self.laws if other.form != law.form or other.point != law.point)
        )
        scaling, chunks = self.series.scaling, [slice(a, a + ROWS_AT_ONCE) for a in range(0, frame.size, ROWS_AT_ONCE)]

        def parts(chunk: slice) -> Iterator[tuple[int, IntArray, FloatArray, Complex]]:
            few = frame.take(chunk)
            x = few.states
            vectors = self._vectors(few)[:, columns]
            if new.any():
                vectors[:, new] -= without._vectors(few)[:, columns][:, new]
            for side in scaling:
                rows = np.flatnonzero(few.last_direction * side > 0)
                yield side, rows + chunk.start, scaling[side].monomials(x[rows]), vectors[rows]

        every = [(k, side) for k in range(len(numbers)) for side in scaling]
        gram = {at: RIDGE * np.eye(10) * max(float(numbers[at[0]].sum()), 1.0) for at in every}
        right = {at: np.zeros((10, len(columns)), dtype=np.complex128) for at in every}
        for chunk in chunks:
            for side, rows, basis, vectors in parts(chunk):
                for k, number in enumerate(numbers):
                    weighted = basis * number[rows][:, None]
                    gram[k, side] += basis.T @ weighted
                    right[k, side] += weighted.T @ vectors
        fitted = {at: np.where(new, 0.0, np.linalg.solve(gram[at], right[at])) for at in every}
        out = [np.zeros(frame.size) for _ in numbers]
        orders = np.asarray(law.orders)
        for chunk in chunks:
            for side, rows, basis, vectors in parts(chunk):
                for k, beyond in enumerate(out):
                    left = vectors - basis @ fitted[k, side]
                    real, imag = np.ascontiguousarray(left.real.T), np.ascontiguousarray(left.imag.T)
                    beyond[rows] = summed_vectors(frame.theta[rows], orders, real, imag)
        return out

    def _by_vectors(self, frame: Frame) -> FloatArray:
        out = np.zeros(frame.size)
        for a in range(0, frame.size, ROWS_AT_ONCE):
            chunk = slice(a, a + ROWS_AT_ONCE)
            vectors = self._vectors(frame.take(chunk))
            real, imag = np.ascontiguousarray(vectors.real.T), np.ascontiguousarray(vectors.imag.T)
            out[chunk] = summed_vectors(frame.theta[chunk], np.asarray(self.series.orders), real, imag)
        return out

    def swinging(self, frame: Frame) -> FloatArray:
        """What the modes of resonances swing by freely after changes of speed, at the rows of a frame (n,), rad."""
        out = np.zeros(frame.size)
        for law in self.laws:
            if law.swings:
                out += free_oscillation(law, frame, np.asarray(self.series.orders), self._not_resonant)
        return out

    def _not_resonant(self, frame: Frame) -> Complex:
        return replace(self, laws=tuple(law for law in self.laws if law.effect != RESONANCE))._vectors(frame)

    def _vectors(self, frame: Frame) -> Complex:
        x = frame.states
        out = self.series.vectors(x, frame.last_direction)
        for law in self.laws:
            out = out * factor(law, x, frame.time, self.series.orders)
        return out

    def _modulated(self, frame: Frame) -> FloatArray:
        out = np.zeros(frame.size)
        for a in range(0, frame.size, ROWS_AT_ONCE):
            chunk = slice(a, a + ROWS_AT_ONCE)
            vectors = self._vectors(frame.take(chunk))
            for band in self.sidebands:
                carrier = vectors[:, self.series.orders.index(band.carrier)]
                for f, ratio in zip(band.orders, (band.lower, band.upper), strict=True):
                    value, angle = ratio * carrier, f * frame.theta[chunk]
                    out[chunk] += value.real * np.sin(angle) + value.imag * np.cos(angle)
        return out
