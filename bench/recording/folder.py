"""A campaign: a folder of recordings beside a ``campaign.json``."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.errors import RecordingError
from bench.recording.header import PART_SUFFIX
from bench.recording.reader import Recording

MANIFEST_NAME = "campaign.json"
_SUFFIXES = (".h5", ".hdf5")


@dataclass(frozen=True, slots=True)
class Rejected:
    """A file of the folder that cannot be used, and why, in one sentence."""

    file: Path
    why: str


@dataclass(frozen=True, slots=True)
class RecordingFolder:
    """The usable recordings of a folder in the order they were started, the others with the reason."""

    path: Path
    recordings: tuple[Recording, ...]
    rejected: tuple[Rejected, ...]
    manifest: dict[str, Any] | None

    @classmethod
    def open(cls, path: str | Path) -> RecordingFolder:
        """Read the headers of all recordings in a folder.

        Raises
        ------
        RecordingError
            There is no such folder. Files in it that are no use are listed in ``rejected`` instead.
        """
        path = Path(path)
        if not path.is_dir():
            raise RecordingError(f"{path}: there is no such folder.")
        recordings: list[Recording] = []
        rejected: list[Rejected] = []
        for file in sorted(path.iterdir()):
            if file.name.endswith(PART_SUFFIX):
                rejected.append(Rejected(file, f"{file}: was never finished; 'bench repair' makes a recording of it."))
            elif file.suffix in _SUFFIXES:
                try:
                    recordings.append(Recording.open(file))
                except RecordingError as error:
                    rejected.append(Rejected(file, str(error)))
        manifest = None
        manifest_path = path / MANIFEST_NAME
        if manifest_path.exists():
            try:
                manifest = read_manifest(manifest_path)
            except RecordingError as error:
                rejected.append(Rejected(manifest_path, str(error)))
        recordings.sort(key=lambda recording: (recording.started_at, recording.recording_id))
        return cls(path, tuple(recordings), tuple(rejected), manifest)


def recording_files(path: str | Path) -> list[Path]:
    """Give the finished recordings of a folder, sorted by name; a file is given back as it is.

    Raises
    ------
    RecordingError
        There is no such file or folder, or the folder holds no recording.
    """
    path = Path(path)
    if not path.is_dir():
        if not path.exists():
            raise RecordingError(f"{path}: there is no such file or folder.")
        return [path]
    files = sorted(file for file in path.iterdir() if file.suffix in _SUFFIXES)
    if not files:
        raise RecordingError(f"{path}: holds no recording ({' or '.join(_SUFFIXES)}).")
    return files


def read_manifest(path: Path) -> dict[str, Any]:
    """Read a ``campaign.json``; a :class:`RecordingError` where it is not a JSON object."""
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RecordingError(
            f"{path}: not readable as JSON ({error}); it can be rebuilt from the recordings."
        ) from error
    if not isinstance(manifest, dict):
        raise RecordingError(f"{path}: holds a JSON {type(manifest).__name__}, it should hold an object.")
    return manifest
