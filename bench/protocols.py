"""What a bench and a sequence are to each other. Imports nothing of ours, so that anyone may import it.

A sequence is a pure function: from a point (what is to be measured) and the facts of a bench (ratio, ramps, limits) to
a tuple of phases. A phase leads velocity and torque from wherever they stand to an end value within a given time; what
plans a campaign and what runs it read the very same phases.

Angles and velocities are those of the load side in rad and rad/s unless a name says ``motor``; torques in N·m, in the
sign of the torque sensor; temperatures in °C.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Protocol, runtime_checkable

import numpy as np


class Segment(Enum):
    """Names of segments in a recording (recording-format.md)."""

    RAMP_UP = "ramp_up"
    STEADY = "steady"
    RAMP_DOWN = "ramp_down"
    DWELL = "dwell"
    HEAT = "heat"


@dataclass(frozen=True, slots=True)
class Unit:
    """Kind of physical quantity of a field (``torque``, ``speed``, …), so that files can give it with a unit."""

    kind: str


Angle = Annotated[float, Unit("angle")]
Time = Annotated[float, Unit("time")]
Speed = Annotated[float, Unit("speed")]
Torque = Annotated[float, Unit("torque")]
Temperature = Annotated[float, Unit("temperature")]


@dataclass(frozen=True, slots=True)
class BenchFacts:
    """What a sequence may know of the bench it runs on, in SI."""

    ratio: float
    motor_acceleration: float
    """Motor shaft, rad/s²."""
    torque_rate: float
    """Load side, N·m/s."""
    settling_s: float
    heating_motor_speed: float
    heating_time_limit_s: float
    heating_hysteresis: float
    """Heating goes this many K above the wanted temperature."""
    heating_soak_s: float
    ambient_temperature: float

    def velocity_ramp_s(self, start: float, end: float) -> float:
        """Time in s to go from one load-side velocity to another at the bench's acceleration."""
        return abs(end - start) * self.ratio / self.motor_acceleration

    def torque_ramp_s(self, start: float, end: float) -> float:
        """Time in s to go from one load torque to another at the bench's rate."""
        return abs(end - start) / self.torque_rate


@dataclass(frozen=True, slots=True)
class Point:
    """What is to be measured: an operating point and the sequence that visits it.

    ``temperature`` None means: at whatever the lubricant has (nothing is heated or cooled for it).
    ``repeat`` counts equal points from 1, so that each is a point of its own.
    """

    sequence: str
    load_torque: float = 0.0
    velocity: float = 0.0
    temperature: float | None = None
    repeat: int = 1
    stage: str = ""
    options: tuple[tuple[str, float], ...] = ()

    @property
    def label(self) -> str:
        """A short name for people, in degrees and °C."""
        temperature = "as found" if self.temperature is None else f"{self.temperature:.3g} °C"
        again = f", repeat {self.repeat}" if self.repeat > 1 else ""
        return f"{self.sequence} {self.load_torque:.4g} N·m, {np.degrees(self.velocity):.3g} °/s, {temperature}{again}"


class Until(Enum):
    """Condition that ends a phase before its time is over."""

    WARMER = "temperature at or above"
    COOLER = "temperature at or below"


@dataclass(frozen=True, slots=True)
class Phase:
    """A stretch of motion: velocity and torque go linearly from where they stand to these values in ``duration_s``.

    With a condition, ``duration_s`` is the time limit: reaching it without the condition met is a failed point.
    """

    segment: Segment | None
    duration_s: float
    velocity: float
    """Load side, rad/s, at the end of the phase."""
    load_torque: float
    """N·m at the end of the phase."""
    until: Until | None = None
    temperature: float = float("nan")
    """Threshold of the condition, °C."""


@dataclass(frozen=True, slots=True)
class Request:
    """What a campaign asks of a sequence: the values its points are made of.

    ``start_temperature`` is what the lubricant has when the campaign begins; None in ``temperatures`` means as found.
    """

    sequence: str
    load_torques: tuple[float, ...] = (0.0,)
    velocities: tuple[float, ...] = (0.0,)
    temperatures: tuple[float | None, ...] = (None,)
    repeats: int = 1
    stage: str = ""
    start_temperature: float = float("nan")
    options: tuple[tuple[str, float], ...] = ()


@runtime_checkable
class Sequence(Protocol):
    """One kind of measurement. Implementations are found by entry point (group ``bench.sequences``).

    They are frozen dataclasses: their fields are the options a campaign file may give, annotated with
    :class:`Unit` where they are quantities.
    """

    @property
    def kind(self) -> str:
        """Kind of recording (recording-format.md)."""
        ...

    @property
    def prepares_temperature(self) -> bool:
        """Whether the lubricant is brought to the point's temperature before; False where the sequence does it."""
        ...

    def points(self, request: Request) -> tuple[Point, ...]:
        """Return the points a request stands for."""
        ...

    def phases(self, point: Point, bench: BenchFacts) -> tuple[Phase, ...]:
        """Return the motion; the first phase starts at rest without load, the last ends there."""
        ...
