"""What is kept of a stop: cause, times of every rung, coast-down, and how the drives were left."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any

from bench.safety.causes import Cause, Rung


@dataclass(frozen=True, slots=True)
class RungRecord:
    """One rung of the ladder: when it began after the stop did, and how long it was in force, s."""

    rung: str
    began_s: float
    lasted_s: float


@dataclass(frozen=True, slots=True)
class Sample:
    """One moment of the coast-down: s after the stop began; speeds of both shafts, rad/s; torque sensor, N·m."""

    time_s: float
    motor_speed: float
    load_speed: float
    load_torque: float


@dataclass(frozen=True, slots=True)
class StopRecord:
    """One stop of a bench.

    ``at`` is bench time of day, ``cycle`` the bus cycle in which the stop began; ``to_rest_s`` is None where the shafts
    were not seen at rest; ``motor_travel_rad`` is what the motor turned from the stop on, either way.
    """

    cause: Cause
    text: str
    at: datetime
    cycle: int
    rungs: tuple[RungRecord, ...]
    to_rest_s: float | None
    lasted_s: float
    motor_travel_rad: float
    coast_down: tuple[Sample, ...]
    drives: dict[str, str]

    @property
    def summary(self) -> str:
        """One sentence for the recording's events."""
        steps = ", ".join(f"{rung.rung} {rung.lasted_s:.3g} s" for rung in self.rungs)
        rest = "not seen at rest" if self.to_rest_s is None else f"at rest after {self.to_rest_s:.3g} s"
        drives = ", ".join(f"{role} {state}" for role, state in self.drives.items())
        return f"stop: {rest} and {self.motor_travel_rad:.3g} rad of the motor ({steps}); {drives}"

    def as_dict(self) -> dict[str, Any]:
        """Return the record for JSON."""
        return {**asdict(self), "cause": self.cause.name, "at": self.at.isoformat(timespec="milliseconds")}


def rung_name(rung: Rung) -> str:
    """Return a rung as people read it."""
    return rung.name.lower().replace("_", " ")
