"""Before a change and since: both parts of a folder identified, and what differs beyond its uncertainty."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.identification import Options, identify_folder, to_simulation
from bench.identification.comparison.compare import Change, compare
from bench.recording import RecordingFolder
from bench.twin.halves import halves
from bench.typeset import engineering

PARTS = ("before", "since")
MOST_NAMED = 3
"""changes that the sentence names"""
Progress = Callable[[str, float], None]


@dataclass(frozen=True, slots=True)
class BeforeSince:
    """What changed in ``folder`` with the recording ``since``; ``recordings`` of each part; ``changes`` as compared."""

    folder: Path
    since: str
    recordings: tuple[int, int]
    changes: tuple[Change, ...]

    @property
    def changed(self) -> tuple[Change, ...]:
        """Those beyond their uncertainty."""
        return tuple(c for c in self.changes if c.changed)

    @property
    def sentence(self) -> str:
        """The result for a person."""
        parts = f"{self.recordings[0]} recordings before {self.since} and {self.recordings[1]} since"
        judged = sum(math.isfinite(c.p_value) for c in self.changes)
        if judged == 0:
            return f"Nothing could be compared: {parts} do not determine any quantity of both."
        if not self.changed:
            return f"None of {judged} quantities changed beyond its uncertainty between {parts}."
        named = "; ".join(_words(c) for c in self.changed[:MOST_NAMED])
        more = len(self.changed) - MOST_NAMED
        others = f"; and {more} more" if more > 0 else ""
        return f"{len(self.changed)} of {judged} quantities changed between {parts}: {named}{others}."


def before_and_since(
    folder: Path, since: str = "", report_progress: Progress = lambda _what, _share: None
) -> BeforeSince:
    """Identify what was recorded before ``since`` (without one: the recording that the twin named) and what since.

    Raises ConfigurationError where nothing can be split, RecordingError where a recording cannot be read.
    """
    with TemporaryDirectory() as place:
        parts = halves(folder, Path(place) / folder.resolve().name, since)
        models, counts, first = [], [], ""
        for number, (name, part) in enumerate(zip(PARTS, parts, strict=True)):
            recordings = RecordingFolder.open(part).recordings
            counts.append(len(recordings))
            first = min(recordings, key=lambda r: r.started_at).recording_id
            report_progress(f"identifying {len(recordings)} recordings {name} the change", 0.1 + 0.4 * number)
            models.append(to_simulation(identify_folder(part, Options(jobs=1))))
        return BeforeSince(folder, first, (counts[0], counts[1]), tuple(compare(models[0], models[1])))


def not_judged(changes: Sequence[Change]) -> str:
    """A sentence on what no uncertainty or no common conditions were there for; empty where there is nothing."""
    names = [c.what for c in changes if not math.isfinite(c.p_value)]
    if not names:
        return ""
    return (
        "Not judged, for want of a standard deviation or of torques, speeds or temperatures that both have measured: "
        f"{', '.join(names)}"
    )


def cells(change: Change) -> tuple[str, str, str, str]:
    """Before, after, standard deviation of the difference, and unit, as people read them."""
    before, std, unit = engineering(change.before, change.std, change.unit)
    # the unit may go with the size of a value: one unit for a row
    after, _, other = engineering(change.after, change.std, change.unit)
    if other == unit:
        return before, after, std, unit
    return f"{change.before:.4g}", f"{change.after:.4g}", f"{change.std:.2g}", change.unit


def _words(change: Change) -> str:
    before, after, _, unit = cells(change)
    return f"{change.what} {before} → {after} {unit}"
