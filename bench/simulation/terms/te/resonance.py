"""Amplitude and phase of the orders follow a second-order resonance in f times the speed.

Unlike other terms it multiplies what the simulation has: order f at speed v is excited at f*v rad/s and answered by
H(f*v) = 1/(1 - (f*v/w_0)**2 + 2j*zeta*f*v/w_0). The speed has its sign: a response lags in time, so over the angle it
lags in one direction and leads in the other. Where the speed is taken without its sign, the phase over the angle is
the same in both directions. A force that moves a mass on a spring adds H - 1 to what it moves slowly,
a base that carries it (f*v/w_0)**2*H. The regressor of the library is H - 1 for one order of unit amplitude; the
analysis applies both to the simulation's own amplitudes.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns

ZETAS = (0.02, 0.04, 0.08, 0.15, 0.3)


def by_force(frequency: FloatArray, natural: float, damping: float) -> NDArray[np.complex128]:
    """What a mode adds to one that a force moves slowly, H - 1, at ``frequency`` in rad/s, below zero in negative
    direction.
    """
    return _added(frequency, natural, damping, False)


def by_base(frequency: FloatArray, natural: float, damping: float) -> NDArray[np.complex128]:
    """What a mode adds to the motion of the base that carries it, r²·H, at the same."""
    return _added(frequency, natural, damping, True)


def by_force_unsigned(frequency: FloatArray, natural: float, damping: float) -> NDArray[np.complex128]:
    """H - 1 at the ``frequency`` in rad/s without its sign: the phase over the angle is the same in both directions.
    No mass on a spring answers so, but whoever writes a response over the angle may take the speed without its sign.
    """
    return _added(np.abs(frequency), natural, damping, False)


def _added(frequency: FloatArray, natural: float, damping: float, carried: bool) -> NDArray[np.complex128]:
    flat = np.ascontiguousarray(frequency, dtype=np.float64).ravel()
    return _of_each(flat, natural, damping, carried).reshape(np.shape(frequency))


@numba.njit(cache=True)
def _of_each(frequency: FloatArray, natural: float, damping: float, carried: bool) -> NDArray[np.complex128]:
    """r²·H of a mode that is ``carried``, else H - 1, for each frequency (n,); H = 1/(1 - r² + 2jζr)."""
    out = np.empty(frequency.size, dtype=np.complex128)
    for i in range(frequency.size):
        r = frequency[i] / natural
        real, imag = 1.0 - r * r, 2.0 * damping * r
        size = real * real + imag * imag
        real, imag = real / size, -imag / size
        out[i] = complex(r * r * real, r * r * imag) if carried else complex(real - 1.0, imag)
    return out


def _grid(frame: Frame) -> tuple[Point, ...]:
    fastest = float(np.percentile(np.abs(frame.velocity), 99)) or 0.1
    naturals = np.geomspace(2.0 * fastest, 500.0 * fastest, 60)
    return tuple((order, float(w), z) for order in (46.0,) for w in naturals for z in ZETAS)


def _one_order(frame: Frame, point: Point) -> FloatArray:
    order, natural, damping = point
    wave = np.exp(1j * order * frame.theta) * by_force(order * frame.velocity, natural, damping)
    return columns(wave.real, wave.imag)


A_C = Symbol("a_c", "rad", "real part of the order's quasi-static amplitude")
A_S = Symbol("a_s", "rad", "imaginary part of the order's quasi-static amplitude")
F = Symbol("f", "1", "order", 0.0)
W_0 = Symbol("w_0", "rad/s", "natural frequency", 0.0)
ZETA = Symbol("zeta", "1", "damping ratio", 0.0, 1.0)

TERM = Term(
    effect="te.resonance",
    name="resonance of the transmission error",
    equation="A_f -> A_f*H(f*dtheta), H(w) = 1/(1 - (w/w_0)**2 + 2j*zeta*w/w_0)",
    reference="Tuttle and Seering, IEEE Trans. Robot. Autom. 12 (1996) 368",
    where="transmission_error: amplitudes and phases of the orders f with f*dtheta near w_0",
    forms={
        TRANSMISSION_ERROR: (
            Form(
                "second_order",
                _one_order,
                (A_C, A_S),
                (F, W_0, ZETA),
                _grid,
                equation=(
                    "TE += a_c*Re(W) + a_s*Im(W), W = exp(1j*f*theta)*(H(f*dtheta) - 1), "
                    "H(w) = 1/(1 - (w/w_0)**2 + 2j*zeta*w/w_0)"
                ),
            ),
        )
    },
    variables=("order_frequency",),
)
