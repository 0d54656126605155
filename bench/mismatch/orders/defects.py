"""Local defects: pulses at fixed angles, against the plain orders that would draw them.

A gearbox full of orders draws any curve, so a pulse has to say more with three numbers than orders say with two each.
At every whole order the mean vector of the revolutions is noise about the pulse's vector, or, with the share of orders
that stand in this spectrum, an order of its own beside it; both densities are known from the spectrum, so the gain of
log-likelihood of a pulse is that of description length. How much the best pulse gains where there is none is measured
on the same spectrum with the phase of each order drawn at random.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from bench.mismatch import criteria
from bench.mismatch.orders.lowest import lowest
from bench.mismatch.orders.periodic import Pulse
from bench.mismatch.orders.sight import Sight
from bench.mismatch.orders.turns import Complex
from bench.mismatch.regression.maxima import tail, tail_rate
from bench.simulation.frame import FloatArray

HIGHEST = 600
"""order up to which pulses are looked for: one of 2.5 mrad has half its height there"""
WIDTHS = np.geomspace(0.005, 0.16, 8)
"""rad, standard deviations that are tried before they are refined"""
SURROGATES = 24
STARTS = 4
BEGINS = (1.0, 0.5, 0.25)
"""of the matched filter's height, from which a pulse is refined"""
MOST_PLACES = 6
MOST_GAUSSIANS = 4
"""that describe the form of one place: triangles, half sines, doublets"""
REACH = 5.0
"""widths within which two pulses are one place"""
_GRID = 4096
_SIZES = np.linspace(1.0, 0.125, 8)[:, None]
"""logarithms of an order's size, over that of the usual one, both against the error: evenly spread"""
_FAR = 9.0
"""squares over the noise's from which an order counts by their logarithm: it may be one of its own"""


@dataclass(frozen=True, slots=True)
class Defect:
    """One damaged place: the Gaussian it is most like, those that describe its form, gain of description length,
    p-value.
    """

    first: Pulse
    form: tuple[Pulse, ...]
    gain: float
    p_value: float


