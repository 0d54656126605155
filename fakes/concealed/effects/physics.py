"""More effects no vocabulary has: parts with a state of their own, no functions of what is recorded."""

from __future__ import annotations

from typing import Any

import numpy as np

from fakes.concealed.effects import kernels
from fakes.concealed.effects.base import Effect, Floats, Run
from fakes.concealed.effects.formula import Formula, Law, form
from fakes.concealed.truth import Location

Rng = np.random.Generator
Shape = dict[str, float]
Memory = dict[str, Any]


def _drag(name: str, law: Law, shape: Shape, amplitude: float, claimed: Location | None = None) -> Formula:
    return Formula(
        "unknown", name, ("motor_torque",), amplitude, shape, claimed or Location(), hook="friction", law=law
    )


def _rested(run: Run, memory: Memory) -> float:
    """Seconds since the bench last moved on record; long before the first recording."""
    return float(run.clock[0] - memory.get("clock", run.clock[0] - 1e5))


@form("unknown", "thixotropic grease")
def _thixotropy(rng: Rng) -> Effect:
    """Drag that warms itself soft: the grease's structure breaks down in shear and heals at rest."""

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        start = 1.0 - (1.0 - memory.get("structure", 1.0)) * np.exp(-_rested(run, memory) / s["healing"])
        state = kernels.structure(run.sign, 1.0 / run.rate_hz, s["breaking"], s["healing"], start)
        memory["structure"], memory["clock"] = float(state[-1]), float(run.clock[-1])
        return run.sign * state

    shape = {"breaking": rng.uniform(8.0, 20.0), "healing": rng.uniform(8.0, 30.0)}
    return _drag("thixotropic grease", law, shape, 0.2)


@form("unknown", "seal that wets")
def _wetting(rng: Rng) -> Effect:
    """A lip runs dry at rest and is wetted over a distance: drag falls with the angle turned since it last stood."""

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        dry = 1.0 - (1.0 - memory.get("dry", 1.0)) * np.exp(-_rested(run, memory) / s["drying"])
        state: Floats = dry * np.exp(-(run.travel - run.travel[0]) / s["reach"])
        memory["dry"], memory["clock"] = float(state[-1]), float(run.clock[-1])
        return run.sign * state

    shape = {"drying": rng.uniform(5.0, 40.0), "reach": float(np.deg2rad(rng.uniform(25.0, 70.0)))}
    return _drag("seal that wets", law, shape, 0.2)


@form("unknown", "stick–slip of a scraper")
def _stick_slip(rng: Rng) -> Effect:
    """A scraper is drawn along and springs back, never twice by the same way: a saw without an order, at low speed."""
    limit = float(np.deg2rad(rng.uniform(3.5, 5.5)))
    pitch = float(np.deg2rad(rng.uniform(0.4, 1.0)))
    edges = np.cumsum(pitch * rng.uniform(0.6, 1.4, 100_000))

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        way = np.mod(run.travel, edges[-1])
        after = np.minimum(np.searchsorted(edges, way, side="right"), edges.size - 1)
        before = np.where(after > 0, edges[after - 1], 0.0)
        saw: Floats = (way - before) / (edges[after] - before) - 0.5
        gate = np.clip((s["limit"] - np.abs(run.rate)) / (0.15 * s["limit"]), 0.0, 1.0)
        return run.sign * gate * saw

    claimed = Location(conditions={"velocity": [0.0, limit]}, core={"velocity": [0.0, 0.7 * limit]})
    return _drag("stick–slip of a scraper", law, {"limit": limit}, 0.2, claimed)


@form("unknown", "play knocks where the load torque crosses zero")
def _knock(rng: Rng) -> Effect:
    """Play that the load torque crosses: the free part is flung over and rings."""

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        load = run.command + s["bearing"] * run.sign
        ring = kernels.ringing(load, run.sign, 1.0 / run.rate_hz, s["omega"], s["decay"], memory.get("load", 1.0))
        memory["load"] = float(load[-1]) or memory.get("load", 1.0)
        return ring

    shape = {"omega": 2.0 * np.pi * rng.uniform(2.0, 5.0), "decay": rng.uniform(0.8, 2.0), "bearing": 6.0}
    return _drag("play knocks at zero load", law, shape, 0.3)


def _behind(run: Run, s: Shape, memory: Memory) -> Floats:
    """Lubricant less housing in K (N,): the housing follows the lubricant with a time constant of its own."""
    gap = float(memory.get("house", run.temperature[0]) - run.temperature[0])
    start = float(run.temperature[0]) + gap * np.exp(-_rested(run, memory) / s["tau"])
    house = kernels.follow(run.temperature, np.exp(-1.0 / (run.rate_hz * s["tau"])), start)
    memory["house"], memory["clock"] = float(house[-1]), float(run.clock[-1])
    return run.temperature - house


@form("unknown", "bearing preload while it warms")
def _preload(rng: Rng) -> Effect:
    """The inner ring warms before the housing: preload, and drag with it, follow the rate of warming."""

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return run.sign * _behind(run, s, memory)

    return _drag("bearing preload while it warms", law, {"tau": rng.uniform(120.0, 400.0)}, 0.05)


@form("unknown", "thermal bow of the shaft", held_back=True)
def _bow(rng: Rng) -> Effect:
    """A shaft that warms from one side bows: runout once per revolution while it warms, none when it is warm."""

    def law(run: Run, s: Shape, memory: Memory) -> Floats:
        return np.asarray(_behind(run, s, memory) * np.cos(run.theta + s["phase"]))

    shape = {"tau": rng.uniform(120.0, 400.0), "phase": rng.uniform(-np.pi, np.pi)}
    claimed = Location(orders=(1.0,))
    return Formula(
        "unknown", "thermal bow", ("transmission_error",), 5e-6, shape, claimed, hook="transmission", law=law
    )
