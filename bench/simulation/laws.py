"""Laws that the amplitudes of the known orders may follow: a factor on an order's vector at a state and a time.

A resonance multiplies by 1 + p·G(f·v), with G what its mode adds and v with its sign (one form: without it), or by
1 + ε_f·G(f·v) where each order moves the mode with a strength of its own; every other law by 1 + ε_f·g, with g one of
the functions of the table below. What g is referred to (begin and length of the campaign, lowest temperature, largest
torque) is kept with the law, so that it says the same on any rows and in any simulation file.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import ConfigurationError
from bench.simulation._coefficients import order_key
from bench.simulation.frame import FloatArray
from bench.simulation.terms.te.resonance import by_base, by_force, by_force_unsigned

Complex = NDArray[np.complex128]
RESONANCE = "te.resonance"
MODES: dict[str, Callable[[FloatArray, float, float], Complex]] = {
    "second_order": by_force,
    "second_order_of_base": by_base,
    "second_order_unsigned": by_force_unsigned,
}
"""forms of a resonance: what a mode adds at frequencies in rad/s, by its natural frequency and damping"""
EACH: dict[str, Callable[[FloatArray, float, float], Complex]] = {"second_order_of_base_each": by_base}
"""the same where each order moves the mode with a strength of its own: what excites it is not what the encoders see"""

UNSIGNED = ("second_order_unsigned",)
"""forms of a resonance that take the speed without its sign: no mass on a spring"""


@dataclass(frozen=True, slots=True)
class Reference:
    """What a law's quantities are referred to: ``start`` and ``span`` of the campaign in s, its ``coldest`` temperature
    in °C, its ``largest`` torque in N·m.
    """

    start: float = 0.0
    span: float = 1.0
    coldest: float = 0.0
    largest: float = 1.0

    @classmethod
    def of(cls, x: FloatArray, time: FloatArray) -> Reference:
        """Take the reference from states (n, 3) and times (n,)."""
        return cls(
            float(time.min()),
            max(float(np.ptp(time)), 1.0),
            float(x[:, 2].min()),
            max(float(np.abs(x[:, 0]).max()), 1.0),
        )


@dataclass(frozen=True, slots=True)
class Law:
    """A law the known orders follow: its effect, form, nonlinear parameters, gain of log-likelihood, the orders it
    touches, and the strength ε of each order in ``series`` (0 where it does not touch one).
    """

    effect: str
    form: str
    point: tuple[float, ...]
    gain: float
    orders: tuple[float, ...]
    strength: Complex = field(repr=False)
    variables: tuple[str, ...] = ()
    reference: Reference = Reference()
    series: tuple[float, ...] = ()

    @property
    def swings(self) -> bool:
        """Whether something swings freely after a change of speed: that of a mass on a spring."""
        return self.effect == RESONANCE and self.form not in UNSIGNED

    def equation(self) -> str:
        """g of a law that is no resonance, with its nonlinear parameters g_1, g_2."""
        ref = self.reference
        return EQUATIONS[self.effect, self.form].format(
            start=f"{ref.start:.0f} s",
            span=f"{ref.span:.0f} s",
            coldest=f"{ref.coldest:.4g} degC",
            largest=f"{ref.largest:.0f} N*m",
        )

    def to_json(self) -> dict[str, Any]:
        """The law as a simulation file has it."""
        strength = {
            order_key(float(f)): [float(e.real), float(e.imag)]
            for f, e in zip(self.series, self.strength, strict=True)
            if self.form not in MODES and e != 0
        }
        ref = self.reference
        return {
            "form": self.form,
            "point": list(self.point),
            "orders": list(self.orders),
            "strength": strength,
            "reference": {"start": ref.start, "span": ref.span, "coldest": ref.coldest, "largest": ref.largest},
        }


def from_json(effect: str, row: dict[str, Any]) -> Law:
    """Read a law from a simulation file. Raises ConfigurationError where a number is missing or no such law is."""
    try:
        touched = tuple(float(f) for f in row["orders"])
        strength = {float(f): complex(*value) for f, value in row.get("strength", {}).items()}
        law = Law(
            effect,
            str(row["form"]),
            tuple(float(v) for v in row["point"]),
            0.0,
            touched,
            np.array(list(strength.values()), dtype=np.complex128),
            (),
            Reference(**{name: float(value) for name, value in row.get("reference", {}).items()}),
            tuple(strength),
        )
    except (KeyError, TypeError, ValueError) as error:
        raise ConfigurationError(
            f"the simulation's law of {effect} should have form, point, orders, strength and reference ({error!r})"
        ) from error
    forms = (*MODES, *EACH) if effect == RESONANCE else tuple(form for owner, form in FUNCTIONS if owner == effect)
    if law.form not in forms:
        raise ConfigurationError(
            f"the simulation's law of {effect} has the form {law.form!r}, which should be one of {', '.join(forms)}"
        )
    return law


# (speed, torque, temperature, time, point, reference) -> g
Function = Callable[[FloatArray, FloatArray, FloatArray, FloatArray, tuple[float, ...], Reference], FloatArray]
FUNCTIONS: dict[tuple[str, str], Function] = {
    ("te.velocity_nonlinear", "exponential"): lambda v, m, c, t, p, r: np.exp(-v / p[0]),
    ("te.velocity_nonlinear", "rational"): lambda v, m, c, t, p, r: 1.0 / (1.0 + v / p[0]),
    ("te.temperature_nonlinear", "exponential"): lambda v, m, c, t, p, r: np.exp(-(c - r.coldest) / p[0]),
    ("te.temperature_nonlinear", "transition"): lambda v, m, c, t, p, r: np.tanh((c - p[0]) / p[1]),
    ("te.velocity_nonlinear", "band"): lambda v, m, c, t, p, r: np.exp(-(((v - p[0]) / p[1]) ** 2)),
    ("te.temperature_nonlinear", "band"): lambda v, m, c, t, p, r: np.exp(-(((c - p[0]) / p[1]) ** 2)),
    ("te.drift_time", "linear"): lambda v, m, c, t, p, r: (t - r.start) / r.span,
    ("te.drift_time", "creep"): lambda v, m, c, t, p, r: 1.0 - np.exp(-np.maximum(t - r.start, 0.0) / r.span / p[0]),
    ("unknown", "amplitude in a band of load"): lambda v, m, c, t, p, r: np.exp(-(((m - p[0]) / p[1]) ** 2)),
    ("unknown", "amplitude in a band of speed"): lambda v, m, c, t, p, r: np.exp(-(((v - p[0]) / p[1]) ** 2)),
    ("unknown", "amplitude in a band of temperature"): lambda v, m, c, t, p, r: np.exp(-(((c - p[0]) / p[1]) ** 2)),
    ("unknown", "amplitude over load"): lambda v, m, c, t, p, r: (m / r.largest) ** 3,
    ("unknown", "amplitude about zero load"): lambda v, m, c, t, p, r: np.tanh(m / (p[0] * r.largest)),
}
EQUATIONS: dict[tuple[str, str], str] = {
    ("te.velocity_nonlinear", "exponential"): "exp(-abs(dtheta)/g_1)",
    ("te.velocity_nonlinear", "rational"): "1/(1 + abs(dtheta)/g_1)",
    ("te.temperature_nonlinear", "exponential"): "exp(-(T - {coldest})/g_1)",
    ("te.temperature_nonlinear", "transition"): "tanh((T - g_1)/g_2)",
    ("te.velocity_nonlinear", "band"): "exp(-((abs(dtheta) - g_1)/g_2)**2)",
    ("te.temperature_nonlinear", "band"): "exp(-((T - g_1)/g_2)**2)",
    ("te.drift_time", "linear"): "(t - {start})/({span})",
    ("te.drift_time", "creep"): "1 - exp(-max(t - {start}, 0)/({span})/g_1)",
    ("unknown", "amplitude in a band of load"): "exp(-((tau - g_1)/g_2)**2)",
    ("unknown", "amplitude in a band of speed"): "exp(-((abs(dtheta) - g_1)/g_2)**2)",
    ("unknown", "amplitude in a band of temperature"): "exp(-((T - g_1)/g_2)**2)",
    ("unknown", "amplitude over load"): "(tau/({largest}))**3",
    ("unknown", "amplitude about zero load"): "tanh(tau/(g_1*({largest})))",
}
"""the same for people"""


def value(
    effect: str, form: str, point: tuple[float, ...], x: FloatArray, time: FloatArray, reference: Reference
) -> FloatArray:
    """g of a law of the form 1 + ε·g at states (n, 3) and times (n,)."""
    return FUNCTIONS[effect, form](np.abs(x[:, 1]), x[:, 0], x[:, 2], time, point, reference)


def resonant(form: str, frequency: FloatArray, point: tuple[float, ...]) -> Complex:
    """1 + p·G at frequencies in rad/s, below zero in negative direction: ``point`` natural frequency, damping, and the
    mode's participation p (1 where it is not given).
    """
    participation = point[2] if len(point) > 2 else 1.0
    return np.asarray(1.0 + participation * MODES[form](frequency, point[0], point[1]))


def factor(law: Law, x: FloatArray, time: FloatArray, orders: Sequence[float]) -> Complex:
    """The law's factor on the vectors of ``orders`` at states (n, 3) and times (n,), (n, orders)."""
    if law.effect == RESONANCE:
        frequency = x[:, 1][:, None] * np.asarray(orders)[None, :]
        if law.form in EACH:
            return np.asarray(1.0 + EACH[law.form](frequency, *law.point[:2]) * strengths(law, orders)[None, :])
        touched = np.isin(np.asarray(orders), np.asarray(law.orders))
        return np.where(touched[None, :], resonant(law.form, frequency, law.point), 1.0)
    g = value(law.effect, law.form, law.point, x, time, law.reference)
    return np.asarray(1.0 + g[:, None] * strengths(law, orders)[None, :])


def strengths(law: Law, orders: Sequence[float]) -> Complex:
    """Strength ε of some orders (k,) in a law, 0 where it does not touch one."""
    strength_of = dict(zip(law.series, law.strength, strict=True))
    return np.array([strength_of.get(float(f), 0.0) for f in orders], dtype=np.complex128)
