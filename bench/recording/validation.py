"""Checking a file against every rule of the recording format; one sentence for each departure."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py

from bench.errors import RecordingError
from bench.recording import guarded
from bench.recording.file.claims import check_claims
from bench.recording.header import PART_SUFFIX
from bench.recording.reader import HDF5_ERRORS, Recording, hdf5_reason, open_file
from bench.recording.rules import header, samples, tables
from bench.recording.rules.findings import Finding


@dataclass(frozen=True, slots=True)
class Validation:
    """Result for one file: ``violations`` of the format, and ``notes`` on what is allowed but worth knowing."""

    path: Path
    violations: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def valid(self) -> bool:
        """Whether the file meets the format."""
        return not self.violations


Rule = Callable[[h5py.File, Path], Iterator[Finding]]

_RULES: tuple[Rule, ...] = (
    header.root_attributes,
    header.groups,
    header.provenance,
    samples.channel_layout,
    samples.channel_units,
    samples.required_channels,
    samples.stored_rows,
    samples.time_and_cycle,
    tables.segments,
    tables.events,
)


def validate(path: str | Path) -> Validation:
    """Check one file against the recording format 1.0; never raises for what is wrong inside the file.

    A file that was cut short is valid when its prefix is: ``complete`` absent or false is a note.

    Raises
    ------
    RecordingError
        There is no such file.
    """
    path = Path(path)
    if not path.exists():
        raise RecordingError(f"{path}: there is no such file.")
    try:
        return guarded.call(path, _validate, path)
    except RecordingError as error:
        return Validation(path, (str(error),), ())


def _validate(path: Path) -> Validation:
    violations: list[str] = []
    notes: list[str] = []
    try:
        with open_file(path) as file:
            check_claims(file, path)
            for rule in _RULES:
                try:
                    for where, text, note in rule(file, path):
                        (notes if note else violations).append(f"{path}: {where} {text}.")
                except HDF5_ERRORS as error:
                    violations.append(f"{path}: cannot be checked further for {rule.__name__} ({error}).")
    except RecordingError as error:
        return Validation(path, (str(error),), ())
    except HDF5_ERRORS as error:
        return Validation(path, (f"{path}: the HDF5 structure is damaged ({hdf5_reason(error)}).",), ())
    if path.name.endswith(PART_SUFFIX):
        notes.append(f"{path}: was never finished; 'bench repair' makes a recording of it.")
    if not violations:
        violations.extend(_reader_agrees(path))
    return Validation(path, tuple(violations), tuple(notes))


def _reader_agrees(path: Path) -> tuple[str, ...]:
    """Ask the reader as well: what it cannot live with is wrong, whatever the rules above say."""
    try:
        return Recording.open(path).problems
    except RecordingError as error:
        return (str(error),)
