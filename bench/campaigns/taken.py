"""What became of points: status, one recording that was taken, the summary of a run."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from enum import Enum
from hashlib import sha256
from typing import Any

from bench.cycle.end import End, EndKind
from bench.protocols import Phase, Point


class Status(Enum):
    """What became of a point or of one take of it."""

    DONE = "done"
    FAILED = "failed"
    SKIPPED = "skipped"
    PENDING = "pending"


@dataclass(frozen=True, slots=True)
class Taken:
    """One recording that was made; what ``campaign.json`` says of it."""

    recording_id: str
    file: str
    kind: str
    label: str
    setpoint: dict[str, float | None]
    point_id: str
    take: int
    status: Status
    note: str = ""
    quality: dict[str, Any] = field(default_factory=dict)
    duration_s: float = 0.0
    samples: int = 0
    complete: bool | None = None
    """Whether its motion came to its end; false for one that was stopped, None where that is not known."""

    def as_dict(self) -> dict[str, Any]:
        """For ``campaign.json`` and the journal."""
        return {
            "recording_id": self.recording_id,
            "file": self.file,
            "kind": self.kind,
            "label": self.label,
            "setpoint": self.setpoint,
            "status": self.status.value,
            "quality": self.quality,
            "point_id": self.point_id,
            "take": self.take,
            "note": self.note,
            "duration_s": self.duration_s,
            "samples": self.samples,
            "complete": self.complete,
        }

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Taken:
        """Read what :meth:`as_dict` wrote."""
        return cls(**{**data, "status": Status(data["status"])})


@dataclass(slots=True)
class Summary:
    """What a run of a campaign brought."""

    end: End = field(default_factory=lambda: End(EndKind.FINISHED))
    taken: list[Taken] = field(default_factory=list)
    earlier: int = 0
    """Points that an earlier run had done already."""
    bench_time_s: float = 0.0
    cycles: int = 0
    tare_drift: float = math.nan
    """Change of the torque sensor's zero over the campaign, N·m; NaN where it was not measured."""

    stop_record: str | None = None
    """File, in the folder of the recordings, that the last stop was written to; None where none was written."""

    @property
    def failed(self) -> list[Taken]:
        """Last takes of points that never passed."""
        good = {taken.point_id for taken in self.taken if taken.status is Status.DONE}
        last = {taken.point_id: taken for taken in self.taken if taken.point_id not in good}
        return [taken for taken in last.values() if taken.status is not Status.SKIPPED]


def point_id(point: Point, bench_digest: str) -> str:
    """Return what a point is, by content: the point itself and the bench configuration it is measured under."""
    content = [
        point.sequence,
        point.load_torque,
        point.velocity,
        point.temperature,
        point.repeat,
        point.stage,
        list(point.options),
        bench_digest,
    ]
    return sha256(json.dumps(content).encode()).hexdigest()[:16]


def commanded_velocity(point: Point, phases: tuple[Phase, ...]) -> float:
    """Return the load-side velocity that stands for a point: its own, or that of the phase that waits (heating)."""
    waiting = [phase.velocity for phase in phases if phase.until is not None]
    return waiting[0] if waiting and point.velocity == 0.0 else point.velocity


def setpoint_dict(point: Point) -> dict[str, float | None]:
    """Return the set point as the manifest has it; None where nothing is commanded."""
    return {"load_torque": point.load_torque, "velocity": point.velocity, "temperature": point.temperature}
