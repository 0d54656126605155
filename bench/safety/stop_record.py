"""What is kept of a stop: cause, times of every rung, coast-down, and how the drives were left."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any

from bench.safety.causes import Cause, Rung


@dataclass(frozen=True, slots=True)
class RungRecord:
    """One rung of the ladder: when it began after the stop did, and how long it was in force, s of the bench.

    ``at_ns`` is when it began by the clock, Unix time in ns; None where the bench's time is not the clock's.
    """

    rung: str
    began_s: float
    lasted_s: float
    at_ns: int | None = None


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

    ``at`` is bench time of day, ``cycle`` the bus cycle in which the stop began, None where none was seen;
    ``to_rest_s`` is None where not both shafts were seen at rest, and ``shafts_at_rest`` says of each whether it was,
    None where nothing of it was seen; ``lasted_s`` is None where nobody led the stop; ``motor_travel_rad`` is what the
    motor was seen to turn from the stop on, either way, None where nothing was seen. ``rest_seen_at_ns`` is when both
    shafts were seen at rest by the clock, Unix time in ns, None where nobody saw it or the bench's time is not the
    clock's.
    """

    cause: Cause
    text: str
    at: datetime
    cycle: int | None
    rungs: tuple[RungRecord, ...]
    to_rest_s: float | None
    shafts_at_rest: dict[str, bool | None]
    lasted_s: float | None
    motor_travel_rad: float | None
    coast_down: tuple[Sample, ...]
    drives: dict[str, str]
    rest_seen_at_ns: int | None = None

    @property
    def summary(self) -> str:
        """One sentence for the recording's events."""
        steps = ", ".join(f"{rung.rung} {rung.lasted_s:.3g} s" for rung in self.rungs)
        rest = "not seen at rest" if self.to_rest_s is None else f"at rest after {self.to_rest_s:.3g} s"
        travel = "unseen" if self.motor_travel_rad is None else f"{self.motor_travel_rad:.3g} rad"
        drives = ", ".join(f"{role} {state}" for role, state in self.drives.items())
        return f"stop: {rest}, motor travel {travel} ({steps or 'nobody led it'}); {drives}"

    @property
    def rest_text(self) -> str:
        """What was seen of the shafts at the end, in one sentence."""
        if all(self.shafts_at_rest.values()):
            return "bench at rest"
        unseen = " and ".join(shaft for shaft, rest in self.shafts_at_rest.items() if not rest)
        return f"the stop has ended; not seen at rest: {unseen} shaft"

    def as_dict(self) -> dict[str, Any]:
        """Return the record for JSON."""
        return {**asdict(self), "cause": self.cause.name, "at": self.at.isoformat(timespec="milliseconds")}


def rung_name(rung: Rung) -> str:
    """Return a rung as people read it."""
    return rung.name.lower().replace("_", " ")
