"""What reads a file of each kind, and what became of it, in a word."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.campaigns import load_campaign
from bench.campaigns.records.journal import Journal
from bench.configuration import load_bench
from bench.errors import BenchError, RecordingError
from bench.fuzzing import samples
from bench.importing.mapping import load_mapping
from bench.recording import Recording
from bench.recording.repairing import repair
from bench.recording.validation import validate
from bench.simulation import Simulation

REFUSED, READ, TOLD, CAUGHT = "refused", "read", "told", "crash caught"
SILENT, LOST = "silent", "source lost"
"""In one sentence; as it was written; not as it was, and said so; the library crashed in a child, and one sentence came
of it; wrong samples and no word; the spoiled file, or what lay beside it, is gone or changed."""

Values = dict[str, NDArray[np.float64]]


def read_recording(path: Path) -> str:
    """Open, read every sample, validate."""
    before = path.read_bytes()
    try:
        outcome = _compare_samples(path)
    except RecordingError as error:
        outcome = _refusal(error)
    return outcome if path.read_bytes() == before else LOST


def read_part(path: Path) -> str:
    """As a recording; then repair it, and read what came of it."""
    outcome = read_recording(path)
    before = path.read_bytes()
    try:
        done = repair(path)
    except RecordingError as error:
        return LOST if not _is_unchanged(path, before) else _worst((outcome, _refusal(error)))
    if not _is_unchanged(done.source, before):
        return LOST
    try:
        restored = _compare_samples(done.path)
        return _worst((outcome, TOLD if restored == SILENT and not done.valid else restored))
    except RecordingError as error:
        return _worst((outcome, _refusal(error)))


def read_model(path: Path) -> str:
    """Load a simulation file and ask it for its series."""
    return _load_outcome(path, lambda: Simulation.load(path).transmission_error())


def read_bench(path: Path) -> str:
    """Load a bench file."""
    return _load_outcome(path, lambda: load_bench(path))


def read_campaign(path: Path) -> str:
    """Load a campaign file."""
    return _load_outcome(path, lambda: load_campaign(path))


def read_mapping(path: Path) -> str:
    """Load a mapping of foreign files."""
    return _load_outcome(path, lambda: load_mapping(path))


def read_journal(path: Path) -> str:
    """Open the journal of a folder again, as the next run would."""
    before = path.read_bytes()
    beside = {file: file.read_bytes() for file in path.parent.glob("*.h5")}
    try:
        with Journal(path.parent, load_campaign("quick"), load_bench("rh380n")) as journal:
            known = {taken.recording_id for taken in journal.takes()}
            journal.done()
            journal.next_take("p1")
    except BenchError:
        outcome = REFUSED
    else:
        every = {samples.taken(number).recording_id for number in range(1, samples.TAKES + 1)}
        outcome = READ if known == every else TOLD if _still_exists(path, before) else SILENT
    return outcome if all(_is_unchanged(file, content) for file, content in beside.items()) else LOST


READERS: dict[str, Callable[[Path], str]] = {
    "h5": read_recording,
    "part": read_part,
    "model": read_model,
    "bench": read_bench,
    "campaign": read_campaign,
    "mapping": read_mapping,
    "journal": read_journal,
}


def examine(kind: str, valid: str, data: bytes, folder: str) -> str:
    """Put ``data`` in the place of the file ``valid``, in a copy of where it lies, and read it."""
    source, place = Path(valid), Path(folder)
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    if kind == "journal":
        shutil.copytree(source.parent, place, dirs_exist_ok=True)
        for more in ("-wal", "-shm"):
            (place / f"{source.name}{more}").unlink(missing_ok=True)
    path = place / source.name
    path.write_bytes(data)
    return READERS[kind](path)


def _load_outcome(path: Path, load: Callable[[], object]) -> str:
    before = path.read_bytes()
    try:
        load()
    except BenchError:
        return REFUSED if _is_unchanged(path, before) else LOST
    return READ if _is_unchanged(path, before) else LOST


def _compare_samples(path: Path) -> str:
    """Compare samples in SI with those that were written; in a recording cut short, the rows it has."""
    recording = Recording.open(path)
    values = recording.read_si(recording.channels)
    said = bool(recording.problems) or not validate(path).valid
    true = _true()
    whole = recording.size == samples.ROWS or not recording.complete
    same = set(values) == set(true) and whole
    same = same and all(np.array_equal(values[name], true[name][: recording.size]) for name in true)
    if not same:
        return TOLD if said else SILENT
    return TOLD if said or not recording.complete else READ


def _true() -> Values:
    raw = samples.columns(0, samples.ROWS)
    return {spec.name: raw[spec.name] * spec.scale + spec.offset for spec in samples.SPECS}


def _refusal(error: RecordingError) -> str:
    return CAUGHT if "crash of the HDF5 library" in str(error) else REFUSED


def _worst(outcomes: Iterable[str]) -> str:
    return max(outcomes, key=lambda outcome: (READ, REFUSED, TOLD, CAUGHT, SILENT, LOST).index(outcome))


def _is_unchanged(path: Path, content: bytes) -> bool:
    return path.is_file() and path.read_bytes() == content


def _still_exists(path: Path, content: bytes) -> bool:
    """Whether the spoiled file is still there, under whatever name."""
    return any(_is_unchanged(file, content) for file in path.parent.iterdir())