@dataclass(frozen=True, slots=True)
class _Line:
    """The mean spectrum (k,) at free orders: vectors, standard deviation of a component, what else may stand there."""

    orders: FloatArray
    vectors: Complex
    error: FloatArray
    share: FloatArray
    """of the orders there that stand by themselves (k,)"""
    size: FloatArray
    """standard deviation of a component of those (k,)"""

    @classmethod
    def of(cls, sight: Sight, vectors: Complex) -> _Line:
        places = np.flatnonzero(sight.free[: HIGHEST + 1])
        orders = places.astype(np.float64)
        found = np.array([f for f in sight.found if 0 < f <= HIGHEST])
        size2 = np.array([np.abs(vectors[round(f)]) ** 2 / 2.0 for f in found])
        share, size = np.empty(orders.size), np.empty(orders.size)
        whole = float(size2.mean()) if found.size else 0.0
        for k, f in enumerate(orders):
            # orders of the same octave tell how many stand, and how large; half an order and a mean one where none is
            near = np.abs(np.log2(np.maximum(found, 1.0) / f)) < 0.5 if found.size else np.zeros(0, dtype=bool)
            span = max(f * (np.sqrt(2.0) - 1.0 / np.sqrt(2.0)), 1.0)
            share[k] = min((near.sum() + 0.5) / (span + 1.0), 0.9)
            level = np.sqrt((size2[near].sum() + whole) / (near.sum() + 1.0))
            size[k] = level if whole else 10.0 * sight.error[round(f)]
        return cls(orders, vectors[places], sight.error[places], share, size)

    def density(self, centre: Complex, unlike: FloatArray) -> FloatArray:
        """Log density of each vector (k,) about a pulse's vectors ``centre`` (k,), from which nature's may be
        ``unlike`` (k,): a variance.
        """
        off = 0.5 * np.abs(self.vectors - centre) ** 2
        plain = self.error**2 + unlike
        alone = np.log1p(-self.share) - np.log(plain) - off / plain
        # a gearbox has a few strong orders and many weak ones: of any size between the error and the usual one
        more = plain + np.maximum(self.size, self.error) ** (2.0 * _SIZES) * self.error ** (2.0 * (1.0 - _SIZES))
        beside = np.log(self.share / _SIZES.size) - np.log(more) - off / more
        return np.asarray(np.logaddexp.reduce(np.vstack([alone, beside]), axis=0))

    def gain(self, pulse: Pulse, before: Complex) -> float:
        """Gain of log-likelihood of a pulse beside others that give ``before`` (k,)."""
        with_it = before + pulse.vectors(self.orders)
        # nature's pulse is no Gaussian: here and beside those before
        others = 0.5 * (criteria.SHAPE * np.abs(before)) ** 2
        tolerance = 0.5 * (criteria.SHAPE * _envelope(pulse, self.orders)) ** 2
        return float(np.sum(self.density(with_it, others + tolerance) - self.density(before, others)))

    def best(self, before: Complex, starts: int) -> tuple[float, Pulse] | None:
        """The pulse that gains most beside others: by a matched filter over the angle, then refined."""
        left = self.vectors - before
        standing = np.abs(left) ** 2 > 2.0 * np.log(1.0 + 1.0 / self.share) * self.error**2 * 4.0
        # of one that stands by itself no more is known than its phase
        variance = self.error**2 + np.where(standing, 0.5 * np.abs(left) ** 2, 0.0)
        places = self.orders.astype(np.int64)
        begins: list[Pulse] = []
        for width in WIDTHS:
            shape = width * np.sqrt(2.0 / np.pi) * np.exp(-0.5 * (self.orders * width) ** 2)
            table = np.zeros(_GRID // 2 + 1, dtype=np.complex128)
            table[places] = shape / variance * (left.imag - 1j * left.real)
            matched = np.fft.irfft(table, _GRID) * (_GRID / 2.0)
            energy = max(float(np.sum(shape**2 / variance)), 1e-300)
            for _ in range(2):
                at = int(np.argmax(np.abs(matched)))
                height = float(matched[at] / energy)
                begins.append(Pulse(2.0 * np.pi * at / _GRID, float(width), height))
                reach = max(1, int(2.0 * width / (2.0 * np.pi) * _GRID))
                matched[np.arange(at - reach, at + reach + 1) % _GRID] = 0.0
        tried = sorted((self._begun(p, before) for p in begins), key=lambda g: -g[0])[:starts]
        out = [self._refined(p, before) for _, p in tried]
        return max(out, key=lambda g: g[0]) if out else None

    def _begun(self, begin: Pulse, before: Complex) -> tuple[float, Pulse]:
        """A begin of the matched filter with the height that gains most: weak orders that happen to be in phase with it
        make it too high.
        """
        lower = [replace(begin, height=share * begin.height) for share in BEGINS]
        return max(((self.gain(p, before), p) for p in lower), key=lambda g: g[0])

    def _refined(self, begin: Pulse, before: Complex) -> tuple[float, Pulse]:
        def pulse(x: FloatArray) -> Pulse:
            width = float(np.clip(begin.width * np.exp(x[1]), 0.5 * WIDTHS[0], 2.0 * WIDTHS[-1]))
            return Pulse(float(begin.angle + begin.width * x[0]), width, float(begin.height * (1.0 + x[2])))

        found = lowest(lambda x: -self.gain(pulse(x), before), np.zeros(3), np.array([0.3, 0.25, 0.25]), 90)
        best = pulse(found)
        return self.gain(best, before), Pulse(float(np.mod(best.angle, 2.0 * np.pi)), best.width, best.height)


def _envelope(pulse: Pulse, orders: FloatArray) -> FloatArray:
    """Size (k,) at each order of a pulse with corners, as high and as wide as a Gaussian: an edge's spectrum falls with
    the square of the order, however smooth the Gaussian that it is most like (Bracewell, The Fourier Transform, ch. 8).
    """
    return np.asarray(np.abs(pulse.height) * pulse.width * np.sqrt(2.0 / np.pi) / (1.0 + (orders * pulse.width) ** 2))


def search(sight: Sight, seed: int) -> list[Defect]:
    """Damaged places that stand in the mean spectrum, strongest first."""
    line = _Line.of(sight, sight.mean)
    before = np.zeros(line.orders.size, dtype=np.complex128)
    found: list[tuple[float, Pulse]] = []
    nulls: FloatArray | None = None
    p_values: list[float] = []
    while len(found) < MOST_PLACES:
        best = line.best(before, STARTS)
        # three numbers of a mean of as many orders cost half their logarithm each (BIC): less is nothing anyway
        if best is None or best[0] < 1.5 * np.log(2.0 * line.orders.size):
            break
        if nulls is None:
            nulls = _without_phase(sight, seed)
        if best[0] < tail(nulls, criteria.ERROR_RATE_OF_A_CHANNEL):
            break
        p_values.append(tail_rate(nulls, best[0]))
        one, form = _form(line, before, best[1])
        found.append((best[0], one))
        before = before + sum((p.vectors(line.orders) for p in form), np.zeros(line.orders.size, dtype=np.complex128))
    places: list[tuple[float, Pulse, float]] = []
    for (gain, pulse), p in zip(found, p_values, strict=True):
        # what stands beside a place within its reach is its form
        if not any(_apart(pulse.angle, o.angle) < REACH * max(pulse.width, o.width) for _, o, _ in places):
            places.append((gain, pulse, p))
    out: list[Defect] = []
    others = np.zeros(line.orders.size, dtype=np.complex128)
    for gain, pulse, p in places:
        first, form = _form(line, others, pulse)
        others = others + sum(q.vectors(line.orders) for q in form)
        out.append(Defect(first if len(form) == 1 else _apex(form), form, gain, p))
    return out


def _without_phase(sight: Sight, seed: int) -> FloatArray:
    """What the best pulse gains where each order has a phase of its own (SURROGATES,)."""
    rng = np.random.default_rng([seed, 2])
    out = []
    for _ in range(SURROGATES):
        drawn = sight.mean * np.exp(2j * np.pi * rng.random(sight.mean.size))
        line = _Line.of(sight, drawn)
        best = line.best(np.zeros(line.orders.size, dtype=np.complex128), 1)
        out.append(best[0] if best is not None else 0.0)
    return np.asarray(out)


def _form(line: _Line, before: Complex, first: Pulse) -> tuple[Pulse, tuple[Pulse, ...]]:
    """The Gaussian that a place is most like; and its form as some Gaussians, fitted to the spectrum with little
    weight on orders that stand beside them.
    """
    left = line.vectors - before
    begin = np.zeros(0)
    best: tuple[float, FloatArray, FloatArray] | None = None
    one: Pulse | None = None
    rest = left
    for number in range(1, MOST_GAUSSIANS + 1):
        plain = np.array([first.height, 0.0, np.log(first.width)])
        begin = np.append(begin, plain if number == 1 else _next(line, rest, first))
        begin, cost, covariance = _least_squares(line, left, first, begin, criteria.SHAPE / 2.0 ** (number - 1))
        # three numbers of a mean of as many orders: half their logarithm each (BIC)
        total = cost + 0.5 * 3 * number * np.log(2.0 * line.orders.size)
        if best is not None and total >= best[0]:
            break
        best = (total, begin, covariance)
        one = one or _pulses(begin, covariance, first)[0]
        rest = left - _vectors(begin, first, line.orders)
    assert best is not None
    assert one is not None
    return one, tuple(sorted(_pulses(best[1], best[2], first), key=lambda p: -abs(p.height * np.sqrt(p.width))))


def _apex(form: Sequence[Pulse]) -> Pulse:
    """The Gaussian as high and, at half its height, as wide as several together, where they are highest."""
    reach = REACH * max(p.width for p in form)
    angle = form[0].angle + np.linspace(-reach, reach, 2 * _GRID + 1)
    values = np.asarray(sum(p.evaluate(angle) for p in form))
    top = int(np.argmax(np.abs(values)))
    low = np.abs(values) < 0.5 * np.abs(values[top])
    before, after = np.flatnonzero(low[:top]), np.flatnonzero(low[top:])
    first = angle[before[-1]] if before.size else angle[0]
    last = angle[top + after[0]] if after.size else angle[-1]
    width = float(last - first) / (2.0 * np.sqrt(2.0 * np.log(2.0)))
    return Pulse(float(np.mod(angle[top], 2.0 * np.pi)), width, float(values[top]))


def _pulses(x: FloatArray, covariance: FloatArray, first: Pulse) -> list[Pulse]:
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0)).reshape(-1, 3)
    out = []
    for (height, shift, width), (sh, sa, sw) in zip(x.reshape(-1, 3), std, strict=True):
        size = float(np.exp(width))
        deviations = (float(sa), float(sw * size), float(sh))
        out.append(Pulse(float(np.mod(first.angle + shift, 2.0 * np.pi)), size, float(height), deviations))
    return out


