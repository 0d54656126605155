"""Torsional stiffness that hardens, or changes by pieces, beyond the quadratic."""

from __future__ import annotations

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms.base import TRANSMISSION_ERROR, Form, Point, Symbol, Term, columns, top


def _cubic(frame: Frame, _: Point) -> FloatArray:
    x = frame.torque_level / 1000.0
    return columns(x**3)


def _odd_square(frame: Frame, _: Point) -> FloatArray:
    x = frame.torque_level / 1000.0
    return columns(x * np.abs(x))


def _knees(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.torque)
    return tuple((share * largest,) for share in (0.45, 0.55, 0.65, 0.75, 0.85))


def _piecewise(frame: Frame, point: Point) -> FloatArray:
    return columns(np.sign(frame.torque_level) * np.maximum(np.abs(frame.torque_level) - point[0], 0.0) / 1000.0)


def _wide_knees(frame: Frame) -> tuple[Point, ...]:
    return tuple((knee, share * knee) for (knee,) in _knees(frame)[::2] for share in (0.1, 0.3))


def _smooth_knee(frame: Frame, point: Point) -> FloatArray:
    knee, width = point
    x = (np.abs(frame.torque_level) - knee) / width
    # log(1 + exp(x)), which does not overflow
    beyond = np.maximum(x, 0.0) + np.log1p(np.exp(-np.abs(x))) - np.log1p(np.exp(-knee / width))
    return columns(np.sign(frame.torque_level) * width * beyond / 1000.0)


def _exponents(_: Frame) -> tuple[Point, ...]:
    return ((2.4,), (3.0,), (3.6,), (4.5,))


def _power(frame: Frame, point: Point) -> FloatArray:
    return columns(np.sign(frame.torque_level) * np.abs(frame.torque_level / 1000.0) ** point[0])


def _soft_scales(frame: Frame) -> tuple[Point, ...]:
    largest = top(frame.torque)
    return tuple((share * largest,) for share in (0.6, 0.8, 1.1))


def _softening(frame: Frame, point: Point) -> FloatArray:
    return columns(np.arctan(frame.torque_level / point[0]))


B_3 = Symbol("b_3", "rad", "cubic part at 1 kN*m")
B_2 = Symbol("b_2", "rad", "odd quadratic part at 1 kN*m")
B_P = Symbol("b_p", "rad", "hardening part at 1 kN*m")
EXPONENT = Symbol("n", "1", "exponent of the torque", 1.0)
B_K = Symbol("b_k", "rad", "change of the compliance beyond the knee, per kN*m")
B_A = Symbol("b_a", "rad", "amplitude of the arctangent")
KNEE = Symbol("tau_k", "N*m", "torque of the knee", 0.0)
WIDTH = Symbol("w_k", "N*m", "how far about the knee the compliance changes", 0.0)

TERM = Term(
    effect="te.stiffness_nonlinear",
    name="nonlinear torsional stiffness",
    equation="TE += b_3*(tau/1 kN*m)**3; or a knee: b_k*sgn(tau)*max(abs(tau) - tau_k, 0)/(1 kN*m)",
    reference="Ruderman, Hoffmann, Bertram, IEEE Trans. Ind. Electron. 56 (2009) 3840",
    where="transmission_error's offset at high torque",
    forms={
        TRANSMISSION_ERROR: (
            Form("power", _power, (B_P,), (EXPONENT,), _exponents, equation="TE += b_p*sgn(tau)*abs(tau/(1 kN*m))**n"),
            Form("cubic", _cubic, (B_3,), equation="TE += b_3*(tau/(1 kN*m))**3"),
            Form("odd_square", _odd_square, (B_2,), equation="TE += b_2*tau*abs(tau)/(1 kN*m)**2"),
            Form(
                "piecewise",
                _piecewise,
                (B_K,),
                (KNEE,),
                _knees,
                equation="TE += b_k*sgn(tau)*max(abs(tau) - tau_k, 0)/(1 kN*m)",
            ),
            Form(
                "smooth_knee",
                _smooth_knee,
                (B_K,),
                (KNEE, WIDTH),
                _wide_knees,
                equation=(
                    "TE += b_k*sgn(tau)*w_k*(log(1 + exp((abs(tau) - tau_k)/w_k)) - log(1 + exp(-tau_k/w_k)))/(1 kN*m)"
                ),
            ),
            Form("arctan", _softening, (B_A,), (KNEE,), _soft_scales, equation="TE += b_a*arctan(tau/tau_k)"),
        )
    },
    variables=("torque",),
    shape={TRANSMISSION_ERROR: (("torque", "1"),)},
    any_function=True,
)
