"""A bench being tried out: slow motion with little torque, everything that comes back kept in memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.commissioning.guide import Guide
from bench.configuration import BenchConfiguration, BenchFile
from bench.cycle.assembly import device_errors
from bench.cycle.end import EndKind
from bench.cycle.rig import Rig
from bench.errors import LimitError
from bench.protocols import Phase, Segment

_OPEN = 1.0
"""rad: encoders of which the signs are not known may disagree by so much while they are found."""


class Tape:
    """A sink that keeps raw rows; ``steady`` says which were taken in steady motion."""

    def __init__(self) -> None:
        self._blocks: list[dict[str, NDArray[Any]]] = []
        self._steady: list[NDArray[np.bool_]] = []
        self._now = False
        self.events: list[str] = []

    def segment(self, segment: Segment | None) -> None:
        """Note what comes next."""
        self._now = segment is Segment.STEADY

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Keep a block."""
        self._blocks.append({name: values.copy() for name, values in raw.items()})
        self._steady.append(np.full(raw["cycle"].size, self._now))

    def event(self, level: str, text: str) -> None:
        """Keep the text."""
        self.events.append(text)

    def raw(self, name: str, *, steady: bool = True) -> NDArray[Any]:
        """Return raw values of a channel, in steady motion only or all."""
        chosen = np.concatenate(self._steady) if steady else slice(None)
        values: NDArray[Any] = np.concatenate([block[name] for block in self._blocks])[chosen]
        return values


@dataclass(slots=True)
class Trial:
    """What every step gets.

    ``values`` are numbers for the record, filled by the step that runs.
    """

    file: BenchFile
    rig: Rig
    guide: Guide
    by: str
    values: dict[str, Any] = field(default_factory=dict)

    @property
    def bench(self) -> BenchConfiguration:
        """The bench file as it is, not as it is tried out."""
        return self.file.configuration

    @property
    def speed(self) -> float:
        """Load-side speed of the trial, rad/s."""
        return self.bench.commissioning.motor_speed / self.bench.gearbox.ratio

    @property
    def load(self) -> float:
        """Load put on for the trial, N·m."""
        return self.bench.commissioning.load_torque or 0.1 * self.bench.limits.load_torque

    def si(self, tape: Tape, name: str, *, steady: bool = True) -> NDArray[np.float64]:
        """Return a channel of a tape in SI units."""
        scaling = self.rig.scaling
        return tape.raw(name, steady=steady) * scaling.scale(name) + scaling.offset(name)

    def move(self, phases: Sequence[Phase]) -> Tape:
        """Run phases from rest to rest.

        Raises
        ------
        LimitError
            If the bench stopped on the way.
        """
        tape = Tape()
        end = self.rig.run(phases, tape, lambda: False)
        if end.kind is not EndKind.FINISHED:
            raise LimitError(f"the bench stopped while it was tried out: {end.text}")
        return tape

    def watch(self, duration_s: float) -> Tape:
        """Keep what comes back for a while at the set values there are; nothing is judged."""
        tape, link = Tape(), self.rig.link
        remaining = link.cycles(duration_s)
        with device_errors():
            while remaining > 0:
                n = min(remaining, link.assembly.block)
                seen = link.exchange(np.full(n, link.velocity), np.full(n, link.torque))
                tape.rows({name: values[seen.inputs.good] for name, values in seen.raw.items()})
                remaining -= seen.size
        return tape

    def push(self, load_torque: float, duration_s: float) -> Tape:
        """Give the load drive torque and the input drive none, for a while; both are without voltage afterwards."""
        tape, link = Tape(), self.rig.link
        cycle = self.bench.bus.cycle_time
        ramp = np.linspace(0.0, load_torque, link.cycles(load_torque / self.bench.motion.torque_rate))
        course = np.concatenate((ramp, np.full(link.cycles(duration_s), load_torque), ramp[::-1]))
        with device_errors():
            link.arm(True)
            link.lead("ENABLED", "reach operation enabled", only="load_drive")
            for start in range(0, course.size, max(1, round(0.02 / cycle))):
                part = course[start : start + max(1, round(0.02 / cycle))]
                seen = link.exchange(np.zeros(part.size), part)
                tape.rows({name: values[seen.inputs.good] for name, values in seen.raw.items()})
            link.lead("DISABLED", "lose their voltage")
            link.arm(False)
        return tape

    def turn(self, speed: float, duration_s: float, load: float = 0.0) -> tuple[Phase, ...]:
        """Return phases: up to ``speed``, load on, ``duration_s`` of steady motion, load off, down to rest."""
        motion, ratio = self.bench.motion, self.bench.gearbox.ratio
        ramp = max(0.2, abs(speed) * ratio / motion.motor_acceleration)
        loading = abs(load) / motion.torque_rate
        phases = [
            Phase(None, ramp, speed, 0.0),
            Phase(None, 0.3, speed, 0.0),
            Phase(None, loading + 0.5, speed, load),
            Phase(Segment.STEADY, duration_s, speed, load),
            Phase(None, loading + 0.1, speed, 0.0),
            Phase(None, ramp, 0.0, 0.0),
            Phase(None, 0.2, 0.0, 0.0),
        ]
        return tuple(phases)


def slow(file: BenchFile) -> BenchFile:
    """Return the bench with the limits of a trial: a share of torque and speed, in the drives too; signs left open."""
    config = file.configuration
    share, limits = config.commissioning.torque_share, config.limits
    load = config.commissioning.load_torque or 0.1 * limits.load_torque
    tried = limits.model_copy(
        update={
            "motor_speed": min(limits.motor_speed, 2.0 * config.commissioning.motor_speed),
            "motor_torque": share * limits.motor_torque,
            "load_torque": max(share * limits.load_torque, 2.0 * load),
            "load_motor_torque": max(share * limits.load_motor_torque, 2.0 * load),
            "encoder_disagreement": _OPEN,
            "torque_disagreement": 4.0 * load,
            "friction_torque": None,
            "torque_drift": None,
        }
    )
    return BenchFile(config.model_copy(update={"limits": tried}), file.text, file.origin)
