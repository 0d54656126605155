"""Which recordings of a folder belong together, and a sentence for each that is left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from bench.identification.samples.windows import Skipped
from bench.recording import Recording, RecordingFolder


def _majority(
    recordings: Sequence[Recording], values: Sequence[object], what: str
) -> tuple[list[Recording], list[Skipped]]:
    known = Counter(value for value in values if value is not None)
    if len(known) < 2:
        return list(recordings), []
    chosen = known.most_common(1)[0][0]
    kept, skipped = [], []
    for recording, value in zip(recordings, values, strict=True):
        if value is None or value == chosen:
            kept.append(recording)
        else:
            why = f"{recording.recording_id}: its {what} is {value}, most have {chosen}; they are not mixed."
            skipped.append(Skipped(recording.recording_id, why))
    return kept, skipped


def select(folder: RecordingFolder) -> tuple[list[Recording], list[Skipped]]:
    """Choose the recordings to identify from: accepted ones of one gearbox ratio and one encoder zero."""
    skipped = [Skipped(rejected.file.name, rejected.why) for rejected in folder.rejected]
    recordings = []
    for recording in folder.recordings:
        if recording.accepted is False:
            why = f"{recording.recording_id}: the quality gate did not accept it; it is not used."
            skipped.append(Skipped(recording.recording_id, why))
        else:
            recordings.append(recording)
    recordings, more = _majority(recordings, [r.gearbox.ratio for r in recordings], "gearbox ratio")
    skipped += more
    recordings, more = _majority(recordings, [r.zero_id for r in recordings], "encoder zero")
    return recordings, skipped + more
