"""Effects no vocabulary has: an honest report calls them unknown and says where they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fakes.concealed.effects.base import Effect, Floats, Run, ThermalWorld
from fakes.concealed.effects.formula import Formula, Law, form
from fakes.concealed.truth import Location

Rng = np.random.Generator
Shape = dict[str, float]
Memory = dict[str, Any]


def _foreign(
    name: str, channel: str, hook: str, law: Law, shape: Shape, amplitude: float, claimed: Location | None = None
) -> Formula:
    return Formula("unknown", name, (channel,), amplitude, shape, claimed or Location(), hook=hook, law=law)


@form("unknown", "floor vibration at a fixed frequency", in_library=True)
def _floor(rng: Rng) -> Effect:
    """A machine next door: fixed in Hz, free in phase from recording to recording."""

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return np.sin(2.0 * np.pi * s["hz"] * run.clock + 2.3 * run.index**2)

    return _foreign(
        "floor vibration at a fixed frequency",
        "transmission_error",
        "transmission",
        law,
        {"hz": rng.uniform(1.7, 4.3)},
        5e-6,
    )


@form("unknown", "third-order interaction of load, speed and temperature")
def _three_way(rng: Rng) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return (run.torque / 700.0) * ((np.abs(run.rate) - 0.11) / 0.06) * ((run.temperature - 32.0) / 8.0)

    return _foreign("load × speed × temperature", "transmission_error", "transmission", law, {}, 5e-6)


@form("unknown", "order 46 swells in a band of load")
def _contact(rng: Rng) -> Effect:
    centre, width = rng.uniform(250.0, 550.0), rng.uniform(120.0, 200.0)

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        swell = np.exp(-(((run.torque - s["centre"]) / s["width"]) ** 2))
        return swell * np.cos(46.0 * run.theta + s["phase"])

    outer, core = ({"load_torque": [centre - k * width, centre + k * width]} for k in (1.5, 0.7))
    claimed = Location(conditions=outer, core=core, orders=(46.0,))
    shape = {"centre": centre, "width": width, "phase": rng.uniform(-np.pi, np.pi)}
    return _foreign(
        "order 46 swells in a band of load", "transmission_error", "transmission", law, shape, 1e-5, claimed
    )


@form("unknown", "rolling-element cage slipping out of phase", held_back=True)
def _cage(rng: Rng) -> Effect:
    """An order that slips: its phase wanders from recording to recording and within one."""

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        slip = np.sin(0.37 * run.theta + 1.7 * run.index) * 1.5
        return np.cos(s["order"] * run.theta + slip + 2.4 * run.index**2)

    return _foreign(
        "slipping cage", "transmission_error", "transmission", law, {"order": rng.uniform(31.0, 41.0)}, 5e-6
    )


@form("unknown", "friction hump at one speed", in_library=True)
def _hump(rng: Rng) -> Effect:
    centre = float(np.deg2rad(rng.uniform(4.5, 8.0)))

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return np.asarray(run.sign * np.exp(-(((np.abs(run.rate) - s["centre"]) / np.deg2rad(1.0)) ** 2)))

    outer, core = ({"velocity": [centre - k, centre + k]} for k in np.deg2rad((1.8, 0.7)).tolist())
    claimed = Location(conditions=outer, core=core)
    return _foreign("friction hump at one speed", "motor_torque", "friction", law, {"centre": centre}, 0.15, claimed)


@form("unknown", "seal that sticks now and then", in_library=True)
def _seal(rng: Rng) -> Effect:
    """Two levels of drag, switched at times nobody can predict."""
    edges = np.sort(rng.uniform(0.0, 1.0, 30))

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        state = np.searchsorted(edges, run.clock / run.duration) % 2
        return run.sign * state

    return _foreign("seal that sticks now and then", "motor_torque", "friction", law, {}, 0.1)


@form("unknown", "drag that breathes every twenty minutes", in_library=True)
def _breathing(rng: Rng) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return run.sign * np.sin(2.0 * np.pi * run.clock / s["period"])

    return _foreign("drag that breathes", "motor_torque", "friction", law, {"period": rng.uniform(900.0, 1800.0)}, 0.1)


@form("unknown", "drag falls with load in one direction", held_back=True)
def _one_sided(rng: Rng) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        lift = np.clip(run.torque / 400.0, 0.0, None)
        return np.where(run.sign > 0.0, -lift / (1.0 + lift), 0.0)

    claimed = Location(conditions={"direction": "positive", "load_torque": [0.0, 1100.0]})
    return _foreign("drag falls with load in one direction", "motor_torque", "friction", law, {}, 0.15, claimed)


@dataclass(slots=True)
class _LoadHeat(Effect):
    """The load motor's copper loss reaches the lubricant: ``amplitude`` W at 1000 N·m, with the square of load."""

    def heat(self, world: ThermalWorld, run: Run, clock: Floats, coarse: slice) -> None:
        world.extra_power += self.amplitude * (run.command[coarse] / 1000.0) ** 2


@form("unknown", "heat from the load motor's copper")
def _copper(rng: Rng) -> Effect:
    return _LoadHeat("unknown", "heat from the load motor's copper", ("temperature",), 60.0)


@dataclass(slots=True)
class _Melting(Effect):
    """The grease takes up latent heat about one temperature: ``amplitude`` is the capacity bump over 10 kJ/K."""

    def heat(self, world: ThermalWorld, run: Run, clock: Floats, coarse: slice) -> None:
        world.capacity_bump = (1e4 * self.amplitude, self.shape["centre"], 2.5)

    def rest(self, world: ThermalWorld, clock: Floats) -> None:
        world.capacity_bump = (1e4 * self.amplitude, self.shape["centre"], 2.5)


@form("unknown", "latent heat of the grease", held_back=True)
def _latent(rng: Rng) -> Effect:
    centre = rng.uniform(28.0, 34.0)
    claimed = Location(conditions={"temperature": [centre - 4.0, centre + 4.0]})
    return _Melting("unknown", "latent heat of the grease", ("temperature",), 1.0, {"centre": centre}, claimed)


@form("unknown", "eddy-current drag of the load motor", in_library=True)
def _eddy(rng: Rng) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        x = run.rate / 0.06
        return x / (1.0 + x**2) * 2.0

    return _foreign("eddy-current drag of the load motor", "load_torque", "load_side", law, {}, 4.0)


@form("unknown", "bending crosstalk twice per turn, in proportion to load")
def _crosstalk(rng: Rng) -> Effect:
    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return run.torque / 500.0 * np.cos(2.0 * run.theta + s["phase"])

    shape = {"phase": rng.uniform(-np.pi, np.pi)}
    return _foreign("bending crosstalk", "load_torque", "sensor_reading", law, shape, 4.0, Location(orders=(2.0,)))


@form("unknown", "amplifier zero jumps for an hour", held_back=True, in_library=True)
def _jump(rng: Rng) -> Effect:
    start = float(rng.integers(4, 12))

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        inside = s["start"] <= run.index < s["start"] + 9.0
        return np.full(run.time.size, float(inside))

    return _foreign("amplifier zero jumps for an hour", "load_torque", "sensor_reading", law, {"start": start}, 4.0)
