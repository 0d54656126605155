"""``campaign.json``: written whole or not at all, and rebuilt from the recordings where it is lost."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bench.errors import RecordingError
from bench.recording.folder import MANIFEST_NAME, RecordingFolder
from bench.recording.reader import Recording
from bench.whole import write_whole


def entry(recording: Recording) -> dict[str, Any]:
    """Give the manifest's entry of a recording, from the file alone; values that were not commanded are null."""
    setpoint = recording.setpoint
    passed = recording.complete and recording.accepted is not False
    return {
        "recording_id": recording.recording_id,
        "file": recording.path.name,
        "kind": recording.kind,
        "setpoint": {
            "load_torque": _number(setpoint.load_torque),
            "velocity": _number(setpoint.velocity),
            "temperature": _number(setpoint.temperature),
        },
        "status": "done" if passed else "failed",
        "quality": recording.quality,
    }


def _number(value: float) -> float | None:
    return None if math.isnan(value) else value


def rebuild(folder: str | Path) -> dict[str, Any]:
    """Build the manifest of a folder from its recordings, keeping plan and pending points of a manifest that is there.

    Raises
    ------
    RecordingError
        There is no such folder, or no usable recording in it.
    """
    contents = RecordingFolder.open(folder)
    if not contents.recordings:
        raise RecordingError(f"{contents.path}: holds no usable recording, a manifest cannot be rebuilt from it.")
    first = contents.recordings[0]
    manifest: dict[str, Any] = {
        "campaign_id": first.campaign_id,
        "created_at": first.started_at.isoformat(),
        "bench": None,
        "plan": None,
        **(contents.manifest or {}),
    }
    entries = [entry(recording) for recording in contents.recordings]
    taken = {item["recording_id"] for item in entries}
    listed = manifest.get("recordings")
    waiting = [
        item
        for item in (listed if isinstance(listed, list) else [])
        if isinstance(item, dict) and item.get("recording_id") not in taken and item.get("status") != "done"
    ]
    return {**manifest, "recordings": entries + waiting, "rebuilt_at": datetime.now(UTC).isoformat()}


def write_manifest(folder: str | Path, manifest: Mapping[str, Any]) -> Path:
    """Write ``campaign.json`` so that after a power cut either the old or the new one is there, whole."""
    path = Path(folder) / MANIFEST_NAME
    write_whole(path, json.dumps(manifest, indent=1, allow_nan=False) + "\n")
    return path
