"""The form of a damaged place as a few Gaussians, fitted to the mean spectrum."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from bench.mismatch import criteria
from bench.mismatch.orders.periodic import Pulse
from bench.mismatch.orders.pulse_mean import GRID, Mean, envelope
from bench.mismatch.orders.revolutions import Complex
from bench.simulation.frame import FloatArray
from bench.simulation.waves import angle_from

MOST_GAUSSIANS = 4
"""that describe the form of one place: triangles, half sines, doublets"""
SEARCH_RANGE = 5.0
"""widths within which two pulses are one place"""
ENDS = 2.5
"""widths from its middle to which a Gaussian acts: all but a two-thousandth of its energy"""


@dataclass(frozen=True, slots=True)
class Form:
    """A place: the Gaussian it is most like, those that describe it, and how many nats the spectrum takes with them."""

    first: Pulse
    pulses: tuple[Pulse, ...]
    words: float


def form_of(line: Mean, before: Complex, first: Pulse) -> Form:
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
        total = cost + price_of(line, number)
        if best is not None and total >= best[0]:
            break
        best = (total, begin, covariance)
        one = one or _pulses(begin, covariance, first)[0]
        rest = left - _vectors(begin, first, line.orders)
    assert best is not None
    assert one is not None
    return Form(one, _pulses(best[1], best[2], first), best[0])


def fewest(line: Mean, before: Complex, pulses: Sequence[Pulse]) -> Form:
    """The form of a place that several Gaussians describe together, with as few of them as the spectrum asks for.

    All are fitted at once; then the one that is least above its error goes, as long as the others describe the
    spectrum in fewer words. A pull beside a push is found as three or four places first, each of them fitted to what
    the others leave.
    """
    left = line.vectors - before
    best: Form | None = None
    # the range about the place is that of the pulses it was found as: from one fit to the next it would grow
    widest = max((p.width for p in pulses), default=0.0)
    while pulses:
        first = replace(max(pulses, key=size_of), width=widest)
        begin = np.concatenate([[p.height, angle_from(p.angle, first.angle), np.log(p.width)] for p in pulses])
        begin, cost, covariance = _least_squares(line, left, first, begin, criteria.SHAPE / 2.0 ** (len(pulses) - 1))
        total = cost + price_of(line, len(pulses))
        if best is not None and total >= best.words:
            break
        pulses = _pulses(begin, covariance, first)
        best = Form(pulses[0], pulses, total)
        certain = [abs(p.height) / max(p.std[2], 1e-300) if p.std else 0.0 for p in pulses]
        pulses = [p for k, p in enumerate(pulses) if k != int(np.argmin(certain))]
    assert best is not None
    return best


def apex(form: Sequence[Pulse]) -> Pulse:
    """The Gaussian as high and, at half its height, as wide as several together, where they are highest."""
    range_about = SEARCH_RANGE * max(p.width for p in form)
    angle = form[0].angle + np.linspace(-range_about, range_about, 2 * GRID + 1)
    values = np.asarray(sum(p.evaluate(angle) for p in form))
    top = int(np.argmax(np.abs(values)))
    low = np.abs(values) < 0.5 * np.abs(values[top])
    before, after = np.flatnonzero(low[:top]), np.flatnonzero(low[top:])
    first = angle[before[-1]] if before.size else angle[0]
    last = angle[top + after[0]] if after.size else angle[-1]
    width = float(last - first) / (2.0 * np.sqrt(2.0 * np.log(2.0)))
    return Pulse(float(np.mod(angle[top], 2.0 * np.pi)), width, float(values[top]))


def extent(pulses: Sequence[Pulse]) -> tuple[float, float]:
    """Angles (rad) between which several Gaussians together are above the part of their height that one Gaussian has
    :data:`ENDS` widths from its middle.
    """
    middle = max(pulses, key=size_of).angle
    begins = [angle_from(p.angle, middle) - 2.0 * ENDS * p.width for p in pulses]
    ends = [angle_from(p.angle, middle) + 2.0 * ENDS * p.width for p in pulses]
    angle = middle + np.linspace(min(begins), max(ends), 2 * GRID + 1)
    values = np.abs(np.asarray(sum(p.evaluate(angle) for p in pulses)))
    above = np.flatnonzero(values >= np.exp(-0.5 * ENDS**2) * values.max())
    return float(angle[above[0]]), float(angle[above[-1]])


def price_of(line: Mean, number: int) -> float:
    """What some Gaussians cost: three numbers each, of a mean of as many orders, half their logarithm each (BIC)."""
    return 1.5 * number * float(np.log(2.0 * line.orders.size))


def size_of(pulse: Pulse) -> float:
    """Size of a pulse: the root of its energy, but for a factor that all have."""
    return abs(pulse.height) * float(np.sqrt(pulse.width))


def apart(one: float, other: float) -> float:
    """Distance of two angles, 0 to pi."""
    return abs(float(angle_from(one, other)))


def _pulses(x: FloatArray, covariance: FloatArray, first: Pulse) -> tuple[Pulse, ...]:
    """Gaussians of a fit, largest first, with their standard deviations."""
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0)).reshape(-1, 3)
    out = []
    for (height, shift, width), (sh, sa, sw) in zip(x.reshape(-1, 3), std, strict=True):
        size = float(np.exp(width))
        deviations = (float(sa), float(sw * size), float(sh))
        out.append(Pulse(float(np.mod(first.angle + shift, 2.0 * np.pi)), size, float(height), deviations))
    return tuple(sorted(out, key=size_of, reverse=True))


def _next(line: Mean, rest: Complex, first: Pulse) -> FloatArray:
    """Where a further Gaussian at a place should begin: height, shift, logarithm of the width."""
    clipped = rest * np.minimum(1.0, 3.0 * line.error / np.maximum(np.abs(rest), 1e-300))
    best = (0.0, np.array([0.1 * first.height, 0.0, np.log(0.6 * first.width)]))
    for width in first.width * np.array([0.4, 0.7, 1.2, 2.4]):
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
    line: Mean, left: Complex, first: Pulse, begin: FloatArray, doubt: float
) -> tuple[FloatArray, float, FloatArray]:
    """Gaussians near a pulse: height, shift, logarithm of the width of each; what the spectrum costs with them (nats);
    covariance.

    ``doubt``: how far the form may be from these Gaussians, over the pulse's size.
    """
    error = np.sqrt(line.error**2 + 0.5 * (doubt * envelope(first, line.orders)) ** 2)
    number = begin.size // 3
    units = np.tile([abs(first.height), first.width, 1.0], number)
    half = SEARCH_RANGE * first.width
    lower = np.tile([-8.0 * abs(first.height), -half, np.log(0.15 * first.width)], number)
    upper = np.tile([8.0 * abs(first.height), half, np.log(4.0 * first.width)], number)

    def off(x: FloatArray) -> Complex:
        return np.asarray(_vectors(x, first, line.orders) - left)

    def misfit(x: FloatArray) -> FloatArray:
        error_of = off(x) / error
        return np.concatenate([error_of.real, error_of.imag])

    def slopes(x: FloatArray) -> FloatArray:
        columns = []
        for height, shift, width in x.reshape(-1, 3):
            wide = float(np.exp(width))
            unit = Pulse(first.angle + shift, wide, 1.0).vectors(line.orders)
            shape = 1.0 - (line.orders * wide) ** 2
            columns += [unit, -1j * line.orders * height * unit, height * shape * unit]
        changes = np.array(columns).T / error[:, None]
        return np.concatenate([changes.real, changes.imag])

    inside = np.clip(begin, lower + 1e-6 * units, upper - 1e-6 * units)
    # orders that stand by themselves at the same place count by their logarithm
    found = least_squares(
        misfit, inside, slopes, bounds=(lower, upper), x_scale=units, loss="cauchy", f_scale=3.0, max_nfev=80
    )
    jacobian: FloatArray = np.asarray(found.jac, dtype=np.float64)
    covariance = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-12)
    # what is left of an order may be one that stands by itself: to follow it gains no more than that is unlikely
    cost = -float(np.sum(line.density(line.vectors + off(np.asarray(found.x)), np.zeros(line.orders.size))))
    return np.asarray(found.x), cost, np.asarray(covariance)
