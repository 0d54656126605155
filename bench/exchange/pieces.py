"""Parts of a channel as formulas: laws and waves of the orders, pulses, recorded quantities."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from bench.exchange import formula
from bench.exchange.formula import Written, const, lift, make, total
from bench.simulation.composed import composed
from bench.simulation.frame import Frame
from bench.simulation.laws import EACH, FUNCTIONS, RESONANCE, UNSIGNED, Law, strengths
from bench.simulation.quantities import AUXILIARY, FACTORS, QUANTITIES
from bench.simulation.waves import Wave, angle_from


def law(of: Law, order: float, frame: Frame) -> tuple[Any, Any]:
    """Real and imaginary part of a law's factor on an order."""
    speed = np.abs(frame.velocity)
    if of.effect == RESONANCE:
        if order not in of.orders:
            return 1.0, 0.0
        ratio = (speed if of.form in UNSIGNED else frame.velocity) * (order / of.point[0])
        a, b = 1.0 - ratio * ratio, 2.0 * of.point[1] * ratio
        size, share = a * a + b * b, (of.point[2] if len(of.point) > 2 else 1.0)
        # H = (a - jb)/size; a base's mode has r²·H in place of H - 1
        real, imaginary = a / size - 1.0, -(b / size)
        if of.form in EACH or of.form == "second_order_of_base":
            real, imaginary = ratio * ratio * a / size, -(ratio * ratio * b / size)
        if of.form in EACH:
            each = complex(strengths(of, (order,))[0])
            return 1.0 + each.real * real - each.imag * imaginary, each.real * imaginary + each.imag * real
        return 1.0 + share * real, share * imaginary
    strength = complex(strengths(of, (order,))[0])
    if strength == 0:
        return 1.0, 0.0
    g = FUNCTIONS[of.effect, of.form](speed, frame.torque, frame.temperature, frame.time, of.point, of.reference)
    return 1.0 + g * strength.real, g * strength.imag


def wave(wave_term: Wave, angle: Any, frame: Frame) -> Written:
    """A wave over an angle in rad, times the factors it names."""
    wave_angle = make("mul", const(wave_term.order), angle)
    value = total(
        [
            make("mul", const(wave_term.cosine), np.cos(wave_angle)),
            make("mul", const(wave_term.sine), np.sin(wave_angle)),
        ]
    )
    for name in wave_term.times.split("*"):
        value = make("mul", lift(FACTORS[name](frame)), value)
    return value


def pulse(angle: float, width: float, height: float, frame: Frame) -> Written:
    """A Gaussian pulse once a revolution: angle and width in rad at the output, height in the unit of the channel."""
    distance = angle_from(frame.theta, angle)
    return lift(height * np.exp(-0.5 * (distance / width) ** 2))


def pulse_slope(angle: float, width: float, height: float, frame: Frame) -> Written:
    """Change of a pulse with the angle."""
    distance = angle_from(frame.theta, angle)
    return lift(-distance / width**2 * (height * np.exp(-0.5 * (distance / width) ** 2)))


def quantity(name: str, frame: Frame) -> Written:
    """A recorded quantity by its name; the rate of an auxiliary input, which no sample tells, is an input as well."""
    if name.startswith(AUXILIARY):
        return _auxiliary_quantity(name.removeprefix(AUXILIARY), frame.ratio)
    return lift(QUANTITIES[name].values(frame))


def _auxiliary_quantity(name: str, ratio: float) -> Written:
    """An auxiliary input, or what is composed of several."""

    class Inputs(dict[str, Any]):
        def __contains__(self, key: object) -> bool:
            return True

        def __missing__(self, key: str) -> Any:
            return formula.reference("input", AUXILIARY + key)

    has = {name: formula.reference("input", name) for name in ("load_angle", "motor_velocity", "motor_acceleration")}
    frame = SimpleNamespace(
        aux=Inputs(),
        size=1,
        q=has["load_angle"],
        omega=has["motor_velocity"],
        acceleration=has["motor_acceleration"],
        velocity=has["motor_velocity"] / ratio,
    )
    made = composed(name, frame)  # type: ignore[arg-type]
    return formula.reference("input", AUXILIARY + name) if made is None else lift(made)
