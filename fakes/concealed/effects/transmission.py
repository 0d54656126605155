"""Transmission-error effects: orders, pulses, resonance, compliance beyond the polynomial, drift."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fakes.concealed.effects.base import Effect, Floats, Run
from fakes.concealed.effects.formula import Formula, Law, form
from fakes.concealed.plant import ORDERS
from fakes.concealed.truth import Location, Parameter

_TE = ("transmission_error",)
Rng = np.random.Generator
Shape = dict[str, float]
Memory = dict[str, Any]
#: Orders that parts of the gearbox could make and the simulation does not have.
_FREE_ORDERS = (2, 5, 7, 8, 10, 15, 16, 20, 21, 23, 28, 36, 45, 48, 72, 96, 160, 185, 225, 230, 270, 322, 368)


def _te(
    effect: str, name: str, law: Law, shape: Shape, amplitude: float = 5e-6, claimed: Location | None = None
) -> Formula:
    return Formula(effect, name, _TE, amplitude, shape, claimed or Location(), hook="transmission", law=law)


def _free_order(rng: Rng) -> float:
    return float(rng.choice([k for k in _FREE_ORDERS if k != 185]))


@form("te.harmonic", "constant amplitude", in_library=True)
def _harmonic(rng: Rng) -> Effect:
    k = _free_order(rng)
    shape = {"order": k, "phase": rng.uniform(-np.pi, np.pi)}

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return np.cos(s["order"] * run.theta + s["phase"])

    return _te("te.harmonic", "constant amplitude", law, shape, claimed=Location(orders=(k,)))


@form("te.harmonic", "amplitude grows with load, phase differs by direction", in_library=True)
def _harmonic_load(rng: Rng) -> Effect:
    k = _free_order(rng)
    shape = {
        "order": k,
        "phase": rng.uniform(-np.pi, np.pi),
        "slope": rng.uniform(0.2, 0.6),
        "skew": rng.uniform(-0.6, 0.6),
    }

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        size = 1.0 + s["slope"] * np.clip(run.torque, -1200.0, 1200.0) / 1000.0
        return size * np.sin(s["order"] * run.theta + s["phase"] + s["skew"] * run.side)

    return _te("te.harmonic", "load-dependent", law, shape, claimed=Location(orders=(k,)))


@form("te.harmonic", "amplitude saturates with load")
def _harmonic_saturating(rng: Rng) -> Effect:
    k = _free_order(rng)
    shape = {"order": k, "phase": rng.uniform(-np.pi, np.pi), "load": rng.uniform(120.0, 350.0)}

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        size = 1.2 + np.tanh(run.torque / s["load"])
        return np.asarray(size * np.cos(s["order"] * run.theta + s["phase"]))

    return _te("te.harmonic", "amplitude saturates with load", law, shape, claimed=Location(orders=(k,)))


@form("te.harmonic", "sharp-crested wave at one order", held_back=True)
def _harmonic_crest(rng: Rng) -> Effect:
    k = _free_order(rng)
    shape = {"order": k, "phase": rng.uniform(-np.pi, np.pi), "bend": rng.uniform(0.05, 0.12)}

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        angle = s["order"] * run.theta + s["phase"]
        return np.cos(angle + s["bend"] * (run.temperature - 30.0) / 10.0)

    return _te("te.harmonic", "phase turning with temperature", law, shape, claimed=Location(orders=(k,)))


_CARRIERS = ((46, 2), (46, 5), (92, 1), (92, 3), (138, 1), (138, 4), (184, 3), (24, 1), (24, 2), (276, 2), (276, 5))


def _sides(f: int, m: int) -> Location:
    return Location(orders=tuple(float(k) for k in (f - m, f + m) if k not in ORDERS))


@form("te.sideband", "amplitude modulation", in_library=True)
def _sideband_am(rng: Rng) -> Effect:
    f, m = _CARRIERS[int(rng.integers(len(_CARRIERS)))]
    shape = {"f": f, "m": m, "a": rng.uniform(-np.pi, np.pi), "b": rng.uniform(-np.pi, np.pi)}

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return np.cos(s["m"] * run.theta + s["b"]) * np.cos(s["f"] * run.theta + s["a"])

    return _te("te.sideband", "amplitude modulation", law, shape, claimed=_sides(f, m))


@form("te.sideband", "phase modulation")
def _sideband_pm(rng: Rng) -> Effect:
    f, m = _CARRIERS[int(rng.integers(len(_CARRIERS)))]
    shape = {"f": f, "m": m, "a": rng.uniform(-np.pi, np.pi), "b": rng.uniform(-np.pi, np.pi)}

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        carrier = s["f"] * run.theta + s["a"]
        return np.sin(carrier + 0.3 * np.sin(s["m"] * run.theta + s["b"])) - np.sin(carrier)

    return _te("te.sideband", "phase modulation", law, shape, claimed=_sides(f, m))


@form("te.sideband", "both, unequal sides", held_back=True, in_library=True)
def _sideband_mixed(rng: Rng) -> Effect:
    f, m = _CARRIERS[int(rng.integers(len(_CARRIERS)))]
    shape = {
        "f": f,
        "m": m,
        "a": rng.uniform(-np.pi, np.pi),
        "b": rng.uniform(-np.pi, np.pi),
        "r": rng.uniform(0.5, 0.8),
    }

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        upper = np.cos((s["f"] + s["m"]) * run.theta + s["a"])
        return upper + s["r"] * np.cos((s["f"] - s["m"]) * run.theta + s["b"])

    return _te("te.sideband", "amplitude and phase modulation, unequal sides", law, shape, claimed=_sides(f, m))


@dataclass(slots=True)
class _Modulated(Effect):
    """An order of the series swells and ebbs with the angle, whatever its amplitude is: ``amplitude`` is the share."""

    def modulation(self, theta: Floats, rate: Floats, orders: Floats) -> tuple[Floats, Floats] | None:
        gain = np.zeros((orders.size, theta.size))
        wave = self.amplitude * np.cos(self.shape["m"] * theta + self.shape["b"])
        gain[np.abs(orders - self.shape["f"]) < 1e-9] = wave
        return gain, np.zeros_like(gain)


@form("te.sideband", "the very order modulated")
def _sideband_of_one_order(rng: Rng) -> Effect:
    f, m = _CARRIERS[int(rng.integers(len(_CARRIERS)))]
    shape = {"f": f, "m": m, "b": rng.uniform(-np.pi, np.pi)}
    return _Modulated("te.sideband", "the very order modulated, load and all", _TE, 0.5, shape, _sides(f, m))


def _pulse(rng: Rng, name: str, profile: str) -> Effect:
    at, width = rng.uniform(0.0, 2.0 * np.pi), np.deg2rad(rng.uniform(0.8, 3.0))
    shape = {"angle": at, "width": width}
    window, core = (((float(at - k * width), float(at + k * width)),) for k in (2.0, 0.8))

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = (np.mod(run.theta - s["angle"] + np.pi, 2.0 * np.pi) - np.pi) / s["width"]
        if profile == "half_sine":
            return np.where(np.abs(x) < 1.5, np.cos(np.pi * x / 3.0), 0.0)
        if profile == "triangle":
            return np.clip(1.0 - np.abs(x) / 1.8, 0.0, None)
        if profile == "doublet":
            return np.where(np.abs(x) < 2.0, np.sin(np.pi * x / 2.0), 0.0)
        return np.exp(-0.5 * x**2)

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"p": (amplitude, "rad"), "theta_p": (s["angle"], "rad"), "w_p": (s["width"], "rad")}

    effect = _te("te.local_defect", name, law, shape, 3e-5, Location(angle_windows=window, core_windows=core))
    effect.derived = derived if profile == "gaussian" else None
    return effect


@form("te.local_defect", "half sine")
def _defect_sine(rng: Rng) -> Effect:
    return _pulse(rng, "half sine", "half_sine")


@form("te.local_defect", "triangle")
def _defect_triangle(rng: Rng) -> Effect:
    return _pulse(rng, "triangle", "triangle")


@form("te.local_defect", "Gaussian", in_library=True)
def _defect_gauss(rng: Rng) -> Effect:
    return _pulse(rng, "Gaussian", "gaussian")


@form("te.local_defect", "doublet", held_back=True)
def _defect_doublet(rng: Rng) -> Effect:
    return _pulse(rng, "pull and push of a passing pin", "doublet")


@dataclass(slots=True)
class _Resonance(Effect):
    """All orders pass a second-order mode of the frame; ``amplitude`` is the mode's participation."""

    def parameters(self) -> tuple[Parameter, ...]:
        if "second" in self.shape or self.shape["based"]:
            return ()
        return Parameter("w_0", self.shape["w_r"], "rad/s"), Parameter("zeta", self.shape["zeta"], "1")

    def modulation(self, theta: Floats, rate: Floats, orders: Floats) -> tuple[Floats, Floats] | None:
        # a response lags in time: over the angle it lags in one direction and leads in the other
        ratio = orders[:, None] * rate[None, :] / self.shape["w_r"]
        response = 1.0 / (1.0 - ratio**2 + 2j * self.shape["zeta"] * ratio)
        if "second" in self.shape:
            other = ratio / self.shape["second"]
            response = 0.6 * response + 0.4 / (1.0 - other**2 + 2j * self.shape["zeta"] * other)
        gain = 1.0 + self.amplitude * ((response - 1.0) if self.shape["based"] == 0 else response * ratio**2)
        return np.abs(gain) - 1.0, -np.angle(gain)


def _mode(rng: Rng, name: str, based: float) -> Effect:
    w_r = 2.0 * np.pi * rng.uniform(2.5, 6.0)
    return _Resonance("te.resonance", name, _TE, 0.3, {"w_r": w_r, "zeta": rng.uniform(0.04, 0.12), "based": based})


@form("te.resonance", "force-driven mode", in_library=True)
def _resonance(rng: Rng) -> Effect:
    return _mode(rng, "force-driven mode", 0.0)


@form("te.resonance", "two modes")
def _resonance_two(rng: Rng) -> Effect:
    effect = _mode(rng, "two modes of the frame", 0.0)
    effect.shape["second"] = rng.uniform(1.5, 2.2)
    return effect


@form("te.resonance", "base-driven mode", held_back=True)
def _resonance_base(rng: Rng) -> Effect:
    return _mode(rng, "base-driven mode", 1.0)
