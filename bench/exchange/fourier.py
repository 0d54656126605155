"""The transmission error's Fourier series as a formula: its value, and its slope over the angle."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from bench.exchange import formula, pieces
from bench.exchange.formula import Written, const, make, total
from bench.mismatch.given import Given
from bench.simulation.fourier import FourierSet
from bench.simulation.frame import Frame


def series(given: Given, frame: Frame) -> list[Written]:
    """The series of a simulation, by the direction of motion; empty where it has none."""
    return _by_direction(given, frame, _series_of)


def slope(given: Given, frame: Frame) -> list[Written]:
    """The change of the series with the angle, without orders that an encoder misreads; empty where it has none."""
    return _by_direction(given, frame, _slope_of)


def _by_direction(
    given: Given, frame: Frame, side: Callable[[Given, FourierSet | None, Frame], Written]
) -> list[Written]:
    """What ``side`` says of each direction's series, by the direction of motion; empty where there is no series."""
    model = given.simulation.transmission_error()
    if model is None:
        return []
    sides = [side(given, model.direction(sign), frame) for sign in (1.0, -1.0)]
    return [formula.where(frame.last_direction > 0, *sides)]


def _series_of(given: Given, series: FourierSet | None, frame: Frame) -> Written:
    if series is None:
        return const(0.0)
    parts = [_polynomial(series.offset, frame)]
    for _, sine, cosine, angle in _orders(given, series, frame):
        parts += [make("mul", sine, np.sin(angle)), make("mul", cosine, np.cos(angle))]
    return total(parts)


def _slope_of(given: Given, series: FourierSet | None, frame: Frame) -> Written:
    if series is None:
        return const(0.0)
    parts = []
    for order, sine, cosine, angle in _orders(given, series, frame):
        if order not in given.misread:
            wave = make("sub", make("mul", sine, np.cos(angle)), make("mul", cosine, np.sin(angle)))
            parts.append(make("mul", const(order), wave))
    return total(parts)


def _orders(given: Given, series: FourierSet, frame: Frame) -> Iterator[tuple[float, Written, Written, Written]]:
    """Each order of a side, its sine's and cosine's coefficient with the laws, and its angle."""
    for k, order in enumerate(series.orders):
        size, phase = _polynomial(series.amplitude[k], frame), _polynomial(series.phase[k], frame)
        real, imag = make("mul", size, np.cos(phase)), make("mul", size, np.sin(phase))
        for law in given.laws:
            a, b = pieces.law(law, float(order), frame)
            real, imag = (
                make("sub", make("mul", real, a), make("mul", imag, b)),
                make("add", make("mul", real, b), make("mul", imag, a)),
            )
        yield float(order), real, imag, make("mul", const(float(order)), frame.theta)


def _polynomial(coefficients: Any, frame: Frame) -> Written:
    t, v, c = frame.torque, frame.velocity, frame.temperature
    monomials = [t * t, v * v, c * c, t, v, c, t * v, t * c, v * c, const(1.0)]
    return total([make("mul", const(float(p)), m) for p, m in zip(coefficients, monomials, strict=True)])
