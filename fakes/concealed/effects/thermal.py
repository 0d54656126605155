"""Effects in the heat balance and in the PT100."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fakes.concealed.effects.base import Effect, Floats, Run, ThermalWorld
from fakes.concealed.effects.formula import form
from fakes.concealed.truth import Parameter

_TEMPERATURE = ("temperature",)
Rng = np.random.Generator


@dataclass(slots=True)
class _Lag(Effect):
    """The PT100 follows the lubricant with a time constant, ``amplitude`` in s."""

    def probe_lags(self) -> tuple[float, ...]:
        return (self.amplitude, *([self.shape["element"] * self.amplitude] if "element" in self.shape else []))

    def parameters(self) -> tuple[Parameter, ...]:
        return () if "element" in self.shape else (Parameter("tau_s", self.amplitude, "s"),)


@form("thermal.sensor_lag", "first order", in_library=True)
def _lag(rng: Rng) -> Effect:
    return _Lag("thermal.sensor_lag", "first order", _TEMPERATURE, 20.0)


@form("thermal.sensor_lag", "sheath and element")
def _lag_twice(rng: Rng) -> Effect:
    shape = {"element": rng.uniform(0.4, 0.9)}
    return _Lag("thermal.sensor_lag", "sheath and element, second order", _TEMPERATURE, 20.0, shape)


@dataclass(slots=True)
class _SecondMass(Effect):
    """A housing between lubricant and surroundings; ``amplitude`` is its heat capacity over 10 kJ/K."""

    def heat(self, world: ThermalWorld, run: Run, clock: Floats, coarse: slice) -> None:
        self._set(world)

    def rest(self, world: ThermalWorld, clock: Floats) -> None:
        self._set(world)

    def _set(self, world: ThermalWorld) -> None:
        world.house_capacity = 1e4 * self.amplitude
        world.house_link = self.shape["link"]


@form("thermal.second_mass", "housing between lubricant and surroundings", in_library=True)
def _second_mass(rng: Rng) -> Effect:
    shape = {"link": rng.uniform(15.0, 60.0)}
    return _SecondMass("thermal.second_mass", "housing in series", _TEMPERATURE, 1.0, shape)


@dataclass(slots=True)
class _Ambient(Effect):
    """Surroundings that warm or cool by ``amplitude`` K along a profile of the day."""

    def heat(self, world: ThermalWorld, run: Run, clock: Floats, coarse: slice) -> None:
        world.ambient += self.amplitude * self._profile(clock)

    def rest(self, world: ThermalWorld, clock: Floats) -> None:
        world.ambient += self.amplitude * self._profile(clock)

    def _profile(self, clock: Floats) -> Floats:
        x = clock / self.shape["day"]
        if self.form == "linear":
            return x
        if self.form == "half day wave":
            return np.sin(np.pi * (x - 0.2))
        if self.form == "door open for an hour":
            return np.asarray(-np.exp(-(((x - self.shape["at"]) / 0.12) ** 2)))
        return 1.0 / (1.0 + np.exp(-(x - 0.5) * 12.0))


def _ambient(rng: Rng, name: str) -> Effect:
    shape = {"day": 5.0 * 3600.0, "at": rng.uniform(0.2, 0.6)}
    return _Ambient("thermal.ambient_drift", name, _TEMPERATURE, 4.0, shape)


@form("thermal.ambient_drift", "linear", in_library=True)
def _ambient_linear(rng: Rng) -> Effect:
    return _ambient(rng, "linear")


@form("thermal.ambient_drift", "half day wave", in_library=True)
def _ambient_wave(rng: Rng) -> Effect:
    return _ambient(rng, "half day wave")


@form("thermal.ambient_drift", "door open for an hour")
def _ambient_door(rng: Rng) -> Effect:
    return _ambient(rng, "door open for an hour")


@form("thermal.ambient_drift", "heating of the hall switched on", held_back=True)
def _ambient_switch(rng: Rng) -> Effect:
    return _ambient(rng, "smooth switch")


@dataclass(slots=True)
class _FanCooling(Effect):
    """Cooling that grows with speed; ``amplitude`` is its relative growth at 200 rad/s of the motor."""

    def heat(self, world: ThermalWorld, run: Run, clock: Floats, coarse: slice) -> None:
        share = np.abs(run.motor_rate[coarse]) / 200.0
        growth = share**2 / (0.15 + share**2) if "power" not in self.shape else share ** self.shape["power"]
        world.conductance *= 1.0 + self.amplitude * growth


@form("thermal.convection_speed", "power 0.8 of speed", in_library=True)
def _fan(rng: Rng) -> Effect:
    return _FanCooling("thermal.convection_speed", "power 0.8 of speed", _TEMPERATURE, 1.0, {"power": 0.8})


@form("thermal.convection_speed", "linear in speed", in_library=True)
def _fan_linear(rng: Rng) -> Effect:
    return _FanCooling("thermal.convection_speed", "linear in speed", _TEMPERATURE, 1.0, {"power": 1.0})


@form("thermal.convection_speed", "turbulent beyond a speed")
def _fan_turbulent(rng: Rng) -> Effect:
    return _FanCooling("thermal.convection_speed", "turbulent beyond a speed", _TEMPERATURE, 1.0)


@form("thermal.convection_speed", "root of speed", held_back=True, in_library=True)
def _fan_root(rng: Rng) -> Effect:
    return _FanCooling("thermal.convection_speed", "root of speed", _TEMPERATURE, 1.0, {"power": 0.5})
