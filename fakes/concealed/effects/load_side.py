"""Effects between gearbox output and load motor: unbalance and the torque sensor's own errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fakes.concealed.effects import kernels
from fakes.concealed.effects.base import Effect, Floats, Run
from fakes.concealed.effects.formula import Formula, Law, form
from fakes.concealed.truth import Parameter

_LOAD = ("load_torque",)
_BOTH = ("load_torque", "motor_torque")
Rng = np.random.Generator
Shape = dict[str, float]
Memory = dict[str, Any]


def _sensor(
    effect: str,
    name: str,
    law: Law,
    amplitude: float,
    shape: Shape | None = None,
    natural: tuple[tuple[str, str, str], ...] = (),
) -> Formula:
    return Formula(effect, name, _BOTH, amplitude, shape or {}, hook="sensor_reading", law=law, natural=natural)


def _unbalance(rng: Rng, name: str, hook: str) -> Effect:
    shape = {"phase": rng.uniform(-np.pi, np.pi)}

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return np.cos(run.theta + s["phase"])

    channels = ("motor_torque",) if hook == "output_torque" else ("load_torque",)

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"m_c": (amplitude * np.cos(s["phase"]), "N·m"), "m_s": (-amplitude * np.sin(s["phase"]), "N·m")}

    return Formula("load.unbalance", name, channels, 8.0, shape, hook=hook, law=law, derived=derived)


@form("load.unbalance", "arm before the torque sensor", in_library=True)
def _unbalance_before(rng: Rng) -> Effect:
    return _unbalance(rng, "arm before the torque sensor", "output_torque")


@form("load.unbalance", "arm behind the torque sensor", in_library=True)
def _unbalance_behind(rng: Rng) -> Effect:
    return _unbalance(rng, "arm behind the torque sensor", "load_side")


@form("sensor.torque_zero_temperature", "linear in temperature", in_library=True)
def _zero(rng: Rng) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return run.temperature - 25.0

    effect = _sensor("sensor.torque_zero_temperature", "linear", law, 0.3, natural=(("z_T", "", "N·m/K"),))
    effect.channels = _LOAD
    return effect


@form("sensor.torque_zero_temperature", "slightly curved", held_back=True, in_library=True)
def _zero_curved(rng: Rng) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = run.temperature - 25.0
        return x + 0.01 * x**2

    effect = _sensor("sensor.torque_zero_temperature", "slightly curved", law, 0.3)
    effect.channels = _LOAD
    return effect


@form("sensor.torque_zero_temperature", "exponential in temperature")
def _zero_exponential(rng: Rng) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return np.asarray(15.0 * np.expm1((run.temperature - 25.0) / 15.0))

    effect = _sensor("sensor.torque_zero_temperature", "exponential", law, 0.3)
    effect.channels = _LOAD
    return effect


@form("sensor.torque_gain", "gain error", in_library=True)
def _gain(rng: Rng) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return run.torque

    return _sensor("sensor.torque_gain", "gain error", law, 0.01, natural=(("g_s", "", "1"),))


def _curved(rng: Rng, name: str, profile: str) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = run.torque / 1000.0
        if profile == "cubic":
            return 1000.0 * x**3 - 600.0 * x
        if profile == "saturation":
            return 1000.0 * (np.tanh(0.9 * x) / 0.9 - x)
        if profile == "bridge":
            return 1000.0 * (x / (1.0 - 0.3 * x) - x)
        return 1000.0 * x**2

    return _sensor("sensor.torque_nonlinearity", name, law, 0.01)


@form("sensor.torque_nonlinearity", "square", in_library=True)
def _curved_square(rng: Rng) -> Effect:
    return _curved(rng, "square", "square")


@form("sensor.torque_nonlinearity", "cubic with end points adjusted", in_library=True)
def _curved_cubic(rng: Rng) -> Effect:
    return _curved(rng, "cubic with end points adjusted", "cubic")


@form("sensor.torque_nonlinearity", "unequal arms of the bridge")
def _curved_bridge(rng: Rng) -> Effect:
    return _curved(rng, "unequal arms of the bridge, x/(1 − 0.3 x)", "bridge")


@form("sensor.torque_nonlinearity", "saturating amplifier", held_back=True)
def _curved_tanh(rng: Rng) -> Effect:
    return _curved(rng, "saturating amplifier", "saturation")


def _loop(rng: Rng, name: str, profile: str) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        state = memory.setdefault("z", np.zeros(4 if profile == "maxwell" else 2))
        path = np.append(0.0, run.command)  # between recordings the load is off; ripple is too fast to slide
        if profile == "maxwell":
            breaks = s["width"] * np.array([0.3, 0.7, 1.2])
            return kernels.maxwell_slip(path, breaks, np.array([0.3, 0.4, 0.3]), state)[1:]
        if profile == "duhem":
            return kernels.duhem(path, s["width"], state)[1:]
        return kernels.play(path, 0.6 * s["width"], state)[1:]

    def derived(amplitude: float, s: Shape) -> dict[str, tuple[float, str]]:
        return {"h_s": (amplitude, "N·m"), "w_h": (s["width"] * (1.0 if profile == "duhem" else 0.6), "N·m")}

    effect = _sensor("sensor.torque_hysteresis", name, law, 3.0, {"width": rng.uniform(200.0, 450.0)})
    effect.derived = derived if profile in ("duhem", "play") else None
    return effect


@form("sensor.torque_hysteresis", "Duhem", in_library=True)
def _loop_duhem(rng: Rng) -> Effect:
    return _loop(rng, "Duhem", "duhem")


@form("sensor.torque_hysteresis", "Maxwell slip")
def _loop_maxwell(rng: Rng) -> Effect:
    return _loop(rng, "Maxwell slip", "maxwell")


@form("sensor.torque_hysteresis", "play", held_back=True, in_library=True)
def _loop_play(rng: Rng) -> Effect:
    return _loop(rng, "play", "play")


@dataclass(slots=True)
class _Skew(Effect):
    """The torque sensor's channel comes ``amplitude`` seconds late."""

    def sensor_delay(self) -> float:
        return self.amplitude

    def parameters(self) -> tuple[Parameter, ...]:
        return (Parameter("delta", self.amplitude, "s"),)


@form("sensor.timing_skew", "constant delay of the torque sensor", in_library=True)
def _skew(rng: Rng) -> Effect:
    channels = ("load_torque", "transmission_error", "motor_torque")
    return _Skew("sensor.timing_skew", "constant delay", channels, 0.01)
