"""Sine and cosine of many angles at once.

A series of a hundred orders at some hundred thousand rows asks for both some ten million times. A compiler can do
eight of these at a time, but not through calls of the C library. So they are written out here: the angle is reduced to
an eighth of a revolution about zero (Cody and Waite, Software Manual for the Elementary Functions, 1980), and Taylor's
series say the rest, to 2e-16 for angles up to a million rad.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numba
import numpy as np
from numpy.typing import NDArray

from bench.simulation.frame import FloatArray

_QUARTER = Fraction("1.57079632679489661923132169163975144209858469968755")
"""of a turn, to fifty digits"""
_BITS = 33
"""of each part of it: products with whole numbers of up to twenty bits are exact"""


def _split(value: Fraction) -> tuple[float, float, float]:
    """A number as a sum of three, the first two with few bits."""
    out = []
    rest = value
    for _ in range(2):
        unit = Fraction(2) ** (math.frexp(float(rest))[1] - _BITS)
        out.append(float(rest // unit * unit))
        rest -= Fraction(out[-1])
    return out[0], out[1], float(rest)


_Q1, _Q2, _Q3 = _split(_QUARTER)
_S3, _S5, _S7, _S9, _S11, _S13, _S15 = (float(Fraction((-1) ** k, math.factorial(2 * k + 1))) for k in range(1, 8))
_C2, _C4, _C6, _C8, _C10, _C12, _C14, _C16 = (float(Fraction((-1) ** k, math.factorial(2 * k))) for k in range(1, 9))


@numba.njit(inline="always")
def cosine_sine(x: float) -> tuple[float, float]:
    """Cosine and sine of an angle in rad; for loops in which nothing else branches."""
    quarters = np.floor(x * (2.0 / np.pi) + 0.5)
    r = ((x - quarters * _Q1) - quarters * _Q2) - quarters * _Q3
    z = r * r
    s = r + r * z * (_S3 + z * (_S5 + z * (_S7 + z * (_S9 + z * (_S11 + z * (_S13 + z * _S15))))))
    c = 1.0 + z * (_C2 + z * (_C4 + z * (_C6 + z * (_C8 + z * (_C10 + z * (_C12 + z * (_C14 + z * _C16)))))))
    quadrant = quarters - 4.0 * np.floor(0.25 * quarters)
    odd = (quadrant == 1.0) or (quadrant == 3.0)
    cosine = s if odd else c
    sine = c if odd else s
    cosine = -cosine if (quadrant == 1.0) or (quadrant == 2.0) else cosine
    sine = -sine if quadrant >= 2.0 else sine
    return cosine, sine


@numba.njit(cache=True)
def summed(angle: FloatArray, orders: FloatArray, amplitude: FloatArray, phase: FloatArray) -> FloatArray:
    """Sum of ``amplitude`` (k, n) times sin(f*angle + ``phase``), (k, n), over ``orders`` f (k,) at angles (n,)."""
    out = np.zeros(angle.size)
    for k in range(orders.size):
        order, a, p = orders[k], amplitude[k], phase[k]
        for i in range(angle.size):
            out[i] += a[i] * cosine_sine(order * angle[i] + p[i])[1]
    return out


@numba.njit(cache=True)
def summed_vectors(angle: FloatArray, orders: FloatArray, real: FloatArray, imag: FloatArray) -> FloatArray:
    """Sum of ``real`` (k, n) times sin(f*angle) and ``imag`` (k, n) times cos(f*angle) over ``orders`` f (k,)."""
    out = np.zeros(angle.size)
    for k in range(orders.size):
        order, a, b = orders[k], real[k], imag[k]
        for i in range(angle.size):
            cosine, sine = cosine_sine(order * angle[i])
            out[i] += a[i] * sine + b[i] * cosine
    return out


@numba.njit(cache=True)
def _phasors(phase: FloatArray, real: FloatArray, imag: FloatArray) -> None:
    for i in range(phase.size):
        real[i], imag[i] = cosine_sine(phase[i])


def phasors(phase: FloatArray) -> NDArray[np.complex128]:
    """exp(j*phase) of phases of any shape."""
    out = np.empty(phase.shape, dtype=np.complex128)
    real, imag = np.empty(phase.size), np.empty(phase.size)
    _phasors(np.ascontiguousarray(phase, dtype=np.float64).ravel(), real, imag)
    out.real, out.imag = real.reshape(phase.shape), imag.reshape(phase.shape)
    return out
