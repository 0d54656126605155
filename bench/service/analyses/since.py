"""A mismatch report compared with the last one of the same gearbox: findings that are new, and those that are gone."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.errors import RecordingError
from bench.recording import Recording


@dataclass(frozen=True, slots=True)
class Report:
    """An analysis that made a report: where it lies, whose recordings it is about, when it was asked for (ISO 8601)."""

    folder: Path
    recordings: Path
    asked_at: str


def since_last(this: Report, others: Sequence[Report]) -> list[str]:
    """Return lines that compare a report with the last one before it of the same gearbox; empty without one."""
    gearbox = _gearbox(this.recordings)
    now = _read(this.folder)
    if gearbox is None or now is None:
        return []
    for other in sorted(others, key=lambda one: one.asked_at, reverse=True):
        if other.asked_at >= this.asked_at or _gearbox(other.recordings) != gearbox:
            continue
        before = _read(other.folder)
        if before is not None:
            return _lines(f"{other.recordings.name} ({other.asked_at[:10]}), the same gearbox {gearbox}", before, now)
    return []


def _lines(which: str, before: dict[str, Any], now: dict[str, Any]) -> list[str]:
    old, new = _findings(before), _findings(now)
    came, went = [new[key] for key in new if key not in old], [old[key] for key in old if key not in new]
    stayed = len(new) - len(came)
    lines = [
        f"Compared with the report on {which}: {stayed} of {len(old)} findings are found again.",
        f"Found anew: {'; '.join(came) or 'nothing'}. Found no more: {'; '.join(went) or 'nothing'}.",
    ]
    errors = [(name, _error(before, name), _error(now, name)) for name in sorted(_channels(now) & _channels(before))]
    parts = [
        f"{name.replace('_', ' ')} {a:.3g} → {b:.3g} {unit}"
        for name, (a, unit), (b, _) in errors
        if a is not None and b
    ]
    if parts:
        lines.append(f"Error of the simulation with what was found: {'; '.join(parts)}.")
    return lines


def _findings(report: dict[str, Any]) -> dict[tuple[str, str], str]:
    """Text of each finding by effect and channel; what is not known is distinguished by where it acts."""
    found = {}
    for finding in report["findings"]:
        effect = str(finding["effect"])
        where = str(finding["location"]["text"]) if effect == "unknown" else ""
        found[effect + where, str(finding["channel"])] = (
            f"{finding['name']} ({finding['status']}, {str(finding['channel']).replace('_', ' ')})"
        )
    return found


def _channels(report: dict[str, Any]) -> set[str]:
    return {str(channel["channel"]) for channel in report["channels"]}


def _error(report: dict[str, Any], name: str) -> tuple[float | None, str]:
    channel = next(one for one in report["channels"] if one["channel"] == name)
    return channel["held_out_rmse_after"], str(channel["unit"]).replace("*", "·")


def _read(folder: Path) -> dict[str, Any] | None:
    """The report as data; None where the analysis left none, or one that is of no use."""
    try:
        report = json.loads((folder / "report.json").read_text("utf-8"))
    except (OSError, ValueError):
        return None
    return report if isinstance(report, dict) and report.get("format") == "bench-mismatch-report" else None


def _gearbox(recordings: Path) -> str | None:
    """Serial number in the first recording of a folder that can be read; None where there is none."""
    for path in sorted(recordings.glob("*.h5")):
        try:
            return Recording.open(path).gearbox_serial
        except RecordingError:
            continue
    return None
