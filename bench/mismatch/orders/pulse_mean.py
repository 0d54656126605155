"""The mean spectrum of the revolutions, in which pulses are looked for: what may stand there, what a pulse gains."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.orders.lowest import lowest
from bench.mismatch.orders.periodic import Pulse
from bench.mismatch.orders.revolutions import Complex
from bench.mismatch.orders.sight import Sight
from bench.simulation.frame import FloatArray

HIGHEST = 600
"""order up to which pulses are looked for: one of 2.5 mrad has half its height there"""
WIDTHS = np.geomspace(0.005, 0.16, 8)
"""rad, standard deviations that are tried before they are refined"""
BEGINS = (1.0, 0.5, 0.25)
"""of the matched filter's height, from which a pulse is refined"""
GRID = 4096
"""angles of a revolution at which the matched filter is evaluated"""
EVALUATIONS = 90
"""of the gain of one pulse while it is refined"""
Gain = Callable[..., float]
"""of some pulses"""
_SIZES = np.linspace(1.0, 0.125, 8)[:, None]
"""logarithms of an order's size, over that of the usual one, both against the error: evenly spread"""


@dataclass(frozen=True)
class Mean:
    """The mean spectrum (k,) at free orders: vectors, standard deviation of a component, what else may stand there."""

    orders: FloatArray
    vectors: Complex
    error: FloatArray
    share: FloatArray
    """of the orders there that stand by themselves (k,)"""
    size: FloatArray
    """standard deviation of a component of those (k,)"""

    @classmethod
    def of(cls, sight: Sight, vectors: Complex) -> Mean:
        """Of the vectors (orders,) at whole orders, where the sight says they are free."""
        numbers = np.flatnonzero(sight.free[: HIGHEST + 1])
        orders = numbers.astype(np.float64)
        found = np.array([f for f in sight.found if 0 < f <= HIGHEST])
        size2 = np.abs(vectors[np.rint(found).astype(np.int64)]) ** 2 / 2.0
        error = sight.error[numbers]
        # orders of the same octave tell how many stand, and how large; half an order and a mean one where none is
        near = np.abs(np.log2(np.maximum(found, 1.0) / orders[:, None])) < 0.5
        number = near.sum(axis=1)
        span = np.maximum(orders * (np.sqrt(2.0) - 1.0 / np.sqrt(2.0)), 1.0)
        share = np.minimum((number + 0.5) / (span + 1.0), 0.9)
        size = 10.0 * error
        if found.size:
            size = np.sqrt((near @ size2 + float(size2.mean())) / (number + 1.0))
        return cls(orders, vectors[numbers], error, share, size)

    @cached_property
    def _beside(self) -> tuple[FloatArray, FloatArray]:
        """Variances (sizes, k) of orders that stand by themselves, and the share (k,) of each size."""
        # a gearbox has a few strong orders and many weak ones: of any size between the error and the usual one
        own = np.maximum(self.size, self.error) ** (2.0 * _SIZES) * self.error ** (2.0 * (1.0 - _SIZES))
        return own, self.share / _SIZES.size

    def density(self, centre: Complex, unlike: FloatArray) -> FloatArray:
        """Log density of each vector (k,) about a pulse's vectors ``centre`` (k,), from which nature's may be
        ``unlike`` (k,): a variance.
        """
        apart = self.vectors - centre
        off = 0.5 * (apart.real**2 + apart.imag**2)
        plain = self.error**2 + unlike
        own, share = self._beside
        more = plain + own
        # the exponents of orders that stand there are the larger ones: their largest keeps the sum from vanishing
        exponent = -off / more
        largest = exponent.max(axis=0)
        alone = (1.0 - self.share) * np.exp(-off / plain - largest) / plain
        beside = share * np.sum(np.exp(exponent - largest) / more, axis=0)
        return np.asarray(np.log(alone + beside) + largest)

    def beside(self, before: Complex) -> Gain:
        """Gain of log-likelihood of a pulse, or of some together, beside others that give ``before`` (k,).

        Against nothing in their place, or against orders of the pulses' sizes with phases of their own, whichever says
        more of the spectrum: only where the phases are those of one place is it a pulse.
        """
        # nature's pulse is no Gaussian: here and beside those before
        others = 0.5 * (criteria.SHAPE * np.abs(before)) ** 2
        nothing = self.density(before, others).sum()

        def gain(*pulses: Pulse) -> float:
            drawn = sum((p.vectors(self.orders) for p in pulses), np.zeros(self.orders.size, dtype=np.complex128))
            forms = sum((envelope(p, self.orders) ** 2 for p in pulses), np.zeros(self.orders.size))
            others_and_it = others + 0.5 * criteria.SHAPE**2 * forms
            as_large = self.density(before, others_and_it + 0.5 * np.abs(drawn) ** 2).sum()
            return float(self.density(before + drawn, others_and_it).sum() - max(nothing, as_large))

        return gain

    def best(self, before: Complex, starts: int, number: int = 1) -> tuple[float, tuple[Pulse, ...]] | None:
        """The pulse, or the two (``number``) together, that gain most beside others: by a matched filter over the
        angle, then refined from so many ``starts``. Of two alike either leaves as much as it says, so that neither
        gains anything alone.
        """
        gain = self.beside(before)
        begins = [peaks[k : k + number] for peaks in self._peaks(before) for k in range(0, len(peaks), number)]
        tried = sorted((_begun(pulses, gain) for pulses in begins), key=lambda g: -g[0])[:starts]
        return max((_refined(pulses, gain) for _, pulses in tried), key=lambda g: g[0], default=None)

    def _peaks(self, before: Complex) -> list[tuple[Pulse, Pulse]]:
        """The two highest peaks of a matched filter over the angle, for each width."""
        left = self.vectors - before
        significant = np.abs(left) ** 2 > 2.0 * np.log(1.0 + 1.0 / self.share) * self.error**2 * 4.0
        # of one that stands by itself no more is known than its phase
        variance = self.error**2 + np.where(significant, 0.5 * np.abs(left) ** 2, 0.0)
        numbers = self.orders.astype(np.int64)
        out: list[tuple[Pulse, Pulse]] = []
        for width in WIDTHS:
            shape = width * np.sqrt(2.0 / np.pi) * np.exp(-0.5 * (self.orders * width) ** 2)
            table = np.zeros(GRID // 2 + 1, dtype=np.complex128)
            table[numbers] = shape / variance * (left.imag - 1j * left.real)
            matched = np.fft.irfft(table, GRID) * (GRID / 2.0)
            energy = max(float(np.sum(shape**2 / variance)), 1e-300)
            peaks: list[Pulse] = []
            for _ in range(2):
                at = int(np.argmax(np.abs(matched)))
                height = float(matched[at] / energy)
                peaks.append(Pulse(2.0 * np.pi * at / GRID, float(width), height))
                half_width = max(1, int(2.0 * width / (2.0 * np.pi) * GRID))
                matched[np.arange(at - half_width, at + half_width + 1) % GRID] = 0.0
            out.append((peaks[0], peaks[1]))
        return out


def envelope(pulse: Pulse, orders: FloatArray) -> FloatArray:
    """Size (k,) at each order of a pulse with corners, as high and as wide as a Gaussian: an edge's spectrum falls with
    the square of the order, however smooth the Gaussian that it is most like (Bracewell, The Fourier Transform, ch. 8).
    """
    return np.asarray(np.abs(pulse.height) * pulse.width * np.sqrt(2.0 / np.pi) / (1.0 + (orders * pulse.width) ** 2))


def _begun(begins: Sequence[Pulse], gain: Gain) -> tuple[float, tuple[Pulse, ...]]:
    """Begins of the matched filter with the height that gains most: weak orders that happen to be in phase with them
    make them too high.
    """
    lower = [tuple(replace(p, height=share * p.height) for p in begins) for share in BEGINS]
    return max(((gain(*pulses), pulses) for pulses in lower), key=lambda g: g[0])


def _refined(begins: Sequence[Pulse], gain: Gain) -> tuple[float, tuple[Pulse, ...]]:
    def pulses(x: FloatArray) -> tuple[Pulse, ...]:
        out = []
        for begin, (shift, wider, higher) in zip(begins, x.reshape(-1, 3), strict=True):
            # a wider one is a handful of low orders, whose phases agree by chance now and then
            width = float(np.clip(begin.width * np.exp(wider), 0.5 * WIDTHS[0], WIDTHS[-1]))
            angle = float(np.mod(begin.angle + begin.width * shift, 2.0 * np.pi))
            out.append(Pulse(angle, width, float(begin.height * (1.0 + higher))))
        return tuple(out)

    number = len(begins)
    found = lowest(
        lambda x: -gain(*pulses(x)), np.zeros(3 * number), np.tile([0.3, 0.25, 0.25], number), EVALUATIONS * number**2
    )
    best = pulses(found)
    return gain(*best), best
