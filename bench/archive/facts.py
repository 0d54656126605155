"""What the index keeps of a recording: read from its own header, so that it can be made anew at any time."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from pathlib import Path

from bench.errors import RecordingError
from bench.recording import Recording, guarded

RESULTS = ("passed", "not passed", "cut short", "not judged", "no use")
"""What became of a recording: by its quality gate, by being cut short, or a file nobody can read."""
_AT_ONCE = 50


@dataclass(frozen=True, slots=True)
class Facts:
    """One recording. Torque N·m, velocity rad/s (load side), temperature °C, None where nothing was commanded.

    ``started_s`` is Unix time in s, None for a file that cannot be read; ``words`` holds what its events say, remarks
    of operators among them, or why it is of no use.
    """

    folder: str
    file: str
    recording_id: str
    campaign: str
    kind: str
    started_s: float | None
    duration_s: float
    gearbox: str
    bench: str
    source: str
    load_torque: float | None
    velocity: float | None
    temperature: float | None
    result: str
    words: str


def facts_of(folder: Path, names: list[str]) -> list[Facts]:
    """Read the headers of recordings of a folder in a child process; a file that cannot be used gives the reason.

    A damaged file can end the process that reads it: then each of its neighbours is read alone.
    """
    found: list[Facts] = []
    for first in range(0, len(names), _AT_ONCE):
        some = names[first : first + _AT_ONCE]
        try:
            found += guarded.call(folder, _facts, folder, some)
        except RecordingError:
            found += [_facts_of_file(folder, name) for name in some]
    return found


def _facts_of_file(folder: Path, name: str) -> Facts:
    try:
        return guarded.call(folder / name, _facts, folder, [name])[0]
    except RecordingError as error:
        return _no_use(folder, name, error)


def _facts(folder: Path, names: list[str]) -> list[Facts]:
    out = []
    for name in names:
        try:
            out.append(_facts_of_recording(folder, Recording.open(folder / name)))
        except RecordingError as error:
            out.append(_no_use(folder, name, error))
    return out


def _facts_of_recording(folder: Path, recording: Recording) -> Facts:
    setpoint = recording.setpoint
    return Facts(
        folder.name,
        recording.path.name,
        recording.recording_id,
        recording.campaign_id,
        recording.kind,
        recording.started_at.timestamp(),
        recording.size / recording.sample_rate,
        recording.gearbox_serial or "",
        _bench(recording.config or ""),
        recording.source,
        _number(setpoint.load_torque),
        _number(setpoint.velocity),
        _number(setpoint.temperature),
        _result(recording),
        "\n".join((*(event.text for event in recording.events), *recording.problems)),
    )


def _result(recording: Recording) -> str:
    if not recording.complete:
        return "cut short"
    return {True: "passed", False: "not passed", None: "not judged"}[recording.accepted]


def _no_use(folder: Path, name: str, error: RecordingError) -> Facts:
    why = str(error)
    return Facts(folder.name, name, name, folder.name, "", None, 0.0, "", "", "", None, None, None, "no use", why)


@lru_cache(maxsize=64)
def _bench(config: str) -> str:
    """Name of the bench, by the bench file a recording carries; empty where it carries none."""
    try:
        name = tomllib.loads(config).get("name")
    except tomllib.TOMLDecodeError:
        return ""
    return name if isinstance(name, str) else ""


def _number(value: float) -> float | None:
    return float(value) if isfinite(value) else None
