"""Identifications of one gearbox put into series, one a quantity, each point with its limits of control."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from bench.identification.statistics.freedom import series_freedom
from bench.trend.kept import Identified
from bench.trend.limits import Limits, limits_from
from bench.trend.quantities import Quantity, Reference, Value, amplitude, hysteresis, stiffness

STRONGEST = 5
"""So many orders are followed in each direction: the largest at the reference point in the first campaign."""
DIRECTIONS = (("positive", 1.0, "+"), ("negative", -1.0, "−"))
_SPEEDS_ORDER = 5.0
Read = Callable[[Identified], Value | None]


@dataclass(frozen=True, slots=True)
class Point:
    """One campaign of a series; ``limits`` is None where too few earlier ones are there."""

    folder: str
    started_s: float
    value: Value
    limits: Limits | None

    @property
    def outside(self) -> bool:
        """Whether the value is outside of its limits."""
        return self.limits is not None and not self.limits.lower <= self.value.value <= self.limits.upper


@dataclass(frozen=True, slots=True)
class Series:
    """One quantity over the campaigns that give it, oldest first; values are SI."""

    quantity: Quantity
    points: tuple[Point, ...]


def reference_of(campaigns: Sequence[Identified]) -> Reference | None:
    """Return the reference point that most campaigns measured friction at; of equals, the nearest to 5 °/s, 30 °C."""
    counts: dict[tuple[float, float], int] = {}
    for one in campaigns:
        for at in one.friction:
            near = Reference(*at)
            holds = [near.measured(*limits) for limits in one.measured.values()]
            if holds and all(holds):
                counts[at] = counts.get(at, 0) + 1
    if not counts:
        return None

    def rank(at: tuple[float, float]) -> tuple[int, float, float]:
        return counts[at], -abs(float(np.log(at[0] / _SPEEDS_ORDER))), -abs(at[1] - 30.0)

    return Reference(*max(counts, key=rank))


def series_of(dated: Sequence[tuple[float, Identified]], reference: Reference | None) -> tuple[Series, ...]:
    """Return the series of campaigns (begin in Unix s, identification), oldest first; what nobody gave is left out.

    A campaign outside of its limits does not move those of later ones: after a repair, begin anew with ``since``.
    """
    out = []
    for quantity, read in _quantities([one for _, one in dated], reference):
        points: list[Point] = []
        for started_s, one in dated:
            value = read(one)
            if value is None or not value.std > 0.0:
                continue
            kept = [point.value for point in points if not point.outside]
            points.append(Point(one.folder, started_s, value, limits_from(kept, value)))
        if points:
            out.append(Series(quantity, tuple(points)))
    return tuple(out)


def _quantities(campaigns: Sequence[Identified], reference: Reference | None) -> Iterator[tuple[Quantity, Read]]:
    if reference is not None:
        yield from _of_error(campaigns, reference)
        speeds = sorted({at[0] for one in campaigns for at in one.friction})
        for speed in speeds:
            at = (speed, reference.temperature_degc)
            name = f"friction at {speed:g} °/s, {reference.temperature_degc:g} °C"
            yield Quantity(f"friction.{speed:g}", name, "mN·m", 1e3), lambda one, at=at: one.friction.get(at)  # type: ignore[misc]
    yield Quantity("friction.load", "share of the load torque that is friction", "%", 100.0), _parameter("f_l")
    yield Quantity("heat.resistance", "heat resistance", "K/W"), _parameter("R")
    yield Quantity("heat.capacity", "heat capacity", "kJ/K", 1e-3), _parameter("C")
    for name, _, sign in DIRECTIONS:
        yield Quantity(f"noise.{name}", f"noise of the transmission error, {sign}", "µrad", 1e6), _noise(name)


def _parameter(symbol: str) -> Read:
    return lambda one: one.parameter(symbol)


def _noise(direction: str) -> Read:
    return lambda one: one.noise.get(direction)


def _of_error(campaigns: Sequence[Identified], reference: Reference) -> Iterator[tuple[Quantity, Read]]:
    """Orders, hysteresis and stiffness at the reference point."""
    for name, sign, mark in DIRECTIONS:
        first = next((one for one in campaigns if _usable(one, name, reference)), None)
        if first is None or first.model is None:
            continue
        model = first.model.transmission_error()
        fourier = None if model is None else model.direction(sign)
        assert fourier is not None
        size = np.abs(fourier.amplitude @ reference.row(sign))
        for order in fourier.orders[np.argsort(-size)][:STRONGEST]:
            read = _amplitude(name, sign, float(order), reference)
            yield Quantity(f"order.{order:g}.{name}", f"order {order:g}, {mark}", "µrad", 1e6), read
    yield Quantity("hysteresis", "hysteresis", "µrad", 1e6), lambda one: _hysteresis(one, reference)
    for name, sign, mark in DIRECTIONS:
        read = _stiffness(name, sign, reference)
        yield Quantity(f"stiffness.{name}", f"stiffness, {mark}", "N·m/µrad", 1e-6), read


def _usable(one: Identified, direction: str, reference: Reference) -> bool:
    """Whether a campaign has a model of a direction, and measured the reference point."""
    limits = one.measured.get(direction)
    model = None if one.model is None else one.model.transmission_error()
    fourier = None if model is None else model.direction(dict((n, s) for n, s, _ in DIRECTIONS)[direction])
    return limits is not None and fourier is not None and reference.measured(*limits)


def _amplitude(direction: str, sign: float, order: float, reference: Reference) -> Read:
    def read(one: Identified) -> Value | None:
        if one.model is None or not _usable(one, direction, reference):
            return None
        model = one.model.transmission_error()
        fourier = None if model is None else model.direction(sign)
        freedom = series_freedom(one.model, direction)
        return None if fourier is None else amplitude(fourier, order, reference.row(sign), freedom)

    return read


def _stiffness(direction: str, sign: float, reference: Reference) -> Read:
    def read(one: Identified) -> Value | None:
        if one.model is None or not _usable(one, direction, reference):
            return None
        model = one.model.transmission_error()
        fourier = None if model is None else model.direction(sign)
        freedom = series_freedom(one.model, direction)
        return None if fourier is None else stiffness(fourier, reference.row(sign), freedom)

    return read


def _hysteresis(one: Identified, reference: Reference) -> Value | None:
    if one.model is None or not all(_usable(one, name, reference) for name, _, _ in DIRECTIONS):
        return None
    model = one.model.transmission_error()
    sets = [None if model is None else model.direction(sign) for _, sign, _ in DIRECTIONS]
    positive, negative = sets
    if positive is None or negative is None or positive.offset_covariance is None or negative.offset_covariance is None:
        return None
    freedom = min(series_freedom(one.model, name) for name, _, _ in DIRECTIONS)
    return hysteresis(positive, negative, (reference.row(1.0), reference.row(-1.0)), freedom)
