"""Nominal transmission error: the polynomial Fourier series and its offset (equation 1 of the bench, paper eq. 3, 4).

The series itself is evaluated and calibrated by its own code (amplitude and phase are polynomials, so it is not linear
in its parameters); here stand the offset's regressors and, for the series, one order's with constant amplitude.
"""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns

PAPER_ORDERS = (1, 3, 4, 6, 9, 12, 13, 14, 18, 19, 24, 27, 46, 90, 92, 135, 138, 180, 184, 276)
CENTRE = (0.0, 0.0, 35.0)
"""of torque in N*m, velocity in rad/s, temperature in degC, in the offset's scaled monomials"""
SPREAD = (1000.0, 0.1, 15.0)
REFERENCE = "Bauer et al., ICIT 2025, eq. 3 and 4"


def monomials(frame: Frame) -> FloatArray:
    """The paper's ten monomials (n, 10) of torque, velocity and temperature, scaled to the order of one."""
    tau, v, t = (
        (x - centre) / spread
        for x, centre, spread in zip((frame.torque, frame.velocity, frame.temperature), CENTRE, SPREAD, strict=True)
    )
    return columns(tau**2, v**2, t**2, tau, v, t, tau * v, tau * t, v * t, np.ones(frame.size))


def _offset(frame: Frame, _: Point) -> FloatArray:
    basis = monomials(frame)
    forward = (frame.last_direction > 0)[:, None]
    return np.hstack([np.where(forward, basis, 0.0), np.where(forward, 0.0, basis)])


def _grid(_: Frame) -> tuple[Point, ...]:
    return tuple((float(order),) for order in PAPER_ORDERS)


def _order(frame: Frame, point: Point) -> FloatArray:
    angle = point[0] * frame.theta
    return columns(np.cos(angle), np.sin(angle))


_NAMES = ("tau^2", "v^2", "T^2", "tau", "v", "T", "tau*v", "tau*T", "v*T", "1")
_SYMBOLS = tuple(
    Symbol(f"a0_{side}_{name}", "rad", f"offset, {word} direction, scaled monomial {name}")
    for side, word in (("p", "positive"), ("n", "negative"))
    for name in _NAMES
)

OFFSET = Term(
    effect="te.offset",
    name="offset of the transmission error with its polynomial (compliance)",
    equation="TE += a0_d(tau, dtheta, T)",
    reference=REFERENCE,
    where="transmission_error's mean, by torque above all",
    forms={TRANSMISSION_ERROR: (Form("nominal", _offset, _SYMBOLS),)},
    nominal=True,
    variables=("torque",),
)
FOURIER = Term(
    effect="te.fourier",
    name="polynomial Fourier series of the transmission error",
    equation="TE += sum_k A_k(tau, dtheta, T)*sin(f_k*theta + phi_k(tau, dtheta, T))",
    reference=REFERENCE,
    where="transmission_error at the series' orders",
    forms={
        TRANSMISSION_ERROR: (
            Form(
                "order",
                _order,
                (Symbol("c", "rad", "cosine amplitude"), Symbol("s", "rad", "sine amplitude")),
                (Symbol("f", "1", "order per output revolution", 0.0),),
                _grid,
                equation="TE += c*cos(f*theta) + s*sin(f*theta)",
            ),
        )
    },
    nominal=True,
    variables=("angle",),
)
TERMS = (FOURIER, OFFSET)
