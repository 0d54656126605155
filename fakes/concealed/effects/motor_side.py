"""Effects in the input motor's torque: friction, ripple, torque constant, unbalance."""

from __future__ import annotations

from typing import Any

import numpy as np

from fakes.concealed.effects import kernels
from fakes.concealed.effects.base import Effect, Floats, Run
from fakes.concealed.effects.formula import Derived, Formula, Law, form
from fakes.concealed.truth import Location

_MOTOR = ("motor_torque",)
Rng = np.random.Generator
Shape = dict[str, float]
Memory = dict[str, Any]
Natural = tuple[tuple[str, str, str], ...]
_STRIBECK: Natural = (("f_s", "", "N·m"), ("w_s", "w_s", "rad/s"))


def _friction(
    effect: str,
    name: str,
    law: Law,
    shape: Shape,
    amplitude: float,
    claimed: Location | None = None,
    natural: Natural = (),
    derived: Derived | None = None,
) -> Formula:
    claimed = claimed or Location()
    return Formula(
        effect, name, _MOTOR, amplitude, shape, claimed, hook="friction", law=law, natural=natural, derived=derived
    )


def _stribeck(rng: Rng, name: str, profile: str, natural: Natural = ()) -> Effect:
    w_s = rng.uniform(4.0, 12.0)

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = np.abs(run.motor_rate) / s["w_s"]
        if profile == "rational":
            return run.sign / (1.0 + x**2)
        if profile == "tustin":
            return run.sign * np.exp(-x)
        if profile == "root":
            return run.sign * np.exp(-np.sqrt(2.0 * x))
        if profile == "sech":
            return run.sign / np.cosh(x)
        return run.sign * np.exp(-(x**2))

    claimed = Location(conditions={"velocity": [0.0, 2.5 * w_s / 185.0]}, core={"velocity": [0.0, w_s / 185.0]})
    return _friction("friction.stribeck", name, law, {"w_s": w_s}, 0.3, claimed, natural)


@form("friction.stribeck", "rational", in_library=True)
def _stribeck_rational(rng: Rng) -> Effect:
    return _stribeck(rng, "rational (Hess and Soom)", "rational", _STRIBECK)


@form("friction.stribeck", "Gaussian", in_library=True)
def _stribeck_gauss(rng: Rng) -> Effect:
    return _stribeck(rng, "Gaussian", "gaussian", _STRIBECK)


@form("friction.stribeck", "Tustin", in_library=True)
def _stribeck_tustin(rng: Rng) -> Effect:
    return _stribeck(rng, "exponential (Tustin)", "tustin", _STRIBECK)


@form("friction.stribeck", "root exponential")
def _stribeck_root(rng: Rng) -> Effect:
    return _stribeck(rng, "exponential of the root of speed", "root")


@form("friction.stribeck", "hyperbolic secant", held_back=True)
def _stribeck_sech(rng: Rng) -> Effect:
    return _stribeck(rng, "hyperbolic secant", "sech")


def _viscosity(rng: Rng, name: str, profile: str) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        kelvin = run.temperature + 273.15
        if profile == "arrhenius":
            ratio = np.exp(5200.0 * (1.0 / kelvin - 1.0 / 298.15))
        elif profile == "walther":
            loglog = 10.0 ** (10.0 ** (8.6 - 3.4 * np.log10(kelvin)))
            at25 = 10.0 ** (10.0 ** (8.6 - 3.4 * np.log10(298.15)))
            ratio = (loglog - 0.7) / (at25 - 0.7)
        elif profile == "slotte":
            ratio = (75.0 / (run.temperature + 50.0)) ** 4
        else:
            ratio = np.exp(900.0 / (run.temperature + 75.0) - 9.0)
        return run.motor_rate * ratio

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"f_e": (amplitude, "N·m·s/rad"), "beta": (5200.0 / 298.15**2, "1/K")}

    known = derived if profile == "arrhenius" else None
    return _friction("friction.viscous_temperature", name, law, {}, 0.01, derived=known)


@form("friction.viscous_temperature", "Arrhenius", in_library=True)
def _viscosity_arrhenius(rng: Rng) -> Effect:
    return _viscosity(rng, "Arrhenius", "arrhenius")


@form("friction.viscous_temperature", "Vogel", in_library=True)
def _viscosity_vogel(rng: Rng) -> Effect:
    return _viscosity(rng, "Vogel", "vogel")


