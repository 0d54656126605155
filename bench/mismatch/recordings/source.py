"""Where recordings come from: a folder, or several folders of one gearbox between two settings of the encoders."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from bench.errors import ConfigurationError
from bench.recording import Recording, RecordingFolder

Paths = Path | str | Sequence[Path]
_SAME: tuple[tuple[str, str, Callable[[Recording], str | None]], ...] = (
    ("gearbox", "gearbox_serial", lambda r: r.gearbox_serial),
    ("encoder zero", "zero_id", lambda r: r.zero_id),
)
"""what all folders have in common that are one data set: in words, as headers call it, as a recording has it"""

LONGEST_CAMPAIGN_S = 3.0 * 365.0 * 86400.0
"""to either side of the middle recording: a gearbox is not measured for longer, a clock that was not set is at 1970"""


def folders_of(paths: Paths) -> list[Path]:
    """The folders as a list."""
    return [Path(paths)] if isinstance(paths, str | Path) else [Path(p) for p in paths]


def gathered(paths: Paths) -> tuple[list[Recording], list[tuple[str, str]]]:
    """Recordings of all folders in the order in which they began; files that are no use, each with the reason.

    Raises
    ------
    ConfigurationError
        Two folders are of different gearboxes, or a referencing of the encoders lies between them: what depends on the
        angle would be at another place in each. Or one folder is named twice.
    RecordingError
        There is no such folder.
    """
    folders = folders_of(paths)
    twice = [f for k, f in enumerate(folders) if f.resolve() in [o.resolve() for o in folders[:k]]]
    if twice:
        raise ConfigurationError(f"{twice[0]} is named twice; a recording counts once")
    sources = [RecordingFolder.open(folder) for folder in folders]
    for words, key, of in _SAME:
        seen: dict[str, Path] = {}
        for folder, source in zip(folders, sources, strict=True):
            for value in sorted({v for r in source.recordings if (v := of(r)) is not None}):
                seen.setdefault(value, folder)
        if len(folders) > 1 and len(seen) > 1:
            (one, where), (other, there), *_ = seen.items()
            raise ConfigurationError(
                f"{where} has the {words} {one}, {there} has {other} ({key}): they are no one data set; "
                "compare them without --together"
            )
    rejected = [(str(r.file), r.why) for source in sources for r in source.rejected]
    recordings = [r for source in sources for r in source.recordings]
    return sorted(recordings, key=lambda r: (r.started_at, r.recording_id)), rejected


def of_one_campaign(recordings: Sequence[Recording]) -> list[Recording]:
    """Recordings, in order of time, without those that are years from the one in the middle."""
    ordered = sorted(recordings, key=lambda r: r.started_at)
    middle = ordered[len(ordered) // 2].started_at
    return [r for r in ordered if abs((r.started_at - middle).total_seconds()) <= LONGEST_CAMPAIGN_S]


def names_of(recordings: Sequence[Recording]) -> list[str]:
    """What each recording is called: its id, with its folder before it where two have the same id."""
    ids = [r.recording_id for r in recordings]
    twice = {name for name in ids if ids.count(name) > 1}
    return [f"{r.path.parent.name}/{r.recording_id}" if r.recording_id in twice else r.recording_id for r in recordings]