def _next(line: _Line, rest: Complex, first: Pulse) -> FloatArray:
    """Where a further Gaussian at a place should begin: height, shift, logarithm of the width."""
    clipped = rest * np.minimum(1.0, 3.0 * line.error / np.maximum(np.abs(rest), 1e-300))
    best = (0.0, np.array([0.1 * first.height, 0.0, np.log(0.6 * first.width)]))
    for width in first.width * np.array([0.4, 0.7, 1.2]):
        for shift in first.width * np.linspace(-3.0, 3.0, 13):
            one = Pulse(first.angle + float(shift), float(width), 1.0).vectors(line.orders)
            energy = float(np.sum(np.abs(one) ** 2 / line.error**2))
            product = float(np.sum((np.conj(one) * clipped).real / line.error**2))
            if product**2 / energy > best[0]:
                height = float(np.sum((np.conj(one) * rest).real / line.error**2)) / energy
                best = (product**2 / energy, np.array([height, float(shift), np.log(width)]))
    return best[1]


def _vectors(x: FloatArray, first: Pulse, orders: FloatArray) -> Complex:
    out = np.zeros(orders.size, dtype=np.complex128)
    for height, shift, width in x.reshape(-1, 3):
        out += Pulse(first.angle + shift, float(np.exp(width)), height).vectors(orders)
    return out


