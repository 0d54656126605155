"""From a case to recordings and the truth about them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Literal, cast

import numpy as np

from fakes.concealed.campaign import Campaign
from fakes.concealed.catalogue import CaseSpec
from fakes.concealed.clutter import clutter_truth, draw_clutter, merged
from fakes.concealed.design import Point, draw_points
from fakes.concealed.effects.base import Effect
from fakes.concealed.location import measured_location
from fakes.concealed.noise import Sensors, draw_sensors, roughen, scaled
from fakes.concealed.overlap import overlap
from fakes.concealed.plant import RATIO, Plant, draw_plant, elsewhere
from fakes.concealed.recordings import GeneratedRecording, NoiseTally, generate_recordings, recording_id
from fakes.concealed.strength import calibrate, covered
from fakes.concealed.truth import ConcealedEffect, Location, Status, Truth

#: Where the terms of the nominal equations show, for cases that switch one off.
_NOMINAL_CHANNEL = {
    "friction": "motor_torque",
    "motor": "motor_torque",
    "thermal": "temperature",
    "load": "load_torque",
}


_MOST_DRAWS = 8
"""benches that are drawn for one case at most"""


@dataclass(slots=True)
class Folder:
    """One case being made: iterate ``recordings()`` to the end, then ask for ``truth()``."""

    spec: CaseSpec
    campaign: Campaign
    sensors: Sensors
    start: datetime
    effects: tuple[ConcealedEffect, ...]
    tally: NoiseTally

    def recordings(self) -> Iterator[GeneratedRecording]:
        """The recordings in running order."""
        total = sum(p.kind not in ("pause", "unrecorded") for p in self.campaign.points)
        rng = np.random.default_rng([self.spec.seed, 7])
        cut = int(rng.integers(total)) if self.spec.truncate else None
        lost = float(rng.choice([0.0, 0.3])) if self.spec.elsewhere else 0.0
        yield from generate_recordings(self.campaign, self.sensors, self.start, self.tally, cut, lost)

    def truth(self) -> Truth:
        """The sealed answer; the noise is counted while the recordings are made."""
        return Truth(
            case=self.spec.name,
            group=self.spec.group,
            seed=self.spec.seed,
            folder=self.spec.alias,
            verdict="mismatch" if self.effects else "match",
            effects=self.effects,
            noise_rms=self.tally.rms(),
            noise_by_recording=self.tally.by_recording(),
            switched_off=self.spec.switched_off,
            note=self.spec.nuisance,
        )


def open_folder(spec: CaseSpec) -> Folder:
    """Draw bench, sensors and design of a case and calibrate its effects' strengths.

    Where no bench that was drawn makes the effect as like its alternative as the case asks for, the recordings tell the
    two apart: the effect is to be named.
    """
    bench = _bench(spec)
    alike = bench.overlap >= spec.least_overlap
    plant, sensors, points, effects, rng = bench.plant, bench.sensors, bench.points, bench.effects, bench.rng
    floor = noise_floor(sensors)
    strengths: list[float] = []
    locations: list[Location] = []
    for effect, target in zip(effects, spec.strengths, strict=True):
        alone = Campaign(plant, (effect,), points, spec.seed)
        strength_now, excess = calibrate(alone, effect, target, floor[effect.channels[0]])
        strengths.append(strength_now)
        locations.append(measured_location(effect.location(), excess, partial(recording_id, spec.seed)))
    if len(effects) > 1:
        # one effect may warm the bench that another is found on: the recordings cover what all of them make of it
        together = Campaign(plant, effects, points, spec.seed)
        spans = {channel: covered(together, channel) for channel in {e.channels[0] for e in effects}}
        locations = [replace(p, span=spans[e.channels[0]]) for p, e in zip(locations, effects, strict=True)]
    if spec.clutter:
        taken = [order for effect in effects for order in effect.location().orders]
        plant = draw_clutter(plant, taken, np.random.default_rng([spec.seed, 9]))
    start = datetime(2026, 3, 2, 6, 30, tzinfo=UTC) + timedelta(
        days=int(rng.integers(200)), minutes=int(rng.integers(90))
    )
    concealed = [
        ConcealedEffect(
            effect=e.effect,
            status=cast(Status, spec.status if alike else "named"),
            form=e.form,
            channels=e.channels,
            strength=round(s, 3),
            location=location,
            parameters=e.parameters(),
            also=spec.also if alike else (),
            in_library=form.in_library,
        )
        for form, e, s, location in zip(spec.forms, effects, strengths, locations, strict=True)
    ]
    concealed += [_missing(term) for term in spec.switched_off]
    concealed = merged(concealed, clutter_truth(plant, floor["transmission_error"]))
    campaign = Campaign(plant, effects, points, spec.seed)
    return Folder(spec, campaign, sensors, start, tuple(concealed), NoiseTally())


@dataclass(frozen=True, slots=True)
class _Bench:
    """What was drawn for a case, and the generator as it is then."""

    plant: Plant
    sensors: Sensors
    points: tuple[Point, ...]
    effects: tuple[Effect, ...]
    rng: np.random.Generator
    overlap: float = 1.0
    """share of the effect that its alternatives hold, where the case asks for it"""


def _bench(spec: CaseSpec) -> _Bench:
    """Draw bench, sensors, points and the effects' numbers; where a case asks for it, until its effect cannot be told
    from another, or the nearest to that of some draws.
    """
    best: _Bench | None = None
    for number in range(_MOST_DRAWS):
        rng = np.random.default_rng([spec.seed, 5, number] if number else [spec.seed, 5])
        plant, sensors = draw_plant(rng), draw_sensors(rng)
        if spec.elsewhere:
            plant, sensors = elsewhere(plant, rng), scaled(sensors, float(rng.uniform(0.6, 1.7)))
        sensors = roughen(sensors, spec.nuisance, rng)
        points = tuple(draw_points(spec.design, rng))
        effects = tuple(form.make(rng) for form in spec.forms)
        for effect in effects:
            effect.shape.update(spec.shape)
        drawn = _Bench(plant, sensors, points, effects, rng)
        if spec.least_overlap <= 0.0:
            return drawn
        # an effect heats the bench that it is found on: it has to have its size
        campaign, effect = Campaign(plant, effects, points, spec.seed), effects[0]
        calibrate(campaign, effect, spec.strengths[0], noise_floor(sensors)[effect.channels[0]])
        share = overlap(campaign, effect, spec.also)
        if best is None or share > best.overlap:
            best = replace(drawn, overlap=share)
        if share >= spec.least_overlap:
            break
    assert best is not None
    return best


def noise_floor(sensors: Sensors) -> dict[str, float]:
    """Noise RMS of each compared channel expected from the sensors."""

    def rms(sigma: float, step: float, offset: float) -> float:
        return float(np.sqrt(sigma**2 * (1.0 + offset**2) + step**2 / 12.0))

    level = {
        name: rms(n.sigma, n.step, n.offset)
        for name in ("load_angle", "motor_angle", "motor_torque", "load_torque", "load_motor_torque", "temperature")
        for n in (getattr(sensors, name),)
    }
    return {
        "transmission_error": float(np.hypot(level["load_angle"], level["motor_angle"] / RATIO)),
        "motor_torque": level["motor_torque"],
        "temperature": level["temperature"],
        "load_torque": float(np.hypot(level["load_torque"], level["load_motor_torque"])),
    }


def _missing(term: str) -> ConcealedEffect:
    channel = _NOMINAL_CHANNEL[term.split(".")[0]]
    status: Literal["named"] = "named"
    return ConcealedEffect(term, status, "nominal term switched off in the simulation given", (channel,), None)


def with_strength(spec: CaseSpec, strength: float, name: str) -> CaseSpec:
    """The same case at another strength, for a severity sweep."""
    return replace(spec, name=name, strengths=tuple(strength for _ in spec.strengths))
