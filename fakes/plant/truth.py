"""The plant truth: every value the emulated bench obeys (:mod:`fakes.plant.plant_file` reads it from a TOML file).

Nothing outside the fakes and their tests reads it: an analysis sees recordings only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fakes.plant.hidden.kinds import Hidden
from fakes.plant.parts import (
    Drive,
    Effect,
    Encoder,
    Friction,
    Gearbox,
    Heat,
    LoadSide,
    Motor,
    Numerics,
    Pt100,
    Ripple,
    TorqueSensor,
)
from fakes.plant.transmission import FloatArray, TransmissionError


@dataclass(frozen=True, slots=True)
class PlantTruth:
    """True values of a bench."""

    name: str
    gearbox: Gearbox
    friction: Friction
    heat: Heat
    input_motor: Motor
    load_motor: Motor
    input_drive: Drive
    load_drive: Drive
    input_encoder: Encoder
    load_encoder: Encoder
    torque_sensor: TorqueSensor
    lubricant_sensor: Pt100
    ambient_sensor: Pt100
    load_side: LoadSide
    ripple: tuple[Ripple, ...]
    transmission_error: TransmissionError
    numerics: Numerics = field(default_factory=Numerics)
    effects: tuple[Effect, ...] = ()
    """terms of the physics library played on top; only a plant that runs a simulation file has any"""
    laws: tuple[Any, ...] = ()
    """laws (bench.simulation.laws) that the amplitudes of the orders follow, where a simulation file brings them"""
    hidden: tuple[Hidden, ...] = ()
    """physics of its own beyond the nominal equations"""
    ledger: str = ""
    """file that takes what of each channel is the hidden physics', for a sealed truth; empty for none"""

    @property
    def torsional_stiffness(self) -> float:
        """Gearbox and coupling in series, as the load encoder sees them, N·m/rad: the elastic part of a_0 is −τ/K."""
        return 1.0 / (1.0 / self.gearbox.stiffness + 1.0 / self.load_side.coupling_stiffness)

    def without_weak_orders(self) -> PlantTruth:
        """Return the same bench with only the orders that the paper's model has."""
        return replace(self, transmission_error=self.transmission_error.without_weak_orders())

    def te_coefficients(self) -> dict[str, dict[str, Mapping[str, list[float]] | list[float]]]:
        """Return the true series, weak orders included, in the paper's form and units (N·m, rad/s, °C, rad).

        ``{"positive": {"46": {"A": [10], "phi": [10]}, …, "a0": [10]}, "negative": …}`` as in a simulation file; a_0
        holds the elastic part −τ/K of gearbox and coupling.
        """
        return self.transmission_error.coefficients(self.torsional_stiffness)

    def nominal_parameters(self) -> dict[str, dict[str, float]]:
        """Return the true parameters of the nominal simulation's terms, by effect and symbol, in SI units and °C."""
        friction, heat = self.friction, self.heat
        return {
            "friction.coulomb": {"f_c": friction.coulomb},
            "friction.viscous": {"f_v": float(self._viscous(25.0))},
            "friction.viscous_temperature_linear": {"f_vT": friction.viscous_temperature},
            "friction.load_dependent": {"f_l": friction.load_dependent},
            "motor.inertia": {"J": self.input_motor.inertia},
            "motor.torque_offset": {"tau_0": self.input_motor.torque_offset},
            "thermal.loss_heating": {"C": heat.capacity},
            "thermal.convection": {"R": heat.resistance, "T_amb": heat.ambient},
            "load.bearing_friction": {"f_b": self.load_side.bearing_friction},
            "load.inertia": {"J_L": self.load_motor.inertia},
            "load.torque_offset": {"z_0": self.torque_sensor.zero},
        }

    def _viscous(self, temperature: FloatArray | float) -> FloatArray:
        """Return the viscous coefficient at a temperature, N·m·s/rad."""
        friction = self.friction
        linear = friction.viscous + friction.viscous_temperature * (temperature - friction.reference_temperature)
        lowest: FloatArray = np.maximum(linear, friction.minimum_viscous_share * friction.viscous)
        return lowest

    def te(self, theta: FloatArray, torque: FloatArray, velocity: FloatArray, temperature: FloatArray) -> FloatArray:
        """Return the noise-free transmission error q − θ in rad of steady motion (see TransmissionError.evaluate)."""
        return self.transmission_error.evaluate(theta, torque, velocity, temperature, self.torsional_stiffness)

    def motor_torque(self, torque: FloatArray, motor_velocity: FloatArray, temperature: FloatArray) -> FloatArray:
        """Return the input motor's torque of steady motion, N·m (equation 2 with ω̇ = 0)."""
        friction = self.friction
        ratio = self.gearbox.ratio
        direction = np.sign(motor_velocity)
        constant = direction * (friction.coulomb + friction.load_dependent * np.abs(torque) / ratio)
        total: FloatArray = (
            torque / ratio + constant + self._viscous(temperature) * motor_velocity + self.input_motor.torque_offset
        )
        return total
