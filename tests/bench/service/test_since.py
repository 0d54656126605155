"""A mismatch report beside the last one of the same gearbox."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from bench.service.analyses.since import Report, since_last
from tests.bench.recording.builders import write


def finding(effect: str, channel: str = "transmission_error", where: str = "everywhere") -> dict[str, Any]:
    location = {"text": where}
    return {"effect": effect, "name": f"{effect} in words", "status": "named", "channel": channel, "location": location}


def report(root: Path, name: str, asked_at: str, serial: str, error: float, *findings: dict[str, Any]) -> Report:
    recordings, folder = root / name, root / "analyses" / name
    recordings.mkdir(parents=True)
    folder.mkdir(parents=True)
    write(recordings / "r001.h5", rows=60, gearbox_serial=serial)
    channel = {"channel": "motor_torque", "unit": "N*m", "held_out_rmse_after": error}
    content = {"format": "bench-mismatch-report", "findings": list(findings), "channels": [channel]}
    (folder / "report.json").write_text(json.dumps(content), "utf-8")
    return Report(folder, recordings, asked_at)


def test_it_is_compared_with_the_last_one_of_the_same_gearbox(tmp_path: Path) -> None:
    spring = report(tmp_path, "spring", "2026-03-01T09:00:00", "RH-1", 0.1, finding("te.drift"), finding("te.hump"))
    other = report(tmp_path, "other", "2026-10-01T09:00:00", "RH-2", 0.1, finding("te.knock"))
    oldest = report(tmp_path, "oldest", "2025-03-01T09:00:00", "RH-1", 0.1)
    this = report(
        tmp_path,
        "autumn",
        "2026-11-01T09:00:00",
        "RH-1",
        0.2,
        finding("te.drift"),
        finding("unknown", where="at 3 rad"),
    )
    later = report(tmp_path, "later", "2026-12-01T09:00:00", "RH-1", 0.3, finding("te.knock"))
    lines = since_last(this, [spring, other, oldest, this, later])
    assert lines == [
        "Compared with the report on spring (2026-03-01), the same gearbox RH-1: 1 of 2 findings are found again.",
        "Found anew: unknown in words (named, transmission error)."
        " Found no more: te.hump in words (named, transmission error).",
        "Error of the simulation with what was found: motor torque 0.1 → 0.2 N·m.",
    ]


def test_without_an_earlier_one_there_is_nothing_to_compare(tmp_path: Path) -> None:
    this = report(tmp_path, "this", "2026-11-01T09:00:00", "RH-1", 0.2)
    other = report(tmp_path, "other", "2026-10-01T09:00:00", "RH-2", 0.1)
    broken = report(tmp_path, "broken", "2026-10-02T09:00:00", "RH-1", 0.1)
    (broken.folder / "report.json").write_text("{", "utf-8")
    assert since_last(this, [other, broken, this]) == []
