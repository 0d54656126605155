"""Few recordings, cut into contiguous blocks with a gap between them, so that some can be held out.

Held out is by recording wherever there are recordings enough. A folder of one or two long files has none to spare;
its blocks take their place, and the report says so. The gap is longer than the smoothing of rates, so that no sample
tells about two blocks. What turns is cut by its revolutions, so that every block shows what comes once in each; only
where that would leave too few blocks is it cut by time, and the report says what cannot be seen then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.recordings.prepared import Prepared
from bench.recording import Recording
from bench.simulation.frame import FloatArray

BLOCKS = 14
LEAST_BLOCK_S = 1.0
GAP_S = 0.25
REVOLUTIONS = (2.0, 1.05)
"""of the output in a block: several where there are enough, else one, with what a gap and smoothing take of it"""
LEAST_REVOLUTIONS = 1.0
"""revolutions between the ends of what a recording ran through from which it turns, and does not only swing"""
ENOUGH = criteria.FEWEST_RECORDINGS * 4 // 3
"""blocks of which enough can be fitted when every fourth is held out"""
WELL_CUT_S = ENOUGH * (LEAST_BLOCK_S + GAP_S)
"""length of recordings that make enough blocks"""
STEPS_A_SECOND = 20.0
"""at which the way of a recording is taken: an encoder's noise adds up to little then"""


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
            measured={name: values.cut(rows, group) for name, values in prepared.measured.items()},
            ripple={name: values[rows] for name, values in prepared.ripple.items()},
            simulated={name: values[rows] for name, values in prepared.simulated.items()},
            swept=prepared.swept[rows],
            leaning=prepared.leaning[rows],
            angle=prepared.angle[rows.start * group : rows.stop * group],
            label=prepared.label[rows],
            corner=prepared.corner[rows],
        )


def pieces(recordings: Sequence[Recording], left: int) -> tuple[list[Piece], str]:
    """The recordings as they are, or in blocks where fewer than six are ``left`` to fit once some are held out; and a
    note that says which.

    Validation recordings stay whole where there are others to fit: they are held out as they are.
    """
    whole = [Piece(r, r.recording_id) for r in recordings]
    if left >= criteria.FEWEST_RECORDINGS:
        return whole, ""
    fitted = [r for r in recordings if r.kind != "validation"] or list(recordings)
    ways = {r.recording_id: way(r) for r in fitted}
    rotating = any(part[-1] > 0.0 for part in ways.values())
    by_time = [_cut(r, r in fitted) for r in recordings]
    cut = by_time
    for least in REVOLUTIONS if rotating else ():
        tried = [_cut(r, r in fitted, ways.get(r.recording_id), least) for r in recordings]
        if sum(len(part) for part, r in zip(tried, recordings, strict=True) if r in fitted) >= ENOUGH:
            cut = tried
            break
    out = [piece for part in cut for piece in part]
    if len(out) == len(whole):
        return whole, ""
    held = "the validation recordings, whole" if len(fitted) < len(recordings) else "every fourth block"
    blocks = [p for p in out if p.rows is not None]
    longest = max((p.rows[1] - p.rows[0]) / p.recording.sample_rate for p in blocks if p.rows is not None)
    note = (
        f"{counted(len(fitted))} to fit {'is' if len(fitted) == 1 else 'are'} too few to hold any out:"
        f" {counted(len({p.recording.recording_id for p in blocks}))} cut into {len(blocks)} contiguous"
        f" blocks of {longest:.1f} s at most, {GAP_S:g} s apart; held out: {held}"
    )
    if rotating and cut is by_time:
        total = sum(float(part[-1]) for part in ways.values())
        note += (
            f"; their {total:.1f} revolutions do not make {ENOUGH} blocks of one each, so what comes once a revolution"
            " cannot be found"
        )
    return out, note


def counted(number: int) -> str:
    """A number of recordings in words."""
    return f"{number} recording{'' if number == 1 else 's'}"


def way(recording: Recording) -> FloatArray:
    """Revolutions of the output run through up to each of evenly spread samples of a recording, from 0; nothing but
    zeros where it has no angle, swings within a revolution, or is of a linear axis.
    """
    nothing = np.zeros(2)
    ratio = recording.gearbox.ratio or 1.0
    name, scale = ("load_angle", 1.0) if "load_angle" in recording.specs else ("motor_angle", 1.0 / ratio)
    if name not in recording.specs or recording.specs[name].unit == "m" or recording.size < 2:
        return nothing
    count = max(2, min(recording.size, int(STEPS_A_SECOND * recording.size / recording.sample_rate)))
    angle = recording.si(name)[np.linspace(0, recording.size - 1, count).astype(int)] * scale / (2.0 * np.pi)
    if not np.isfinite(angle).all() or np.ptp(angle) < LEAST_REVOLUTIONS:
        return nothing
    return np.concatenate(([0.0], np.cumsum(np.abs(np.diff(angle)))))


def _cut(recording: Recording, fitted: bool, run: FloatArray | None = None, least: float = 0.0) -> list[Piece]:
    """Blocks of a recording, or it whole: of equal time, or of equal parts of its ``run`` (:func:`way`), ``least``
    revolutions each at the least.
    """
    number = min(BLOCKS, int(recording.size / recording.sample_rate / (LEAST_BLOCK_S + GAP_S)))
    rotates = run is not None and run[-1] > 0.0
    if run is not None and rotates:
        number = min(number, int(run[-1] / least))
    if not fitted or number < (2 if rotates else 3):
        return [Piece(recording, recording.recording_id)]
    edges = np.linspace(0, recording.size, number + 1).round().astype(int)
    if run is not None and rotates:
        at = np.interp(np.linspace(0.0, run[-1], number + 1)[1:-1], run, np.linspace(0, recording.size, run.size))
        edges[1:-1] = at.round().astype(int)
        apart = round((LEAST_BLOCK_S + GAP_S) * recording.sample_rate)
        kept = [0]
        for edge in edges[1:-1].tolist():
            if edge - kept[-1] >= apart and recording.size - edge >= apart:
                kept.append(edge)
        edges = np.array([*kept, recording.size])
        number = edges.size - 1
    half = round(0.5 * GAP_S * recording.sample_rate)
    out = []
    for k in range(number):
        start = int(edges[k]) + (half if k else 0)
        stop = int(edges[k + 1]) - (half if k + 1 < number else 0)
        out.append(Piece(recording, f"{recording.recording_id} [{k + 1}/{number}]", (start, stop)))
    return out
