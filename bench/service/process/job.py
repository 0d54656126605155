"""The order for a run process: written as JSON by the service, read by the process. Imports nothing heavy."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True, slots=True)
class Job:
    """What a run is."""

    run: str
    campaign: str
    """Path of a TOML or Python file, or the name of a shipped one."""
    bench: str
    folder: str
    socket: str
    outcome: str
    """File for the end of the run, so that it is known even if nobody listened."""
    interface: str | None = None
    real_time: bool = False
    seed: int = 0
    resumed_by: str | None = None
    """Who wants torque again after a stop that was acknowledged and reset."""
    reset_by: str | None = None
    """Who wants the drives' faults taken away; nothing is run then."""
    by_hand: float | None = None
    """Nothing is measured: the load side turns at this velocity, rad/s, while somebody holds the button."""
    tares: bool = False
    """Nothing is measured: the torque sensor's zero is taken at rest, without torque."""
    plant: str | None = None
    """What plays an emulated bench in place of the plant its file names: a plant with physics concealed in it."""
    not_before: str | None = None
    """Time (ISO 8601) before which no recording begins."""
    stop_port: int = 0
    """Port on 127.0.0.1 of the run's own stop listener; 0 for any that is free."""

    @classmethod
    def load(cls, path: Path) -> Job:
        """Read a job file."""
        return cls(**json.loads(path.read_text("utf-8")))

    def as_dict(self) -> dict[str, Any]:
        """For the job file."""
        return asdict(self)
