"""Campaigns that are watched while they run: one bench, a campaign to know it by, others in which something begins.

The strength of a change is the RMS of what it adds to its channel in the steady samples since it began, in units of the
channel's noise. Of the room, which shows in the temperature's course alone, it is K for each unit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

import numpy as np

import fakes.concealed.catalogue  # noqa: F401 - registers every form
from fakes.concealed.campaign import Campaign
from fakes.concealed.design import Design, draw_points
from fakes.concealed.effects.base import Effect, Floats, Run
from fakes.concealed.effects.beginning import Beginning, WarmerRoom
from fakes.concealed.effects.formula import FORMS, Formula
from fakes.concealed.folder import noise_floor
from fakes.concealed.noise import Sensors, draw_sensors
from fakes.concealed.plant import Plant, draw_plant
from fakes.concealed.recordings import GeneratedRecording, NoiseTally, generate_recordings

Rng = np.random.Generator
DESIGN = Design(
    loads=(-1000.0, -600.0, -250.0, 0.0, 250.0, 600.0, 1000.0),
    speeds=(5.0, 7.5, 10.0),
    levels=3,
    warm_ups=2,
    grid=34,
    validation=4,
    anchors=1,
    transients=(0, 0, 0),
    heat_time=300.0,
)
KNOWN = replace(DESIGN, grid=54, validation=8, anchors=2, transients=(1, 1, 0))
"""the campaign by which the bench is known; more of the same"""
RATE_HZ = 200.0
ROOM_K = 4.0
"""K by which the room warms at strength 1"""


def _pin(rng: Rng) -> Effect:
    forms = [f for f in FORMS if f.effect == "te.local_defect" and not f.held_back]
    return forms[int(rng.integers(len(forms)))].make(rng)


def _oil(rng: Rng) -> Effect:
    share = float(rng.uniform(0.3, 0.7))

    def law(run: Run, shape: dict[str, float], memory: dict[str, object]) -> Floats:
        return np.asarray(run.sign * (share + (1.0 - share) * np.abs(run.rate) / 0.17))

    return Formula("friction.coulomb", "drag of a gearbox low of oil", ("motor_torque",), 0.1, hook="friction", law=law)


def _zero(rng: Rng) -> Effect:
    way = float(rng.choice([-1.0, 1.0]))

    def law(run: Run, shape: dict[str, float], memory: dict[str, object]) -> Floats:
        return np.full(run.time.size, way)

    return Formula("load.torque_offset", "the zero walks", ("load_torque",), 1.0, hook="sensor_reading", law=law)


def _coupling(rng: Rng) -> Effect:
    forms = [f for f in FORMS if f.effect == "te.lost_motion" and not f.held_back]
    return forms[int(rng.integers(len(forms)))].make(rng)


def _room(rng: Rng) -> Effect:
    return WarmerRoom("thermal.convection", "warmer surroundings", ("temperature",), 1.0)


def _runs_in(rng: Rng) -> Effect:
    def law(run: Run, shape: dict[str, float], memory: dict[str, object]) -> Floats:
        return np.asarray(-run.sign)

    return Formula("friction.run_in", "drag that runs in", ("motor_torque",), 0.1, hook="friction", law=law)


CHANGES: dict[str, tuple[Callable[[Rng], Effect], float]] = {
    "a pin chips": (_pin, 0.0),
    "oil runs low": (_oil, 600.0),
    "the torque sensor's zero walks": (_zero, 900.0),
    "a coupling loosens": (_coupling, 0.0),
    "the room warms": (_room, 0.0),
    "friction runs in": (_runs_in, 600.0),
}
"""what may begin, and in which time (s) it grows"""


@dataclass(frozen=True, slots=True)
class Watched:
    """One campaign: ``since`` index among its recordings of the first with the change (None: there is no change)."""

    campaign: Campaign
    sensors: Sensors
    start: datetime
    change: str | None
    since: int | None
    channel: str | None

    def recordings(self) -> Iterator[GeneratedRecording]:
        """The recordings in running order."""
        yield from generate_recordings(self.campaign, self.sensors, self.start, NoiseTally(), rate_hz=RATE_HZ)


def bench_of(seed: int) -> tuple[Plant, Sensors]:
    """A bench drawn with ``seed``."""
    rng = np.random.default_rng([seed, 40])
    return draw_plant(rng), draw_sensors(rng)


def known_by(seed: int) -> Watched:
    """The campaign by which bench ``seed`` is known: nothing begins in it."""
    return _watched(seed, 0, KNOWN, None, 0.0)


def watched(bench: int, number: int, change: str | None = None, strength: float = 0.0) -> Watched:
    """Campaign ``number`` (from 1) of a bench, with a change at a strength, or without."""
    return _watched(bench, number, DESIGN, change, strength)


def _watched(bench: int, number: int, design: Design, change: str | None, strength: float) -> Watched:
    rng = np.random.default_rng([bench, 41, number])
    plant, sensors = bench_of(bench)
    points = tuple(draw_points(design, rng))
    seed = int(rng.integers(1, 2**31))
    start = datetime(2026, 5, 4, 6, 0, tzinfo=UTC) + timedelta(days=number, minutes=int(rng.integers(90)))
    if change is None:
        return Watched(Campaign(plant, (), points, seed), sensors, start, None, None, None)
    recorded = [i for i, p in enumerate(points) if p.kind not in ("pause", "unrecorded")]
    since = int(rng.integers(int(0.45 * len(recorded)), int(0.6 * len(recorded))))
    make, grows = CHANGES[change]
    effect = make(rng)
    channel = effect.channels[0]
    begins = Beginning.of(effect, recorded[since], grows)
    if channel == "temperature":
        effect.amplitude = ROOM_K * strength
    else:
        _scale(Campaign(plant, (begins,), points, seed), effect, channel, strength * noise_floor(sensors)[channel])
    return Watched(Campaign(plant, (begins,), points, seed), sensors, start, change, since, channel)


def _scale(campaign: Campaign, effect: Effect, channel: str, size: float) -> None:
    """Set the amplitude so that what it adds has the RMS ``size`` over the steady samples in which it is felt."""
    squares = []
    for signals in campaign.run(25.0, angle=False):
        for name, a, b in signals.motion.segments:
            if name == "steady":
                squares.append(signals.added[channel][a:b] ** 2)
    every = np.concatenate(squares)
    felt = every[every > 0.01 * every.max()]
    effect.amplitude *= size / float(np.sqrt(felt.mean()))
