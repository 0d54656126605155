"""What a stretch of motion will cost: time, energy and warmth, from the nominal friction and heat balance of the bench.

Equations 2 and 3 of bench-physics.md in steady motion: the input motor gives
τ_m = τ/u + d·f_c + f_v·ω_m + f_vT·ω_m·(T − 25 °C) + d·f_l·|τ|/u (+ J·ω̇_m);
the loss heats one mass C that loses heat through R.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from bench.configuration import BenchConfiguration
from bench.protocols import Phase, Until

_STEP_S = 20.0
"""Longest step of the heat balance; its time constants are hours."""


@dataclass(frozen=True, slots=True)
class ThermalState:
    """State of the estimate. ``time_s`` since the campaign began, ``energy_j`` drawn, ``temperature`` in °C."""

    temperature: float
    time_s: float = 0.0
    energy_j: float = 0.0


@dataclass(frozen=True, slots=True)
class Demand:
    """The greatest absolute values a sequence of phases asks of the bench, SI."""

    motor_speed: float = 0.0
    load_torque: float = 0.0
    load_motor_torque: float = 0.0
    motor_torque: float = 0.0
    position_low: float = 0.0
    position_high: float = 0.0
    temperature: float = -math.inf


class TemperatureUnreachable(Exception):
    """A phase that waits for a temperature would run into its time limit."""

    def __init__(self, phase: Phase, reached: float) -> None:
        self.phase, self.reached = phase, reached
        super().__init__(f"{phase.temperature:g} °C is not reached, the estimate ends at {reached:.1f} °C")


class Estimator:
    """Nominal friction and heat of one bench."""

    def __init__(self, bench: BenchConfiguration) -> None:
        self._bench = bench

    def friction_torque(self, motor_speed: float, load_torque: float, temperature: float) -> float:
        """Loss torque at the motor shaft in N·m, without sign; zero at standstill."""
        nominal, speed = self._bench.nominal, abs(motor_speed)
        if speed == 0.0:
            return 0.0
        viscous = nominal.friction_viscous + nominal.friction_viscous_temperature * (temperature - 25.0)
        load_dependent = nominal.friction_load * abs(load_torque) / self._bench.gearbox.ratio
        return nominal.friction_coulomb + max(0.0, viscous) * speed + load_dependent

    def run(self, phases: Iterable[Phase], state: ThermalState) -> tuple[ThermalState, Demand]:
        """Return the state after the phases and what they demand.

        Raises
        ------
        TemperatureUnreachable
            If a phase with a condition would not meet it within its time.
        """
        demand = Demand(temperature=state.temperature)
        velocity, torque, position = 0.0, 0.0, 0.0
        for phase in phases:
            before = state
            state = self._phase(phase, state, (velocity + phase.velocity) / 2.0, (torque + phase.load_torque) / 2.0)
            position += (velocity + phase.velocity) / 2.0 * (state.time_s - before.time_s)
            demand = self._demand(demand, phase, velocity, state, position)
            velocity, torque = phase.velocity, phase.load_torque
        return state, demand

    def _phase(self, phase: Phase, state: ThermalState, velocity: float, torque: float) -> ThermalState:
        remaining = phase.duration_s
        while remaining > 0.0 and not _met(phase, state.temperature):
            step = min(remaining, _STEP_S)
            after = self._step(state, step, velocity, torque)
            if phase.until is not None and _met(phase, after.temperature):
                share = (phase.temperature - state.temperature) / (after.temperature - state.temperature)
                return self._step(state, step * min(1.0, max(0.0, share)), velocity, torque)
            state, remaining = after, remaining - step
        if phase.until is not None and not _met(phase, state.temperature):
            raise TemperatureUnreachable(phase, state.temperature)
        return state

    def _step(self, state: ThermalState, step: float, velocity: float, torque: float) -> ThermalState:
        nominal, motor_speed = self._bench.nominal, velocity * self._bench.gearbox.ratio
        loss = self.friction_torque(motor_speed, torque, state.temperature) * abs(motor_speed)
        # exact for a loss constant over the step
        settled = nominal.ambient_temperature + loss * nominal.thermal_resistance
        decay = math.exp(-step / (nominal.thermal_resistance * nominal.heat_capacity))
        return replace(
            state,
            temperature=settled + (state.temperature - settled) * decay,
            time_s=state.time_s + step,
            # the load motor feeds back what the input motor puts through; only losses and the idle power are drawn
            energy_j=state.energy_j + step * (loss + nominal.load_friction * abs(velocity) + nominal.idle_power),
        )

    def _demand(self, so_far: Demand, phase: Phase, velocity: float, state: ThermalState, position: float) -> Demand:
        bench = self._bench
        speed = max(abs(velocity), abs(phase.velocity)) * bench.gearbox.ratio
        changes = phase.velocity != velocity and phase.duration_s > 0.0
        acceleration = abs(phase.velocity - velocity) * bench.gearbox.ratio / phase.duration_s if changes else 0.0
        motor_torque = (
            abs(phase.load_torque) / bench.gearbox.ratio
            + self.friction_torque(speed, phase.load_torque, state.temperature)
            + bench.input_motor.inertia * acceleration
        )
        return Demand(
            max(so_far.motor_speed, speed),
            max(so_far.load_torque, abs(phase.load_torque)),
            max(so_far.load_motor_torque, abs(phase.load_torque) + bench.nominal.load_friction),
            max(so_far.motor_torque, motor_torque),
            min(so_far.position_low, position),
            max(so_far.position_high, position),
            max(so_far.temperature, state.temperature),
        )


def _met(phase: Phase, temperature: float) -> bool:
    if phase.until is Until.WARMER:
        return temperature >= phase.temperature - 1e-9
    if phase.until is Until.COOLER:
        return temperature <= phase.temperature + 1e-9
    return False