def _least_squares(
    line: _Line, left: Complex, first: Pulse, begin: FloatArray, doubt: float
) -> tuple[FloatArray, float, FloatArray]:
    """Gaussians near a pulse: height, shift, logarithm of the width of each; the cost by the noise alone; covariance.

    ``doubt``: how far the form may be from these Gaussians, over the pulse's size.
    """
    error = np.sqrt(line.error**2 + 0.5 * (doubt * _envelope(first, line.orders)) ** 2)
    number = begin.size // 3
    units = np.tile([abs(first.height), first.width, 1.0], number)
    half = REACH * first.width
    lower = np.tile([-8.0 * abs(first.height), -half, np.log(0.15 * first.width)], number)
    upper = np.tile([8.0 * abs(first.height), half, np.log(4.0 * first.width)], number)

    def off(x: FloatArray) -> Complex:
        return np.asarray(_vectors(x, first, line.orders) - left)

    def misfit(x: FloatArray) -> FloatArray:
        error_of = off(x) / error
        return np.concatenate([error_of.real, error_of.imag])

    inside = np.clip(begin, lower + 1e-6 * units, upper - 1e-6 * units)
    # orders that stand by themselves at the same place count by their logarithm
    found = least_squares(misfit, inside, bounds=(lower, upper), x_scale=units, loss="cauchy", f_scale=3.0, max_nfev=80)
    jacobian: FloatArray = np.asarray(found.jac, dtype=np.float64)
    covariance = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12)
    squares = np.abs(off(np.asarray(found.x))) ** 2 / (2.0 * line.error**2)
    cost = float(np.sum(_FAR * np.log1p(squares / _FAR)))
    return np.asarray(found.x), cost, np.asarray(covariance)


def _apart(one: float, other: float) -> float:
    return float(np.abs(np.mod(one - other + np.pi, 2.0 * np.pi) - np.pi))


def all_pulses(defects: Sequence[Defect]) -> tuple[Pulse, ...]:
    """Pulses of all places."""
    return tuple(p for d in defects for p in d.form)