@form("friction.viscous_temperature", "Slotte")
def _viscosity_slotte(rng: Rng) -> Effect:
    return _viscosity(rng, "Slotte", "slotte")


@form("friction.viscous_temperature", "Walther", held_back=True)
def _viscosity_walther(rng: Rng) -> Effect:
    return _viscosity(rng, "Walther (ASTM D341)", "walther")


def _churning(rng: Rng, name: str, power: float) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return run.sign * np.abs(run.motor_rate) ** s["power"]

    natural: Natural = (("f_q", "", "N·m·s²/rad²"),) if power == 2.0 else ()
    return _friction("friction.viscous_quadratic", name, law, {"power": power}, 3e-4, None, natural)


@form("friction.viscous_quadratic", "square of speed", in_library=True)
def _churning_square(rng: Rng) -> Effect:
    return _churning(rng, "square of speed", 2.0)


@form("friction.viscous_quadratic", "churning beyond a speed")
def _churning_threshold(rng: Rng) -> Effect:
    onset = rng.uniform(12.0, 25.0)

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return run.sign * np.clip(np.abs(run.motor_rate) - s["onset"], 0.0, None) ** 1.5

    return _friction("friction.viscous_quadratic", "churning beyond a speed", law, {"onset": onset}, 1e-3)


@form("friction.viscous_quadratic", "power 1.8", held_back=True, in_library=True)
def _churning_power(rng: Rng) -> Effect:
    return _churning(rng, "turbulent drag, power 1.8", 1.8)


def _by_angle(rng: Rng, name: str, profile: str) -> Effect:
    order = float(rng.choice([1, 2, 3, 4]))
    shape = {"order": order, "phase": rng.uniform(-np.pi, np.pi)}
    orders: tuple[float, ...] = (order,)
    windows: tuple[tuple[float, float], ...] = ()
    core: tuple[tuple[float, float], ...] = ()
    if profile == "bump":
        windows, core = (((shape["phase"] - half, shape["phase"] + half),) for half in (1.0, 0.4))
        orders = ()

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        if profile == "bump":
            return run.sign * np.exp(4.0 * (np.cos(run.theta - s["phase"]) - 1.0))
        wave = np.cos(s["order"] * run.theta - s["phase"])
        if profile == "product":
            return run.sign * wave * (0.6 + 0.4 * np.abs(run.torque) / 500.0)
        return run.sign * (wave + 0.3 * np.cos(2.0 * s["order"] * run.theta + s["phase"]))

    return _friction(
        "friction.position_dependent",
        name,
        law,
        shape,
        0.1,
        Location(orders=orders, angle_windows=windows, core_windows=core),
    )


@form("friction.position_dependent", "two harmonics", in_library=True)
def _by_angle_wave(rng: Rng) -> Effect:
    return _by_angle(rng, "wave with overtone", "wave")


@form("friction.position_dependent", "wave that grows with load", in_library=True)
def _by_angle_load(rng: Rng) -> Effect:
    return _by_angle(rng, "wave that grows with load", "product")


@form("friction.position_dependent", "tight spot", held_back=True)
def _by_angle_bump(rng: Rng) -> Effect:
    return _by_angle(rng, "tight spot (von Mises bump)", "bump")


def _run_in(rng: Rng, name: str, profile: str) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        share = run.clock / run.duration if profile == "time" else run.travel / s["total"]
        if profile == "power":
            return run.sign * (1.0 + 12.0 * share) ** -0.8
        if profile == "stretched":
            return np.asarray(run.sign * np.exp(-np.sqrt(share / (0.5 * s["pace"]))))
        return run.sign * np.exp(-share / s["pace"])

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"f_r": (amplitude, "N·m"), "s_r": (s["pace"] * s["total"], "rad")}

    shape = {"pace": rng.uniform(0.15, 0.4), "total": 1500.0}
    return _friction("friction.run_in", name, law, shape, 0.2, derived=derived if profile == "distance" else None)


@form("friction.run_in", "exponential in distance", in_library=True)
def _run_in_distance(rng: Rng) -> Effect:
    return _run_in(rng, "exponential in distance", "distance")


@form("friction.run_in", "exponential in time", in_library=True)
def _run_in_time(rng: Rng) -> Effect:
    return _run_in(rng, "exponential in time", "time")


@form("friction.run_in", "stretched exponential")
def _run_in_stretched(rng: Rng) -> Effect:
    return _run_in(rng, "stretched exponential in distance", "stretched")


