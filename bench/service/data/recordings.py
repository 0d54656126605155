"""Folders of recordings and their plots for the page; reads only, and never outside the folder it is given."""

from __future__ import annotations

import json
import os
import sqlite3
from collections import Counter
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from bench.archive import read_notes
from bench.errors import RecordingError
from bench.names import require_name
from bench.recording import Recording, RecordingFolder, guarded
from bench.service.data.plots import plot, short

_CUT_SHORT = "cut short"


class UnknownPlace(RecordingError):
    """A folder or recording of this name is not there."""


def inside(root: Path, name: str) -> Path:
    """Return the folder or file ``name`` of ``root``.

    Raises
    ------
    UnknownPlace
        If it is not there, or if the name, or a link of this name, leads out of ``root``.
    """
    require_name(name, f"what is asked for in {root},", UnknownPlace)
    path = root / name
    try:
        place = path.resolve(strict=True)
    except (OSError, RuntimeError):
        raise UnknownPlace(f'there is no "{name}" in {root}') from None
    if not place.is_relative_to(root.resolve()):
        raise UnknownPlace(f'"{name}" is a link that leads out of {root}; copy what it leads to')
    return path


def recordings_of(root: Path, folder: str) -> list[dict[str, Any]]:
    """Return what a folder of ``root`` holds; its files are opened in a child process."""
    return recordings(inside(root, folder))


def plot_of(root: Path, folder: str, file: str, start_s: float, stop_s: float | None) -> dict[str, Any]:
    """Return a stretch of a recording as a page plots it, read in a child process: a damaged file ends that one."""
    path = inside(inside(root, folder), file)
    return guarded.call(path, plot, path, start_s, stop_s)


def revolution_of(root: Path, folder: str, file: str) -> dict[str, Any]:
    """Return transmission error and order spectrum of a recording, read in a child process."""
    path = inside(inside(root, folder), file)
    return guarded.call(path, revolution, path)


def folders(root: Path) -> list[dict[str, Any]]:
    """Return the campaign folders, newest first, from names and sizes alone."""
    out = []
    for path in root.iterdir() if root.is_dir() else ():
        if path.name.startswith(".") or not path.is_dir() or not path.resolve().is_relative_to(root.resolve()):
            continue
        files = _sizes(path)
        if not files and not (path / "journal.sqlite").exists():
            continue
        manifest = _manifest(path)
        planned = {entry.get("point_id") for entry in manifest.get("recordings", [])} - {None}
        states = _states(path)
        out.append(
            {
                "name": path.name,
                "campaign": manifest.get("campaign_id", path.name),
                "bench": manifest.get("bench"),
                "recordings": len(files),
                "bytes": sum(file.st_size for file in files),
                "changed_at": max((file.st_mtime for file in files), default=path.stat().st_mtime),
                "done": states.get("done", 0),
                "failed": states.get("failed", 0),
                "cut_short": states.get(_CUT_SHORT, 0),
                "points": len(planned) or None,
                "end": manifest.get("end"),
                "archived": _is_archived(path),
            }
        )
    return sorted(out, key=lambda folder: -folder["changed_at"])


def recordings(folder: Path) -> list[dict[str, Any]]:
    """Return what a folder holds, in the order it was made: set point, quality, and why a file is of no use."""
    found = RecordingFolder.open(folder)
    root = folder.resolve()
    here = [recording for recording in found.recordings if recording.path.resolve().is_relative_to(root)]
    out = [recording.path.name for recording in found.recordings if recording not in here]
    return [
        *(
            {
                "id": recording.recording_id,
                "file": recording.path.name,
                "kind": recording.kind,
                "started_at": recording.started_at.isoformat(),
                "duration_s": recording.size / recording.sample_rate,
                "complete": recording.complete,
                "accepted": recording.accepted,
                "take": recording.take,
                "load_torque": _number(recording.setpoint.load_torque),
                "velocity": _number(recording.setpoint.velocity),
                "temperature": _number(recording.setpoint.temperature),
                "why": None,
            }
            for recording in here
        ),
        *({"id": None, "file": rejected.file.name, "why": rejected.why} for rejected in found.rejected),
        *({"id": None, "file": name, "why": "a link that leads out of the folder"} for name in out),
    ]


def revolution(path: Path) -> dict[str, Any]:
    """Return transmission error and order spectrum of a recording's steady motion, with its mean conditions.

    Raises
    ------
    RecordingError
        If it has no full revolution.
    """
    from bench.campaigns.picture import order_amplitudes, transmission_error
    from bench.service.process.revolution import HIGHEST_ORDER

    recording = Recording.open(path)
    error = transmission_error(recording)
    steady = recording.longest_steady()
    assert steady is not None  # it has a transmission error
    names = [name for name in ("load_torque", "motor_velocity", "motor_torque", "temperature") if name in recording]
    values = recording.read_si(names, steady.start, steady.stop)
    ratio = recording.gearbox.ratio or 1.0
    means = {name: float(np.mean(rows)) for name, rows in values.items()}
    error = error - error.mean()
    return {
        "amplitude": short(order_amplitudes(error)[1 : HIGHEST_ORDER + 1]),
        "curve": short(error.reshape(512, -1).mean(axis=1)),
        "rms": float(np.sqrt(np.mean(error**2))),
        "torque": means.get("load_torque"),
        "motor_torque": means.get("motor_torque"),
        "velocity": means["motor_velocity"] / ratio if "motor_velocity" in means else None,
        "temperature": means.get("temperature"),
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _is_archived(folder: Path) -> bool:
    """Whether somebody put the folder aside."""
    acts = [note.kind for note in read_notes(folder) if not note.file and note.kind in ("archive", "restore")]
    return bool(acts) and acts[-1] == "archive"


def _sizes(folder: Path) -> list[os.stat_result]:
    """What is said of the recordings of a folder by their directory entries; links are none."""
    found = []
    for entry in folder.iterdir():
        if entry.suffix != ".h5" or entry.is_symlink():
            continue
        try:
            found.append(entry.stat())
        except OSError:
            # taken away between listing and looking
            continue
    return found


def _states(folder: Path) -> Counter[str]:
    """How many points are in each state by the journal, which knows while a run still goes on.

    A point is done if one of its takes is; else it is what its last take is. One that was stopped before its end, by
    the operator or by a limit, is cut short: what it shows was not judged.
    """
    journal = folder / "journal.sqlite"
    if not journal.exists():
        return Counter()
    try:
        with closing(sqlite3.connect(f"{journal.absolute().as_uri()}?mode=ro", uri=True)) as database:
            takes = database.execute(
                "SELECT point_id, CASE WHEN status = 'failed' AND json_extract(content, '$.complete') = 0"
                " THEN ? ELSE status END FROM takes WHERE recording_id NOT LIKE 'heating-%' ORDER BY take",
                (_CUT_SHORT,),
            ).fetchall()
    except sqlite3.Error:
        # a journal that cannot be read counts nothing; the next run says what is wrong with it
        return Counter()
    points: dict[str, str] = {}
    for point, state in takes:
        if points.get(point) != "done":
            points[point] = state
    return Counter(points.values())


def _manifest(folder: Path) -> dict[str, Any]:
    try:
        manifest = json.loads((folder / "campaign.json").read_text("utf-8"))
    except (OSError, ValueError):
        return {}
    return manifest if isinstance(manifest, dict) else {}
