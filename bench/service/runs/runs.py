"""Runs as the service knows them: what was asked, by whom, where it stands, how it ended; kept over a restart."""

from __future__ import annotations

import json
import secrets
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from bench.service.files.disk import Disk
from bench.service.files.kept import Broken
from bench.service.runs.standby import leads_to

State = Literal["proposed", "queued", "running", "ended"]
_KEPT = 200


@dataclass(frozen=True, slots=True)
class Run:
    """One run. ``proposed`` waits for whoever holds the controls, ``queued`` for the runs before it."""

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
    by_hand: float | None = None
    """Motion by hand, rad/s of the load side; nothing is recorded then."""
    tares: bool = False
    """The torque sensor's zero is taken at rest; nothing is recorded then."""
    twin: str | None = None
    """Model that watches it."""
    not_before: str | None = None
    """Time (ISO 8601) before which no recording begins: those of an experiment stand behind the first campaign's."""
    twin_pause: bool = False
    """Whether no further point begins when that model no longer holds."""
    pid: int | None = None
    started_at: str | None = None
    ended_at: str | None = None
    end: dict[str, Any] = field(default_factory=dict)

    @property
    def measures(self) -> bool:
        """Whether it makes recordings: a reset, a motion by hand and a taring make none."""
        return not self.resets and self.by_hand is None and not self.tares

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
    """All runs, oldest first. A change holds at once; the disk follows.

    Parameters
    ----------
    path : file the runs are kept in; where it cannot be read they are rebuilt from the folders of their jobs.
    """

    def __init__(self, path: Path, disk: Disk, broken: Broken) -> None:
        self._path, self._disk = path, disk
        had = path.exists()
        kept = broken.load(path, lambda entries: [Run(**entry) for entry in entries])
        self.rebuilt = had and kept is None
        """Whether the file was broken, so that nobody knows what was waiting."""
        found = rebuild(path.parent / "runs") if self.rebuilt else kept or []
        self._runs: dict[str, Run] = {run.id: run for run in found}
        if self.rebuilt:
            self._save()

    def put(self, run: Run) -> Run:
        """Add or replace a run."""
        self._runs[run.id] = run
        ended = [other.id for other in self._runs.values() if other.state == "ended"]
        for old in ended[:-_KEPT]:
            del self._runs[old]
        self._save()
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

    def _save(self) -> None:
        self._disk.replace(self._path, json.dumps([run.as_dict() for run in self._runs.values()], indent=1))


def rebuild(folder: Path) -> list[Run]:
    """Return the runs whose jobs were written, oldest first: those whose process lives run, the others have ended."""
    found = []
    for path in sorted(folder.glob("*/job.json")):
        try:
            job = json.loads(path.read_text("utf-8"))
            run = Run(
                id=path.parent.name,
                campaign=str(job["campaign"]),
                title=Path(job["folder"]).name,
                bench=str(job["bench"]),
                folder=str(job["folder"]),
                by=str(job.get("resumed_by") or job.get("reset_by") or "somebody"),
                asked_at=datetime.fromtimestamp(path.stat().st_mtime, UTC).isoformat(timespec="seconds"),
                interface=job.get("interface"),
                real_time=bool(job.get("real_time")),
                seed=int(job.get("seed", 0)),
                resets=job.get("reset_by") is not None,
                by_hand=job.get("by_hand"),
                tares=bool(job.get("tares")),
            )
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            # neither is the job of any use; recordings stay, and a run of them can be started anew
            continue
        pid = process_of(path)
        if pid is not None:
            found.append(replace(run, state="running", pid=pid))
        else:
            end = {"kind": "unknown", "text": "how it ended was lost with runs.json"}
            found.append(replace(run, state="ended", end=end))
    return found


def process_of(job: Path, pid: int | None = None) -> int | None:
    """Return the process that does a job, by its command line; ``pid`` is the only one looked at, None for all."""
    wanted = str(job.absolute()).encode()
    for path in Path("/proc").glob(f"{'[0-9]*' if pid is None else pid}/cmdline"):
        try:
            if any(word == wanted or leads_to(word, wanted) for word in path.read_bytes().split(b"\0")):
                return int(path.parent.name)
        except OSError:
            # ended between listing and looking
            continue
    return None
