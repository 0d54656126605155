"""A campaign in which the model stopped holding, as two folders: what was recorded before, and what since."""

from __future__ import annotations

import json
from pathlib import Path

from bench.errors import ConfigurationError
from bench.recording import RecordingFolder
from bench.twin.process import RESULT


def since_of(folder: Path) -> str:
    """Id of the recording since which the twin says that the model no longer holds.

    Raises
    ------
    ConfigurationError
        The folder was not watched, or the model held.
    """
    path = folder / RESULT
    if not path.is_file():
        raise ConfigurationError(f"{folder} was not watched (it has no {RESULT}); name a recording with --since")
    try:
        alarm = json.loads(path.read_text("utf-8"))["no_longer_holds"]
        return "" if alarm is None else str(alarm["since"])
    except (ValueError, KeyError, TypeError) as error:
        raise ConfigurationError(
            f"{path} is not as a twin leaves it ({error}); name a recording with --since"
        ) from error


def halves(folder: Path, place: Path, since: str = "") -> tuple[Path, Path]:
    """Link the recordings of a folder into ``place/before`` and ``place/since``, split at the recording ``since``.

    Without one it is that which the twin named. Raises ConfigurationError where there is none, or nothing before it.
    """
    first_since = since or since_of(folder)
    if not first_since:
        raise ConfigurationError(f"the twin saw no change in {folder}; name a recording with --since")
    recordings = sorted(RecordingFolder.open(folder).recordings, key=lambda r: r.started_at)
    ids = [r.recording_id for r in recordings]
    if first_since not in ids[1:]:
        where = "is the first of" if first_since in ids else "is no recording of"
        raise ConfigurationError(f"{first_since} {where} {folder}: there is nothing to compare before it and since")
    parts = place / "before", place / "since"
    for part in parts:
        part.mkdir(parents=True)
    for number, recording in enumerate(recordings):
        part = parts[number >= ids.index(first_since)]
        (part / recording.path.name).symlink_to(recording.path.resolve())
    return parts
