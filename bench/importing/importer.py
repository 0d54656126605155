"""Files of other tools become recordings, as a mapping file says."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import ConfigurationError, RecordingError
from bench.importing.cutting import LEAST_REVOLUTIONS, Cut, cut, travelled
from bench.importing.files import Files, found, ids, in_folder, refuse_shared
from bench.importing.mapping import Mapping, RecordingMapping, SegmentMapping, as_utc, load_mapping
from bench.importing.motor_angle import FROM_OUTPUT, SPEED_FROM_OUTPUT, hardly_turns, lost_zero
from bench.importing.output_torque import AT_OUTPUT, may_be_of_output
from bench.importing.plausible import gain_note, implausible, misspelt
from bench.importing.provenance import provenance, software
from bench.importing.steady import steady_stretches
from bench.importing.table import ChannelTable, read_table
from bench.recording.folder import Rejected
from bench.recording.header import Event, Gearbox, RecordingHeader, Segment, Setpoint
from bench.recording.missing import consequences
from bench.recording.one_shot import write_recording
from bench.recording.reader import Recording

_OF_FILE = "started_at is the modification time of the imported file"
_FOUND_STEADY = "stretches of steady speed, found from the angle as the mapping names no segments"


@dataclass(frozen=True, slots=True)
class Imported:
    """A recording made from ``source``; ``notes`` what was done to it, ``consequences`` what its missing channels
    rule out, ``warnings`` what cannot be (a wrong sign or scale), one sentence each.
    """

    source: Path
    recording: Recording
    consequences: tuple[str, ...]
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def import_recordings(
    mapping_path: str | Path,
    out: str | Path,
    data: str | Path | None = None,
    changes: dict[str, Any] | None = None,
) -> Iterator[Imported | Rejected]:
    """Import all files of a mapping, one after another, into the folder ``out``; a file that is no use stops no other.

    Parameters
    ----------
    data : folder in which the files are sought, also by the end of their names; by default the mapping file's own.
    changes : values by key (``gearbox.ratio``) that come before those of the file.

    Raises
    ------
    ConfigurationError
        The mapping file is wrong.
    """
    mapping_path, out = Path(mapping_path), Path(out)
    mapping, text = load_mapping(mapping_path, changes)
    folder = Path(data) if data is not None else mapping_path.parent
    recordings = mapping.recordings if data is None else in_folder(folder, mapping.recordings, f"{mapping_path}")
    entries = [(entry, found(folder, entry)) for entry in recordings]
    columns = [({**mapping.columns, **entry.channels}, files) for entry, files in entries]
    refuse_shared(((*file, channels) for channels, files in columns for file in files), f"{mapping_path}")
    out.mkdir(parents=True, exist_ok=True)
    mains = [file for _, files in entries for file, _ in files]
    for entry, files in entries:
        for (file, stars), name in zip(files, ids(files, entry), strict=True):
            try:
                opened = Files(file, mapping.csv.options(), stars, folder)
                targets, notes, warnings = _import_one(mapping, text, mapping_path, entry, opened, out / name, mains)
            except RecordingError as error:
                yield Rejected(file, str(error))
                continue
            for index, target in enumerate(targets):
                recording = Recording.open(target)
                first = index == 0
                if first:
                    told = ["load_angle"] if any(note.startswith(FROM_OUTPUT) for note in notes) else []
                    yield Imported(file, recording, consequences(recording, told), notes, warnings)
                else:
                    yield Imported(file, recording, ())


def _import_one(
    mapping: Mapping,
    text: str,
    mapping_path: Path,
    entry: RecordingMapping,
    files: Files,
    stem: Path,
    mains: list[Path],
) -> tuple[list[Path], tuple[str, ...], tuple[str, ...]]:
    """Write the recordings of one file of ``mains``; gives their paths, what was done to the data, and what of them
    cannot be.
    """
    columns = {**mapping.columns, **entry.channels}
    table = read_table(mapping, columns, files, f"{mapping_path}")
    ratio = mapping.gearbox.ratio
    lost = lost_zero(table.channels, columns, ratio) if len(set(mains)) > 1 else None
    side = may_be_of_output(columns, ratio)
    remarks = (lost, hardly_turns(table.channels, ratio), side, gain_note(table, ratio, columns))
    table.notes += [note for note in remarks if note is not None]
    segments = [
        _segment(segment, table, files.main)
        for segment in (entry.segments if entry.segments is not None else mapping.segments)
    ]
    whole = _bounds(entry, table, files.main)
    if entry.segments is None and not mapping.segments:
        segments = _steady(mapping, entry, table, whole)
    stretches = _stretches(mapping, entry, table, whole, files.main, len(mains))
    width = max(2, len(str(len(stretches))))
    targets = [
        stem.with_name(f"{stem.name}.h5" if len(stretches) == 1 else f"{stem.name}-{index:0{width}d}.h5")
        for index in range(1, len(stretches) + 1)
    ]
    for target in targets:
        if target.exists():
            raise RecordingError(
                f"{target}: is there already, an import does not overwrite recordings; "
                "--out should name another folder."
            )
    impossible = implausible(table, ratio, f"{mapping_path}", columns)
    warnings = (*misspelt(table, f"{mapping_path}"), *table.doubts, *impossible)
    rate = table.rate_asked_for(mapping.sample_rate) or 1 / float(np.median(np.diff(table.time)))
    started = entry.started_at or mapping.started_at or table.started_at
    if started is None:
        started = datetime.fromtimestamp(files.main.stat().st_mtime, UTC)
        table.notes.append(_OF_FILE)
    for number, (target, rows) in enumerate(zip(targets, stretches, strict=True), 1):
        header = RecordingHeader(
            recording_id=target.stem,
            campaign_id=mapping.campaign_id,
            kind=entry.kind or mapping.kind,
            started_at=as_utc(started) + timedelta(seconds=float(table.time[rows.start])),
            sample_rate=rate,
            source="import",
            setpoint=Setpoint(**entry.setpoint.model_dump()),
            gearbox=Gearbox(**mapping.gearbox.model_dump(exclude={"axis"})),
            zero_id=mapping.zero_id,
            gearbox_serial=mapping.gearbox_serial,
            axis="linear" if table.linear else "rotary",
            config=text,
            software=software(),
            attributes=provenance(files.main, table.rows_in_file(rows), number, len(stretches)),
        )
        _write(target, header, table, rows, segments, warnings)
    return targets, tuple(table.notes), warnings


def _write(
    target: Path,
    header: RecordingHeader,
    table: ChannelTable,
    rows: slice,
    segments: list[Segment],
    warnings: tuple[str, ...],
) -> None:
    channels = {name: (channel.raw[rows], channel.spec) for name, channel in table.channels.items()}
    stamps, spec = channels["time"]
    channels["time"] = (stamps - stamps[0], spec)
    inside = [
        Segment(segment.name, max(segment.start, rows.start) - rows.start, min(segment.stop, rows.stop) - rows.start)
        for segment in segments
        if segment.start < rows.stop and segment.stop > rows.start
    ]
    expected = (_OF_FILE, _FOUND_STEADY, FROM_OUTPUT, SPEED_FROM_OUTPUT, AT_OUTPUT)
    events = [
        Event(0.0, "info" if note.startswith(expected) else "warning", note) for note in (*table.notes, *warnings)
    ]
    write_recording(target, header, channels, inside, events)


def _bounds(entry: RecordingMapping, table: ChannelTable, file: Path) -> slice:
    time = table.time
    start = _row(table, entry.start, entry.start_s)
    stop = _row(table, entry.stop, entry.stop_s)
    rows = slice(start or 0, time.size if stop is None else min(stop, time.size) if entry.stop_s is not None else stop)
    if not rows.start + 1 < rows.stop <= time.size:
        first, last, size = _in_file(table, rows, entry.start, entry.stop)
        raise RecordingError(
            f"{file}: recordings.start and stop cut rows {first} to {last} out of rows 0 to {size} "
            f"({time[-1]:.6g} s), two should be left."
        )
    return rows


def _stretches(
    mapping: Mapping, entry: RecordingMapping, table: ChannelTable, whole: slice, file: Path, count: int
) -> list[slice]:
    """The rows of each recording: what stands between gaps, and pieces of that; every row of ``whole`` once.

    Of ``count`` files each gives its share of the pieces that should come of all.
    """
    edges = [whole.start, *(start for start in table.starts if whole.start < start < whole.stop), whole.stop]
    stretches = [slice(a, b) for a, b in itertools.pairwise(edges)]
    if len(stretches) > 1:
        gaps = len(stretches) - 1
        table.notes.append(f"nothing stands in {gaps} gap{'s' * (gaps > 1)}, the recording was cut there")
        short = [stretch for stretch in stretches if stretch.stop - stretch.start < 2]
        stretches = [stretch for stretch in stretches if stretch not in short]
        if short:
            table.notes.append(f"{len(short)} single samples between gaps were left out")
    pieces = entry.pieces or mapping.pieces
    if pieces is None:
        return stretches
    share = math.ceil(pieces.at_least / count)
    out = []
    for stretch in stretches:
        time = table.time[stretch]
        wanted = max(1, round(share * (stretch.stop - stretch.start) / (whole.stop - whole.start)))
        if pieces.seconds is not None:
            made: Cut = cut(time - time[0], pieces.seconds, wanted, 0.0, "s")
        else:
            assert pieces.revolutions is not None
            made = cut(
                _revolutions(mapping, table, stretch, file),
                pieces.revolutions,
                wanted,
                LEAST_REVOLUTIONS,
                "revolutions",
            )
        if made.note and made.note not in table.notes:
            table.notes.append(made.note)
        out += [slice(stretch.start + piece.start, stretch.start + piece.stop) for piece in made.pieces]
    return out


def _steady(mapping: Mapping, entry: RecordingMapping, table: ChannelTable, whole: slice) -> list[Segment]:
    """Segments of steady speed, found where the mapping names none; it is noted where there are some."""
    turned = None if table.linear else _output_revolutions(mapping, table)
    if turned is None or not np.isfinite(turned[whole]).all():
        return []
    edges = [whole.start, *(start for start in table.starts if whole.start < start < whole.stop), whole.stop]
    out: list[Segment] = []
    shortest = np.inf
    for a, b in itertools.pairwise(edges):
        run = travelled(turned[a:b], table.time[a:b])
        found = steady_stretches(turned[a:b], run, table.time[a:b])
        out += [Segment("steady", a + stretch.start, a + stretch.stop) for stretch in found]
        shortest = min([shortest, *((run[o.stop - 1] - run[o.start]) / (o.stop - o.start) for o in found)])
    if out:
        pieces = entry.pieces or mapping.pieces
        table.notes.append(f"{_FOUND_STEADY}: {len(out)}, of a revolution of the output or more")
        if pieces is not None and pieces.seconds is not None:
            rate = (table.size - 1) / float(table.time[-1])
            held = float(shortest) * rate * pieces.seconds
            if held < LEAST_REVOLUTIONS:
                table.notes.append(
                    f"pieces of {pieces.seconds:g} s hold {held:.2g} revolutions of the output at a steady speed: what"
                    f" comes once a revolution may not be found in them, pieces.revolutions = {LEAST_REVOLUTIONS:g} or"
                    " no pieces would be right"
                )
    return out


def _output_revolutions(mapping: Mapping, table: ChannelTable) -> NDArray[np.float64] | None:
    """Angle of the output in revolutions; None where no angle was recorded."""
    per = {"load_angle": 1.0, "motor_angle": abs(mapping.gearbox.ratio)}
    name = next((channel for channel in per if channel in table.channels), None)
    return None if name is None else np.asarray(table.channels[name].si / per[name] / (2 * np.pi))


def _revolutions(mapping: Mapping, table: ChannelTable, rows: slice, file: Path) -> NDArray[np.float64]:
    """Revolutions of the output run through since the first of the rows."""
    if table.linear:
        raise ConfigurationError(f"{file}: pieces.revolutions: a linear axis has none, pieces.seconds would be right.")
    turned = _output_revolutions(mapping, table)
    if turned is None:
        raise ConfigurationError(f"{file}: pieces.revolutions: no angle was recorded, pieces.seconds would be right.")
    return travelled(turned[rows], table.time[rows])


def _row(table: ChannelTable, of_file: int | None, seconds: float | None) -> int | None:
    """A row of the table that the mapping names by a row of the file, or by seconds since its first sample."""
    if seconds is not None:
        return int(np.searchsorted(table.time, seconds))
    return None if of_file is None else table.row(of_file)


def _in_file(table: ChannelTable, rows: slice, start: int | None, stop: int | None) -> tuple[int, int, int]:
    """First row, last row and number of rows as the mapping counts them: ``start`` and ``stop`` where it names them, or
    else the rows of the file that some ``rows`` of the table were made of.
    """
    inside = table.rows_in_file(rows)
    size = table.size if table.held is None else table.held.stamps.size
    return inside.start if start is None else start, inside.stop if stop is None else stop, size


def _segment(segment: SegmentMapping, table: ChannelTable, file: Path) -> Segment:
    start, stop = _row(table, segment.start, segment.start_s), _row(table, segment.stop, segment.stop_s)
    made = Segment(segment.name, start or 0, table.size if stop is None else stop)
    if not made.start < made.stop <= table.size:
        first, last, size = _in_file(table, slice(made.start, made.stop), segment.start, segment.stop)
        raise ConfigurationError(
            f"{file}: segment '{made.name}' would run from row {first} to {last}, "
            f"it should lie within rows 0 to {size}."
        )
    return made
