"""What a simulation file's series says of the transmission error, and of its change with the angle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bench.mismatch.given import Given
from bench.simulation import waves
from bench.simulation.fourier import FourierSet
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.free_oscillation import Complex, free_oscillation, over_angle
from bench.simulation.laws import RESONANCE, factor
from bench.simulation.polynomial import basis
from bench.simulation.sines import summed
from bench.simulation.waves import ROWS_AT_ONCE


def periodic_part(given: Given, frame: Frame) -> FloatArray:
    """Series with its laws, offset, and pulses at the rows of a frame (n,), rad."""
    out = np.zeros(frame.size)
    for part, series, monomials, amplitude, phase in _waves(given, frame):
        out[part] = monomials @ series.offset + summed(frame.theta[part], _orders(series), amplitude, phase)
    out = out + swinging(given, frame)
    for pulse in given.pulses:
        out = out + pulse.evaluate(frame.theta)
    return out


def swinging(given: Given, frame: Frame) -> FloatArray:
    """What the modes of resonances swing by freely after changes of speed, at the rows of a frame (n,), rad."""
    out = np.zeros(frame.size)
    for law in given.laws:
        if law.swings:
            out += free_oscillation(law, frame, _all_orders(given), lambda part: _driving(given, part))
    return out


def _all_orders(given: Given) -> FloatArray:
    model = given.simulation.transmission_error()
    sets = (
        []
        if model is None
        else [series for series in (model.direction(1.0), model.direction(-1.0)) if series is not None]
    )
    return np.unique([float(f) for series in sets for f in series.orders])


def _driving(given: Given, frame: Frame) -> Complex:
    """Vectors b + j·a (n, k) of all orders at the rows of a frame, with every law but resonances."""
    orders = _all_orders(given)
    out = np.zeros((frame.size, orders.size), dtype=np.complex128)
    less = replace(given, laws=tuple(law for law in given.laws if law.effect != RESONANCE))
    for part, series, _, amplitude, phase in _waves(less, frame):
        out[np.ix_(part, np.searchsorted(orders, _orders(series)))] = (amplitude * np.exp(1j * phase)).T
    return out


def slope(given: Given, frame: Frame) -> FloatArray:
    """Change of the transmission error with the angle at the rows of a frame (n,), rad/rad.

    Without what the motor's encoder misreads: that moves nothing.
    """
    out = np.zeros(frame.size)
    for part, series, _, amplitude, phase in _waves(given, frame):
        orders = _orders(series)
        steeper = amplitude * np.where(np.isin(orders, given.misread), 0.0, orders)[:, None]
        out[part] = summed(frame.theta[part], orders, steeper, phase + 0.5 * np.pi)
    further = [w.slope for w in given.acting_waves]
    if further:
        out = out + waves.evaluate(further, frame.theta, frame)
    for pulse in given.pulses:
        out = out + pulse.slope(frame.theta)
    if any(law.swings for law in given.laws):
        out = out + over_angle(swinging(given, frame), frame)
    return out


def _orders(series: FourierSet) -> FloatArray:
    return np.asarray(series.orders, dtype=np.float64)


def _waves(given: Given, frame: Frame) -> Iterator[tuple[IntArray, FourierSet, FloatArray, FloatArray, FloatArray]]:
    """Rows of a frame in parts, each with the series of its direction, the monomials there (n, 10), amplitude and phase
    of the orders with their laws (k, n).
    """
    model = given.simulation.transmission_error()
    x = frame.states
    for sign in (1.0, -1.0):
        series = None if model is None else model.direction(sign)
        rows = np.flatnonzero(frame.last_direction > 0 if sign > 0 else frame.last_direction <= 0)
        if series is None or rows.size == 0:
            continue
        for a in range(0, rows.size, ROWS_AT_ONCE):
            part = rows[a : a + ROWS_AT_ONCE]
            monomials = basis(*x[part].T)
            amplitude, phase = series.amplitude @ monomials.T, series.phase @ monomials.T
            for law in given.laws:
                by = factor(law, x[part], frame.time[part], [float(f) for f in series.orders]).T
                amplitude, phase = amplitude * np.abs(by), phase + np.angle(by)
            yield part, series, monomials, amplitude, phase
