"""Making a valid recording of a ``.part`` file that a kill or a power cut left behind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import h5py
import numpy as np

from bench.errors import RecordingError
from bench.recording._header_reader import KNOWN_ROOT_ATTRIBUTES
from bench.recording._ownership import refuse_if_written
from bench.recording.header import PART_SUFFIX, RecordingHeader, Segment
from bench.recording.reader import HDF5_ERRORS, Recording, hdf5_reason, opened
from bench.recording.storage import completed, first_missing_row
from bench.recording.writer import FAST_CHUNK_ROWS, RecordingWriter

_BLOCK_ROWS = 16 * FAST_CHUNK_ROWS
_REPAIR_SUFFIX = ".repair" + PART_SUFFIX


@dataclass(frozen=True, slots=True)
class Repair:
    """What came of one file: the recording written, its rows, and how many rows had to be given up."""

    source: Path
    path: Path
    rows: int
    rows_lost: int
    complete: bool


def repair(source: str | Path, target: str | Path | None = None, *, keep: bool = False) -> Repair:
    """Write the valid prefix of ``source`` as a recording that was cut short, then remove ``source``.

    The prefix ends before the first row that any channel lacks, that cannot be read, or at which time does not
    increase. A file that had been finished, all but its name, stays complete.

    Parameters
    ----------
    target : by default the name without ``.part``; required for a file that is not a ``.part``.
    keep : leave ``source`` where it is.

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
    with completed(source) as (readable, file_size):
        try:
            result = _restore(Recording.open(readable), source, target, file_size)
        except RecordingError as error:
            raise RecordingError(str(error).replace(str(readable), str(source))) from error
        except HDF5_ERRORS as error:
            raise RecordingError(f"{source}: the HDF5 structure is damaged ({hdf5_reason(error)}).") from error
    if not keep:
        source.unlink()
    return result


def _restore(recording: Recording, source: Path, target: Path, file_size: int | None) -> Repair:
    rows = _valid_rows(recording, file_size)
    if not rows:
        raise RecordingError(f"{source}: no row was saved before it was cut short, there is nothing to repair.")
    complete = recording.complete and rows == recording.size
    part = target.with_name(target.name + _REPAIR_SUFFIX)
    specs = list(recording.specs.values())
    with RecordingWriter(target, _header(recording), specs, chunk_rows=FAST_CHUNK_ROWS, part=part) as writer:
        _copy_rows(recording, rows, writer)
        writer.restore(_segments(recording, rows), recording.events)
        if not complete:
            time = float(recording.si("time", rows - 1, rows)[0])
            writer.event(time, "warning", f"cut short after {rows} rows; valid prefix restored by repair")
        writer.close(accepted=recording.accepted, quality=recording.quality or None, complete=complete)
    return Repair(source, target, rows, recording.size - rows, complete)


def _header(recording: Recording) -> RecordingHeader:
    with opened(recording.path) as file:
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
        config=recording.config,
        software=recording.software,
        attributes=further,
    )


def _segments(recording: Recording, rows: int) -> Sequence[Segment]:
    return [replace(s, stop=min(s.stop, rows)) for s in recording.segments if s.start < rows]


def _valid_rows(recording: Recording, file_size: int | None) -> int:
    """Count the rows before the first that is not stored, not readable, or not later than the one before."""
    rows = recording.size
    with opened(recording.path) as file:
        for name in recording.channels:
            dataset = file["channels"][name]
            missing = first_missing_row(dataset, file_size)
            rows = min(rows, dataset.shape[0] if missing is None else missing)
            rows = _readable_rows(dataset, rows)
    last = -np.inf
    for start in range(0, rows, _BLOCK_ROWS):
        time = recording.si("time", start, min(start + _BLOCK_ROWS, rows))
        wrong = np.flatnonzero(~(np.diff(time, prepend=last) > 0))
        if wrong.size:
            return start + int(wrong[0])
        last = time[-1]
    return rows


def _readable_rows(dataset: h5py.Dataset, rows: int) -> int:
    """Count the rows of the chunks that can be read, at most ``rows``."""
    step = dataset.chunks[0] if dataset.chunks else rows
    try:
        dataset[:rows]
    except (OSError, RuntimeError):
        for start in range(0, rows, max(step, 1)):
            try:
                dataset[start : min(start + step, rows)]
            except (OSError, RuntimeError):
                return start
    return rows


def _copy_rows(recording: Recording, rows: int, writer: RecordingWriter) -> None:
    for start in range(0, rows, _BLOCK_ROWS):
        writer.append(recording.read_raw(recording.channels, start, min(start + _BLOCK_ROWS, rows)))