@form("friction.run_in", "power of distance", held_back=True)
def _run_in_power(rng: Rng) -> Effect:
    return _run_in(rng, "power of distance", "power")


def _presliding(rng: Rng, name: str, profile: str) -> Effect:
    distance = np.deg2rad(rng.uniform(0.3, 1.2))

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        breaks = s["reach"] * np.array([0.4, 2.0] if profile == "two" else [0.3, 0.8, 1.6, 3.0])
        slips = breaks.size if profile in ("maxwell", "two") else 1
        state = memory.setdefault("z", np.append(np.zeros(slips), run.theta[0]))
        if profile == "dahl":
            z = kernels.duhem(run.theta, s["reach"], state)
        elif profile == "lugre":
            z = kernels.lugre(run.rate, 1.0 / run.rate_hz, s["reach"], 0.02, 0.0, state)
        else:
            z = kernels.maxwell_slip(run.theta, breaks, np.full(slips, 1.0 / slips), state)
        return z - run.sign

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"f_d": (amplitude, "N·m"), "s_d": (185.0 * s["reach"], "rad")}

    known = derived if profile == "dahl" else None
    return _friction("friction.presliding", name, law, {"reach": distance}, 0.4, derived=known)


@form("friction.presliding", "Dahl", in_library=True)
def _presliding_dahl(rng: Rng) -> Effect:
    return _presliding(rng, "Dahl", "dahl")


@form("friction.presliding", "LuGre", in_library=True)
def _presliding_lugre(rng: Rng) -> Effect:
    return _presliding(rng, "LuGre", "lugre")


@form("friction.presliding", "two asperities")
def _presliding_two(rng: Rng) -> Effect:
    return _presliding(rng, "two elements that slip one after the other", "two")


@form("friction.presliding", "Maxwell slip", held_back=True)
def _presliding_maxwell(rng: Rng) -> Effect:
    return _presliding(rng, "generalised Maxwell slip", "maxwell")


def _ripple(rng: Rng, name: str, profile: str) -> Effect:
    shape = {"phase": rng.uniform(-np.pi, np.pi)}

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        shaft = 24.0 * 185.0 * run.theta
        wave = np.cos(shaft + s["phase"])
        if profile == "current":
            return wave * run.motor_torque / 3.0
        if profile == "cogging":
            return wave + 0.4 * np.cos(2.0 * shaft - s["phase"])
        return wave

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {
            "a_rc": (amplitude * np.cos(s["phase"]), "N·m"),
            "a_rs": (-amplitude * np.sin(s["phase"]), "N·m"),
        }

    return Formula(
        "motor.torque_ripple",
        name,
        _MOTOR,
        0.05,
        shape,
        Location(orders=(4440.0,)),
        hook="motor_reading",
        law=law,
        derived=derived if profile == "constant" else None,
    )


@form("motor.torque_ripple", "constant sixth electrical harmonic", in_library=True)
def _ripple_constant(rng: Rng) -> Effect:
    return _ripple(rng, "sixth electrical harmonic", "constant")


@form("motor.torque_ripple", "in proportion to the current")
def _ripple_current(rng: Rng) -> Effect:
    return _ripple(rng, "sixth harmonic in proportion to the current", "current")


@form("motor.torque_ripple", "sixth and twelfth", held_back=True, in_library=True)
def _ripple_cogging(rng: Rng) -> Effect:
    return _ripple(rng, "sixth and twelfth electrical harmonic", "cogging")


def _constant(rng: Rng, name: str, profile: str) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        m = run.motor_torque
        if profile == "saturation":
            return 4.0 * np.tanh(m / 4.0) - m
        if profile == "soft":
            return -m * m**2 / (m**2 + 30.0)
        return m

    return Formula(
        "motor.torque_constant",
        name,
        _MOTOR,
        0.03,
        hook="motor_reading",
        law=law,
        natural=(("g", "", "1"),) if profile == "gain" else (),
    )


@form("motor.torque_constant", "gain error", in_library=True)
def _constant_gain(rng: Rng) -> Effect:
    return _constant(rng, "gain error", "gain")


@form("motor.torque_constant", "saturation")
def _constant_saturation(rng: Rng) -> Effect:
    return _constant(rng, "saturation of the magnetic circuit (tanh)", "saturation")


@form("motor.torque_constant", "soft saturation", held_back=True)
def _constant_soft(rng: Rng) -> Effect:
    return _constant(rng, "rational saturation", "soft")
