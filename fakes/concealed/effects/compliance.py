"""Transmission-error effects in the offset: lost motion, stiffness, hysteresis, drift, film, temperature; encoder."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.special import erf

from fakes.concealed.effects import kernels
from fakes.concealed.effects.base import Effect, Floats, Run
from fakes.concealed.effects.formula import Derived, Formula, Law, form
from fakes.concealed.truth import Location

_TE = ("transmission_error",)
Rng = np.random.Generator
Shape = dict[str, float]
Memory = dict[str, Any]


def _te(
    effect: str, name: str, law: Law, shape: Shape, claimed: Location | None = None, derived: Derived | None = None
) -> Formula:
    return Formula(effect, name, _TE, 2e-5, shape, claimed or Location(), hook="transmission", law=law, derived=derived)


def _lost(rng: Rng, name: str, profile: str) -> Effect:
    t0 = rng.uniform(30.0, 140.0)

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = run.torque / s["tau_0"]
        if profile == "arctan":
            return -2.0 / np.pi * np.arctan(x)
        if profile == "deadzone":
            return -np.clip(x / 1.5, -1.0, 1.0)
        if profile == "root":
            return -x / np.sqrt(1.0 + x**2)
        if profile == "erf":
            return -np.asarray(erf(x))
        if profile == "slow":
            return -np.sign(x) * (1.0 - (1.0 + np.abs(x)) ** -2.0)
        return -np.sign(x) * (1.0 - np.exp(-np.abs(x)))

    claimed = Location(conditions={"load_torque": [-3.0 * t0, 3.0 * t0]}, core={"load_torque": [-t0, t0]})

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"j_2": (amplitude, "rad"), "tau_j": (s["tau_0"], "N·m")}

    known = derived if profile in ("arctan", "deadzone") else None
    return _te("te.lost_motion", name, law, {"tau_0": t0}, claimed, known)


@form("te.lost_motion", "arctan", in_library=True)
def _lost_arctan(rng: Rng) -> Effect:
    return _lost(rng, "arctan", "arctan")


@form("te.lost_motion", "linear within, saturated beyond", in_library=True)
def _lost_deadzone(rng: Rng) -> Effect:
    return _lost(rng, "linear within, saturated beyond", "deadzone")


@form("te.lost_motion", "exponential saturation")
def _lost_exponential(rng: Rng) -> Effect:
    return _lost(rng, "exponential saturation", "exponential")


@form("te.lost_motion", "error function")
def _lost_erf(rng: Rng) -> Effect:
    return _lost(rng, "error function", "erf")


@form("te.lost_motion", "algebraic sigmoid", in_library=True)
def _lost_root(rng: Rng) -> Effect:
    return _lost(rng, "x/sqrt(1+x²)", "root")


@form("te.lost_motion", "rational approach", held_back=True)
def _lost_slowly(rng: Rng) -> Effect:
    return _lost(rng, "1-1/(1+x)²", "slow")


def _stiff(rng: Rng, name: str, profile: str) -> Effect:
    knee = rng.uniform(380.0, 620.0)

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = run.torque / 1000.0
        if profile == "knee":
            return np.sign(x) * np.clip(np.abs(x) - s["tau_k"] / 1000.0, 0.0, None) * 2.5
        if profile == "sinh":
            return np.asarray(np.sinh(2.5 * x) / np.sinh(2.5))
        if profile == "contact":
            return x**3 / (x**2 + 0.16)
        return x * np.abs(x) ** 1.5

    shape = {"tau_k": knee} if profile == "knee" else {}

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"b_k": (2.5 * amplitude, "rad"), "tau_k": (s["tau_k"], "N·m")}

    return _te("te.stiffness_nonlinear", name, law, shape, None, derived if profile == "knee" else None)


@form("te.stiffness_nonlinear", "two-slope", in_library=True)
def _stiff_knee(rng: Rng) -> Effect:
    return _stiff(rng, "two slopes with a knee", "knee")


@form("te.stiffness_nonlinear", "sinh")
def _stiff_sinh(rng: Rng) -> Effect:
    return _stiff(rng, "sinh", "sinh")


@form("te.stiffness_nonlinear", "contact that fills")
def _stiff_contact(rng: Rng) -> Effect:
    return _stiff(rng, "soft until the contact fills, x³/(x² + 0.16)", "contact")


@form("te.stiffness_nonlinear", "power 2.5", held_back=True, in_library=True)
def _stiff_power(rng: Rng) -> Effect:
    return _stiff(rng, "power 2.5", "power")


def _hysteresis(rng: Rng, name: str, kind: str) -> Effect:
    shape = {"width": rng.uniform(150.0, 350.0)}

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        width = s["width"]
        path = np.append(0.0, run.command)  # between recordings the load is off; ripple is too fast to slide
        if kind == "maxwell":
            breaks = width * np.array([0.25, 0.6, 1.0, 1.8])
            state = memory.setdefault("z", np.zeros(5))
            return -kernels.maxwell_slip(path, breaks, np.array([0.2, 0.3, 0.3, 0.2]), state)[1:]
        state = memory.setdefault("z", np.zeros(2))
        if kind == "bouc_wen":
            return -kernels.bouc_wen(path, 0.8 * width, 0.55, 1.4, state)[1:]
        return -kernels.duhem(path, 0.7 * width, state)[1:]

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"h": (-amplitude, "rad"), "w": (0.7 * s["width"], "N·m")}

    return _te("te.hysteresis", name, law, shape, None, derived if kind == "duhem" else None)


@form("te.hysteresis", "four Maxwell-slip elements on torque")
def _hysteresis_maxwell(rng: Rng) -> Effect:
    return _hysteresis(rng, "four Maxwell-slip elements on torque", "maxwell")


@form("te.hysteresis", "Bouc–Wen on torque")
def _hysteresis_bouc(rng: Rng) -> Effect:
    return _hysteresis(rng, "Bouc–Wen on torque", "bouc_wen")


@form("te.hysteresis", "Duhem on torque", held_back=True, in_library=True)
def _hysteresis_duhem(rng: Rng) -> Effect:
    return _hysteresis(rng, "Duhem on torque", "duhem")


def _drift(rng: Rng, name: str, profile: str) -> Effect:
    pace = rng.uniform(0.15, 0.5)

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = run.clock / run.duration
        if profile == "log":
            return np.asarray(np.log1p(x / (0.2 * s["pace"])) / np.log1p(5.0 / s["pace"]))
        if profile == "creep":
            return 1.0 - np.exp(-x / s["pace"])
        if profile == "power":
            return x**0.4
        if profile == "loosening":
            return 1.0 / (1.0 + np.exp(-(x - 0.3 - s["pace"]) / 0.06))
        return x

    return _te("te.drift_time", name, law, {"pace": pace})


@form("te.drift_time", "linear", in_library=True)
def _drift_linear(rng: Rng) -> Effect:
    return _drift(rng, "linear in time", "linear")


@form("te.drift_time", "creep", in_library=True)
def _drift_creep(rng: Rng) -> Effect:
    return _drift(rng, "exponential creep", "creep")


@form("te.drift_time", "power of time")
def _drift_power(rng: Rng) -> Effect:
    return _drift(rng, "power 0.4 of time", "power")


@form("te.drift_time", "loosens by and by")
def _drift_loosening(rng: Rng) -> Effect:
    return _drift(rng, "loosens within a quarter of an hour", "loosening")


@form("te.drift_time", "logarithmic", held_back=True, in_library=True)
def _drift_log(rng: Rng) -> Effect:
    return _drift(rng, "logarithmic settling", "log")


def _film(rng: Rng, name: str, profile: str) -> Effect:
    v = float(np.deg2rad(rng.uniform(0.6, 1.8)))

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = np.abs(run.rate) / s["v_s"]
        side = np.where(run.side > 0, 1.0, -1.0)
        if profile == "rational":
            return side / (1.0 + x**1.5)
        if profile == "film":
            return -side * (x / (1.0 + x)) ** 0.7
        return side * np.exp(-x)

    claimed = Location(conditions={"velocity": [0.0, 3.0 * v]}, core={"velocity": [0.0, v]})

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"v_o": (amplitude, "rad"), "v_s": (s["v_s"], "rad/s")}

    return _te("te.velocity_nonlinear", name, law, {"v_s": v}, claimed, derived if profile == "exp" else None)


@form("te.velocity_nonlinear", "rational")
def _film_rational(rng: Rng) -> Effect:
    return _film(rng, "rational", "rational")


@form("te.velocity_nonlinear", "exponential", in_library=True)
def _film_exp(rng: Rng) -> Effect:
    return _film(rng, "exponential", "exp")


@form("te.velocity_nonlinear", "film thickness power", held_back=True)
def _film_power(rng: Rng) -> Effect:
    return _film(rng, "film thickness power 0.7", "film")


def _warm(rng: Rng, name: str, profile: str) -> Effect:
    centre, width = rng.uniform(29.0, 36.0), rng.uniform(1.5, 3.5)

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = (run.temperature - s["T_c"]) / s["dT"]
        if profile == "logistic":
            return 1.0 / (1.0 + np.exp(-x))
        if profile == "softening":
            return 0.1 * np.logaddexp(0.0, 1.5 * x)
        return 0.5 + np.arctan(1.5 * x) / np.pi

    return _te("te.temperature_nonlinear", name, law, {"T_c": centre, "dT": width})


@form("te.temperature_nonlinear", "logistic transition", in_library=True)
def _warm_logistic(rng: Rng) -> Effect:
    return _warm(rng, "logistic transition of the grease", "logistic")


@form("te.temperature_nonlinear", "softening beyond a temperature")
def _warm_soft(rng: Rng) -> Effect:
    return _warm(rng, "softening beyond a temperature", "softening")


@form("te.temperature_nonlinear", "arctan transition", held_back=True)
def _warm_arctan(rng: Rng) -> Effect:
    return _warm(rng, "arctan transition", "arctan")


def _encoder(rng: Rng, name: str, multiples: tuple[int, ...]) -> Effect:
    shape = {f"phase_{k}": rng.uniform(-np.pi, np.pi) for k in multiples}

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        shaft = 185.0 * run.theta
        return 185.0 * sum(
            (np.cos(k * shaft + s[f"phase_{k}"]) / (1.0 + 0.8 * i) for i, k in enumerate(multiples)), 0.0 * shaft
        )

    orders = tuple(185.0 * k for k in multiples)
    return Formula(
        "sensor.motor_encoder", name, _TE, 5e-6, shape, Location(orders=orders), hook="motor_encoder", law=law
    )


@form("sensor.motor_encoder", "eccentric disc", in_library=True)
def _encoder_once(rng: Rng) -> Effect:
    return _encoder(rng, "eccentric disc", (1,))


@form("sensor.motor_encoder", "eccentric and elliptic disc", in_library=True)
def _encoder_twice(rng: Rng) -> Effect:
    return _encoder(rng, "eccentric and elliptic disc", (1, 2))


@form("sensor.motor_encoder", "interpolation error", held_back=True, in_library=True)
def _encoder_fine(rng: Rng) -> Effect:
    return _encoder(rng, "two-lobed and four-lobed disc", (2, 4))
