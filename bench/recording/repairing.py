"""Making a valid recording of a ``.part`` file that a kill or a power cut left behind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench.errors import RecordingError
from bench.recording import guarded
from bench.recording._header_reader import KNOWN_ROOT_ATTRIBUTES
from bench.recording.file.ownership import refuse_if_written
from bench.recording.file.storage import completed_copy, first_missing_row
from bench.recording.header import PART_SUFFIX, RecordingHeader, Segment
from bench.recording.reader import HDF5_ERRORS, Recording, hdf5_reason, open_file
from bench.recording.validation import validate
from bench.recording.writing.writer import FAST_CHUNK_ROWS, RecordingWriter

_BLOCK_ROWS = 16 * FAST_CHUNK_ROWS
_REPAIR_SUFFIX = ".repair" + PART_SUFFIX
REPAIRED_SUFFIX = ".repaired"
"""A ``.part`` of which a recording was made keeps all its bytes under this name."""


@dataclass(frozen=True, slots=True)
class Repair:
    """What came of one file: the recording written, its rows, how many had to be given up, and what is wrong still.

    ``source`` is where the unfinished file is now.
    """

    source: Path
    path: Path
    rows: int
    rows_lost: int
    complete: bool
    violations: tuple[str, ...] = ()

    @property
    def valid(self) -> bool:
        """Whether the recording meets the format."""
        return not self.violations


def repair(source: str | Path, target: str | Path | None = None, *, keep: bool = False) -> Repair:
    """Write the valid prefix of ``source`` as a recording that was cut short, and set ``source`` aside.

    The prefix ends before the first row that any channel lacks, that cannot be read, or at which time does not
    increase. A file that had been finished, all but its name, stays complete. ``source`` is never deleted or changed:
    it is called ``<name>.repaired`` once a valid recording has been made of it.

    Parameters
    ----------
    target : by default the name without ``.part``; required for a file that is not a ``.part``.
    keep : leave ``source`` its name.

    Raises
    ------
    RecordingError
        The file is beyond repair (its header cannot be read, or it has no row), a living process is still writing it,
        or ``target`` exists.
    """
    source = Path(source)
    if target is None:
        if not source.name.endswith(PART_SUFFIX):
            raise RecordingError(f"{source}: is not a {PART_SUFFIX} file; name the file the repaired one should go to.")
        target = source.with_name(source.name.removesuffix(PART_SUFFIX))
    target = Path(target)
    if target.exists():
        raise RecordingError(f"{source}: {target.name} is there already, it would be overwritten; move one of them.")
    if not source.is_file():
        raise RecordingError(f"{source}: there is no such file.")
    refuse_if_written(source)
    part = target.with_name(target.name + _REPAIR_SUFFIX)
    try:
        with completed_copy(source) as (readable, file_size):
            result = guarded.call(source, _repair, readable, source, target, file_size)
    except RecordingError:
        part.unlink(missing_ok=True)  # of a child that crashed
        raise
    # a channel that could not be read is missing in the result, which may be valid without it
    result = replace(result, violations=(*result.violations, *validate(target).violations))
    if keep or not result.valid:
        return result
    aside = free_name(source.with_name(source.name + REPAIRED_SUFFIX))
    source.rename(aside)
    return replace(result, source=aside)


def free_name(path: Path) -> Path:
    """Give a name that is not taken: ``path``, or ``path.2`` and so on."""
    number, free = 1, path
    while free.exists():
        number += 1
        free = path.with_name(f"{path.name}.{number}")
    return free


def _repair(readable: Path, source: Path, target: Path, file_size: int | None) -> Repair:
    """Do it; in a child."""
    try:
        return _restore(Recording.open(readable, prefix=True), source, target, file_size)
    except RecordingError as error:
        raise RecordingError(str(error).replace(str(readable), str(source))) from error
    except HDF5_ERRORS as error:
        raise RecordingError(f"{source}: the HDF5 structure is damaged ({hdf5_reason(error)}).") from error


def _restore(recording: Recording, source: Path, target: Path, file_size: int | None) -> Repair:
    claimed = _claimed_row_count(recording)
    rows = _valid_rows(recording, file_size)
    if not rows:
        raise RecordingError(f"{source}: no row was saved before it was cut short, there is nothing to repair.")
    complete = recording.complete and rows == claimed
    part = target.with_name(target.name + _REPAIR_SUFFIX)
    specs = list(recording.specs.values())
    with RecordingWriter(target, _header(recording), specs, chunk_rows=FAST_CHUNK_ROWS, part=part) as writer:
        _copy_rows(recording, rows, writer)
        writer.restore(_segments(recording, rows), recording.events)
        if not complete:
            time = float(recording.si("time", rows - 1, rows)[0])
            writer.event(time, "warning", f"cut short after {rows} rows; valid prefix restored by repair")
        writer.close(accepted=recording.accepted, quality=recording.quality or None, complete=complete)
    return Repair(source, target, rows, claimed - rows, complete, recording.problems)


def _header(recording: Recording) -> RecordingHeader:
    with open_file(recording.path) as file:
        further = {name: value for name, value in file.attrs.items() if name not in KNOWN_ROOT_ATTRIBUTES}
    return RecordingHeader(
        recording_id=recording.recording_id,
        campaign_id=recording.campaign_id,
        kind=recording.kind,
        started_at=recording.started_at,
        sample_rate=recording.sample_rate,
        source=recording.source,
        setpoint=recording.setpoint,
        gearbox=recording.gearbox,
        point_id=recording.point_id,
        take=recording.take,
        zero_id=recording.zero_id,
        gearbox_serial=recording.gearbox_serial,
        axis=recording.axis,
        config=recording.config,
        software=recording.software,
        attributes=further,
    )


def _segments(recording: Recording, rows: int) -> Sequence[Segment]:
    return [replace(s, stop=min(s.stop, rows)) for s in recording.segments if s.start < rows]


def _claimed_row_count(recording: Recording) -> int:
    """Count the rows that all channels say they have, stored or not."""
    with open_file(recording.path) as file:
        return min(int(file["channels"][name].shape[0]) for name in recording.channels)


def _valid_rows(recording: Recording, file_size: int | None) -> int:
    """Count the rows before the first that is not stored, not readable, or not later than the one before."""
    rows = recording.size
    with open_file(recording.path) as file:
        for name in recording.channels:
            dataset = file["channels"][name]
            missing = first_missing_row(dataset, file_size)
            rows = min(rows, dataset.shape[0] if missing is None else missing)
            rows = _readable_rows(recording, name, rows, dataset.chunks[0] if dataset.chunks else rows)
    last = -np.inf
    for start in range(0, rows, _BLOCK_ROWS):
        time = recording.si("time", start, min(start + _BLOCK_ROWS, rows))
        wrong = np.flatnonzero(~(np.diff(time, prepend=last) > 0))
        if wrong.size:
            return start + int(wrong[0])
        last = time[-1]
    return rows


def _readable_rows(recording: Recording, name: str, rows: int, step: int) -> int:
    """Count the rows of the chunks (of ``step`` rows) that can be read, at most ``rows``."""
    for start in range(0, rows, max(step, 1)):
        try:
            recording.raw(name, start, min(start + step, rows))
        except RecordingError:
            return start
    return rows


def _copy_rows(recording: Recording, rows: int, writer: RecordingWriter) -> None:
    for start in range(0, rows, _BLOCK_ROWS):
        writer.append(recording.read_raw(recording.channels, start, min(start + _BLOCK_ROWS, rows)))
