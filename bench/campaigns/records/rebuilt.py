"""A journal that cannot be read is put aside and rebuilt from the headers of the recordings."""

from __future__ import annotations

import json
import math
import sqlite3
from dataclasses import dataclass, field
from datetime import datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

from bench.campaigns.taken import Status, Taken
from bench.errors import RecordingError
from bench.names import why_no_name
from bench.recording import Recording, guarded
from bench.recording.header import PART_SUFFIX
from bench.recording.reader import open_file
from bench.recording.repairing import repair

CAMPAIGN_DIGEST, START_TEMPERATURE = "campaign_digest", "campaign_start_temperature"
"""Root attributes of a recording from which the journal's own words are taken."""
_NOT_BROKEN = frozenset(
    {
        sqlite3.SQLITE_FULL,
        sqlite3.SQLITE_READONLY,
        sqlite3.SQLITE_BUSY,
        sqlite3.SQLITE_LOCKED,
        sqlite3.SQLITE_CANTOPEN,
        sqlite3.SQLITE_PERM,
        sqlite3.SQLITE_NOMEM,
    }
)


@dataclass
class Found:
    """Contents of the headers of a folder's recordings.

    Attributes
    ----------
    takes : in the order in which they were made.
    kept : what the journal remembers of the campaign, by its keys.
    notes : files that say nothing, and why.
    """

    takes: list[Taken] = field(default_factory=list)
    kept: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def is_broken(error: Exception) -> bool:
    """Whether an error says that the database itself is damaged, not that the disk refuses or somebody has it."""
    code = getattr(error, "sqlite_errorcode", None)
    # the low byte is the kind of error, the rest says where it is
    return code is None or code & 0xFF not in _NOT_BROKEN


def require_whole(database: sqlite3.Connection) -> None:
    """Read all of a journal.

    Raises
    ------
    sqlite3.DatabaseError, ValueError, KeyError, TypeError
        If something of it cannot be read, or names a file elsewhere.
    """
    (verdict,) = database.execute("PRAGMA quick_check(1)").fetchone()
    if verdict != "ok":
        raise sqlite3.DatabaseError(str(verdict))
    kept = dict(database.execute("SELECT key, value FROM campaign").fetchall())
    if not math.isfinite(float(kept.get("start_temperature", 0.0))):
        raise ValueError("the temperature at the start is no number")
    rows = database.execute("SELECT recording_id, point_id, take, status, content FROM takes").fetchall()
    for recording_id, point_id, take, status, content in rows:
        taken = Taken.from_dict(json.loads(content))
        if (taken.recording_id, taken.point_id, taken.take) != (recording_id, point_id, take) or not status:
            raise ValueError(f"the row of {recording_id} contradicts itself")
        for name in (taken.recording_id, taken.file):
            if why_no_name(name) is not None:
                raise ValueError(f"a file {why_no_name(name)}")


def put_aside(path: Path) -> str:
    """Rename a database and what belongs to it; return the new name."""
    ending = f".broken-{datetime.now():%Y%m%dT%H%M%S}"
    for suffix in ("-wal", "-shm", ""):
        part = path.with_name(path.name + suffix)
        if part.exists():
            part.rename(part.with_name(part.name + ending))
    return path.name + ending


def rebuild(folder: Path) -> Found:
    """Return what the recordings of a folder say; one that was not finished is repaired first."""
    found = Found()
    for part in sorted(folder.glob(f"*.h5{PART_SUFFIX}")):
        try:
            repair(part)
        except RecordingError as error:
            found.notes.append(str(error))
    read: list[dict[str, Any]] = []
    for path in sorted(folder.glob("*.h5")):
        try:
            read.append(guarded.call(path, read_take, path))
        except RecordingError as error:
            found.notes.append(str(error))
    for content in sorted(read, key=lambda content: str(content["started_at"])):
        if content["taken"] is not None:
            found.takes.append(Taken.from_dict(content["taken"]))
            for key, value in content["kept"].items():
                found.kept.setdefault(key, value)
    return found


def read_take(path: Path) -> dict[str, Any]:
    """Return what one recording says of its take and its campaign; no take where it belongs to no point.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    recording = Recording.open(path)
    with open_file(path) as file:
        attributes = {
            str(name): file.attrs[name] for name in ("label", CAMPAIGN_DIGEST, START_TEMPERATURE) if name in file.attrs
        }
    started = recording.started_at.isoformat()
    if recording.point_id is None or recording.take is None:
        return {"started_at": started, "taken": None, "kept": {}}
    passed = recording.complete and bool(recording.accepted)
    setpoint = recording.setpoint
    taken = Taken(
        path.stem,
        path.name,
        recording.kind,
        str(attributes.get("label", recording.kind)),
        {
            name: None if value != value else value
            for name, value in (
                ("load_torque", setpoint.load_torque),
                ("velocity", setpoint.velocity),
                ("temperature", setpoint.temperature),
            )
        },
        recording.point_id,
        recording.take,
        Status.DONE if passed else Status.FAILED,
        "" if passed else "not accepted" if recording.complete else "cut short",
        dict(recording.quality or {}),
        recording.size / recording.sample_rate,
        recording.size,
        recording.complete,
    )
    kept = {"id": recording.campaign_id, "created_at": started, "zero": recording.zero_id or "unnamed"}
    if recording.config is not None:
        kept["bench"] = sha256(recording.config.encode()).hexdigest()
    if CAMPAIGN_DIGEST in attributes:
        kept["campaign"] = str(attributes[CAMPAIGN_DIGEST])
    if START_TEMPERATURE in attributes:
        kept["start_temperature"] = repr(float(attributes[START_TEMPERATURE]))
    return {"started_at": started, "taken": taken.as_dict(), "kept": kept}
