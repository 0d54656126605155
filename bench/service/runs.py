"""Runs as the service knows them: what was asked, by whom, where it stands, how it ended; kept over a restart."""

from __future__ import annotations

import json
import os
import secrets
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

State = Literal["proposed", "queued", "running", "ended"]
_KEPT = 200


@dataclass(frozen=True, slots=True)
class Run:
    """One run. ``proposed`` waits for whoever holds the controls, ``queued`` for its turn."""

    id: str
    campaign: str
    """Name of a shipped campaign or path of a file."""
    title: str
    bench: str
    folder: str
    by: str
    asked_at: str
    state: State = "queued"
    interface: str | None = None
    real_time: bool = False
    seed: int = 0
    resumes: bool = False
    """Torque may be given again after a stop that was acknowledged and reset."""
    resets: bool = False
    """Nothing is run: the drives' faults are taken away."""
    pid: int | None = None
    started_at: str | None = None
    ended_at: str | None = None
    end: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """For the page and the file."""
        return asdict(self)


def now() -> str:
    """UTC, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def new_id() -> str:
    """Return an id that sorts by time."""
    return f"{datetime.now(UTC):%Y%m%dT%H%M%S}-{secrets.token_hex(3)}"


def following(run: Run, by: str, **changes: Any) -> Run:
    """Return a new run on the same bench, campaign and folder, in the name of ``by``."""
    fresh = {"id": new_id(), "by": by, "asked_at": now(), "state": "queued", "pid": None, "started_at": None}
    return replace(run, **{**fresh, "ended_at": None, "end": {}, "resumes": False, "resets": False, **changes})


class Runs:
    """All runs, oldest first; every change is on the disk before it is answered."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._path = path
        entries = json.loads(path.read_text("utf-8")) if path.exists() else []
        self._runs: dict[str, Run] = {entry["id"]: Run(**entry) for entry in entries}

    def put(self, run: Run) -> Run:
        """Add or replace a run."""
        self._runs[run.id] = run
        ended = [other.id for other in self._runs.values() if other.state == "ended"]
        for old in ended[:-_KEPT]:
            del self._runs[old]
        part = self._path.with_suffix(".part")
        part.write_text(json.dumps([other.as_dict() for other in self._runs.values()], indent=1), encoding="utf-8")
        os.replace(part, self._path)
        return run

    def change(self, id_: str, **changes: Any) -> Run:
        """Replace fields of a run."""
        return self.put(replace(self._runs[id_], **changes))

    def get(self, id_: str) -> Run | None:
        """Return a run by its id."""
        return self._runs.get(id_)

    def all(self) -> list[Run]:
        """All runs, oldest first."""
        return list(self._runs.values())

    def running(self) -> Run | None:
        """The run that has the bench."""
        return next((run for run in self._runs.values() if run.state == "running"), None)

    def next(self) -> Run | None:
        """The run whose turn it is."""
        return next((run for run in self._runs.values() if run.state == "queued"), None)
