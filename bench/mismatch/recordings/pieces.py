"""Few recordings, cut into contiguous blocks with a gap between them, so that some can be held out.

Held out is by recording wherever there are recordings enough. A folder of one or two long files has none to spare;
its blocks take their place, and the report says so. The gap is longer than the smoothing of rates, so that no sample
tells about two blocks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.recordings.prepared import Prepared
from bench.recording import Recording

BLOCKS = 14
LEAST_BLOCK_S = 1.0
GAP_S = 0.25


@dataclass(frozen=True, slots=True)
class Piece:
    """A recording or a block of one: ``rows`` None for the whole, else first and last row + 1."""

    recording: Recording
    name: str
    rows: tuple[int, int] | None = None

    def cut(self, prepared: Prepared, index: int) -> Prepared:
        """The piece of its recording, prepared; ``index`` is its number among all pieces."""
        group = prepared.thinning.group
        first, last = (0, prepared.frame.size * group) if self.rows is None else self.rows
        rows = slice(first // group, last // group)
        frame = prepared.frame.take(rows)
        step = frame.step.copy()
        step[0] = 0.0
        frame = replace(frame, recording=np.full(frame.size, index, dtype=np.int64), step=step)
        return replace(
            prepared,
            frame=frame,
            measured={name: own.cut(rows, group) for name, own in prepared.measured.items()},
            ripple={name: own[rows] for name, own in prepared.ripple.items()},
            simulated={name: own[rows] for name, own in prepared.simulated.items()},
            swept=prepared.swept[rows],
            leaning=prepared.leaning[rows],
            angle=prepared.angle[rows.start * group : rows.stop * group],
            label=prepared.label[rows],
            corner=prepared.corner[rows],
        )


def pieces(recordings: Sequence[Recording]) -> tuple[list[Piece], str]:
    """The recordings as they are, or in blocks where they are fewer than six; and a note that says which.

    Validation recordings stay whole where there are others to fit: they are held out as they are.
    """
    whole = [Piece(r, r.recording_id) for r in recordings]
    fitted = [r for r in recordings if r.kind != "validation"] or list(recordings)
    if len(fitted) >= criteria.FEWEST_RECORDINGS:
        return whole, ""
    out: list[Piece] = []
    longest = 0.0
    for recording in recordings:
        number = min(BLOCKS, int(recording.size / recording.sample_rate / (LEAST_BLOCK_S + GAP_S)))
        if recording not in fitted or number < 3:
            out.append(Piece(recording, recording.recording_id))
            continue
        edges = np.linspace(0, recording.size, number + 1).round().astype(int)
        half = round(0.5 * GAP_S * recording.sample_rate)
        longest = max(longest, float(edges[1]) / recording.sample_rate)
        for k in range(number):
            start = int(edges[k]) + (half if k else 0)
            stop = int(edges[k + 1]) - (half if k + 1 < number else 0)
            out.append(Piece(recording, f"{recording.recording_id} [{k + 1}/{number}]", (start, stop)))
    if len(out) == len(whole):
        return whole, ""
    held = "the validation recordings, whole" if len(fitted) < len(recordings) else "every fourth block"
    blocks = sum(piece.rows is not None for piece in out)
    return out, (
        f"{len(fitted)} recordings to fit are too few to hold any out: cut into {blocks} contiguous blocks of"
        f" {longest:.1f} s at most, {GAP_S:g} s apart; held out: {held}"
    )
