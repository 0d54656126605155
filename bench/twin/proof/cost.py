"""What watching costs: processor time of the looks at a folder of recordings, beside the time they took to record."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from bench.errors import RecordingError
from bench.recording import RecordingFolder
from bench.twin.scale import CALIBRATION
from bench.twin.watch import Watch


def cost(model: Path, folder: Path) -> dict[str, Any]:
    """Look at all recordings of a folder as a twin does; ``share``: of one core at real time.

    ``first_s``: the look that calibrates, at as many recordings at once; ``longest_s``: of all others.
    Raises RecordingError where there are too few to test any.
    """
    recordings = sorted(RecordingFolder.open(folder).recordings, key=lambda r: r.started_at)
    watch, looks = Watch(model), []
    recorded = 0.0
    for recording in recordings:
        at = time.process_time()
        watch.add(recording)
        looks.append((time.process_time() - at, watch.tested))
        recorded += recording.size / recording.sample_rate
    if not watch.tested:
        raise RecordingError(f"{folder}: {watch.points} recordings at one point; more than {CALIBRATION} are needed")
    alone = [took for took, tested in looks if tested]
    return {
        "recordings": len(recordings),
        "sample_rate": recordings[0].sample_rate,
        "recorded_s": round(recorded, 1),
        "processor_s": round(sum(took for took, _ in looks), 2),
        "share": round(sum(took for took, _ in looks) / recorded, 5),
        "first_s": round(max(took for took, tested in looks if not tested), 2),
        "longest_s": round(max(alone), 2),
    }
