"""Reading one recording: header at once, samples when they are asked for.

The file is open only while something is read, so that a folder of thousands of recordings holds no handles and a
:class:`Recording` can be sent to another process.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.recording import guarded
from bench.recording._header_reader import read_header
from bench.recording.file.samples import Places
from bench.recording.header import ChannelSpec, Event, Gearbox, Segment, Setpoint
from bench.signals import BY_NAME

DERIVED_FROM: dict[str, str] = {"motor_velocity": "motor_angle", "load_velocity": "load_angle"}
"""A missing velocity is the time derivative of its angle."""

_LINEAR_UNITS = ("m", "m/s", "N")

HDF5_ERRORS = (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError)
"""What h5py raises where the structure of a file is broken; which of them depends on the place."""


_LOOKS = 5
"""How often a file that is written meanwhile is looked at; its writer flushes five times a second at most."""


@contextmanager
def open_file(path: Path) -> Iterator[h5py.File]:
    """Open an HDF5 file for reading, without locking it, or raise a :class:`RecordingError`."""
    if path.is_dir():
        raise RecordingError(f"{path}: is a folder, it should be a recording; {_recording_in(path)}.")
    if not path.is_file():
        raise RecordingError(f"{path}: there is no such file.")
    try:
        file = _open(path)
    except OSError as error:
        raise RecordingError(f"{path}: not a readable HDF5 file ({hdf5_reason(error)}).") from error
    with file:
        yield file


def _recording_in(folder: Path) -> str:
    """Half a sentence that names a recording of a folder."""
    first = min((path.name for path in folder.glob("*.h5")), default=None)
    return "no file in it is called NAME.h5" if first is None else f"name a file in it, such as {folder / first}"


def _open(path: Path) -> h5py.File:
    try:
        # Without a lock a recording can be read while it is written, and from a read-only share.
        return h5py.File(path, "r", locking=False)
    except OSError as error:
        if "locking flag" not in str(error):
            raise
        # Somebody in this process has it open with a lock; HDF5 wants the same of everyone.
        return h5py.File(path, "r")


def hdf5_reason(error: Exception) -> str:
    """Take the innermost reason, the one in parentheses, from an HDF5 error text."""
    # the text of a KeyError is in quotation marks
    text = error.args[0] if isinstance(error, KeyError) and error.args else error
    message = str(text).strip().rstrip(".")
    return message[message.rfind("(") + 1 :].rstrip(")") if "(" in message else message


def _header(path: Path, prefix: bool = False) -> dict[str, Any]:
    for _ in range(_LOOKS - 1):
        stamp = _stamp(path)
        try:
            return {**_looked_at(path, prefix), "stamp": stamp}
        except RecordingError:
            # Every state on the disk is whole, but a reader that began before a flush may end behind it.
            if _stamp(path) == stamp:
                raise
    return {**_looked_at(path, prefix), "stamp": _stamp(path)}


def _looked_at(path: Path, prefix: bool) -> dict[str, Any]:
    with open_file(path) as file:
        try:
            return read_header(file, path, prefix=prefix)
        except HDF5_ERRORS as error:
            raise RecordingError(f"{path}: the HDF5 structure is damaged ({hdf5_reason(error)}).") from error


def _stamp(path: Path | int) -> tuple[int, ...]:
    """What changes when a file (or what a descriptor is of) is written or replaced."""
    try:
        seen = os.stat(path)
    except OSError:
        return ()
    return (seen.st_dev, seen.st_ino, seen.st_size, seen.st_mtime_ns)


def _rows(path: Path, names: Sequence[str], start: int, stop: int) -> dict[str, NDArray[Any]]:
    """Read rows with the HDF5 library; in a child."""
    result: dict[str, NDArray[Any]] = {}
    with open_file(path) as file:
        for name in names:
            try:
                result[name] = file["channels"][name][start:stop]
            except HDF5_ERRORS as error:
                raise unreadable(path, name, start, stop, hdf5_reason(error)) from error
    return result


def unreadable(path: Path, name: str, start: int, stop: int, why: object) -> RecordingError:
    """Say that rows of a channel cannot be read."""
    return RecordingError(f"{path}: /channels/{name} rows {start} to {stop} cannot be read ({why}).")


@dataclass(frozen=True, slots=True)
class Recording:
    """One recording, read lazily; see the recording format for the meaning of each value.

    ``size`` is N, the number of rows; in a recording that was cut short N is the length of the shortest channel.
    ``problems`` are departures from the format that the reader could live with, one sentence each. Recordings with the
    same ``imported_from`` are pieces of one file.
    """

    path: Path
    recording_id: str
    campaign_id: str
    kind: str
    started_at: datetime
    sample_rate: float
    source: str
    complete: bool
    setpoint: Setpoint
    gearbox: Gearbox
    specs: dict[str, ChannelSpec]
    size: int
    segments: tuple[Segment, ...]
    events: tuple[Event, ...]
    point_id: str | None = None
    zero_id: str | None = None
    take: int | None = None
    accepted: bool | None = None
    gearbox_serial: str | None = None
    axis: str | None = None
    imported_from: str | None = None
    quality: dict[str, Any] = field(default_factory=dict)
    config: str | None = None
    software: dict[str, str] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    places: dict[str, Places | None] = field(default_factory=dict, repr=False, compare=False)
    stamp: tuple[int, ...] = field(default=(), repr=False, compare=False)

    @classmethod
    def open(cls, path: str | Path, *, prefix: bool = False) -> Recording:
        """Read the header of a recording, or of the valid prefix of one that was cut short.

        With ``prefix`` a complete recording that lacks rows is opened as one that was cut short before them.

        Raises
        ------
        RecordingError
            The file is not HDF5, not a recording, or lacks what no reader can do without.
        """
        path = Path(path)
        return cls(path=path, **guarded.call(path, _header, path, prefix))

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that stand in the file."""
        return tuple(self.specs)

    @property
    def linear(self) -> bool:
        """Whether it is of a linear axis: metres and newtons where others have radians and newton metres."""
        if self.axis is not None:
            return self.axis == "linear"
        return any(spec.unit in _LINEAR_UNITS for name, spec in self.specs.items() if name in BY_NAME)

    def __contains__(self, name: object) -> bool:
        """Whether :meth:`si` can give ``name``, stored or derived."""
        return name in self.specs or self.is_derived(str(name))

    def is_derived(self, name: str) -> bool:
        """Whether ``name`` is not stored but follows from another channel (a velocity from its angle)."""
        return name not in self.specs and DERIVED_FROM.get(name) in self.specs

    def steady(self) -> tuple[slice, ...]:
        """Slices of all segments called ``steady``; what identification uses."""
        return tuple(slice(s.start, s.stop) for s in self.segments if s.name == "steady")

    def longest_steady(self) -> slice | None:
        """The longest segment called ``steady``, the first of several; None where there is none."""
        return max(self.steady(), key=lambda part: part.stop - part.start, default=None)

    def raw(self, name: str, start: int = 0, stop: int | None = None) -> NDArray[Any]:
        """Read rows ``start`` to ``stop`` (exclusive) of a channel as they stand in the file."""
        return self.read_raw((name,), start, stop)[name]

    def si(self, name: str, start: int = 0, stop: int | None = None) -> NDArray[np.float64]:
        """Read rows ``start`` to ``stop`` of a channel in SI units (temperatures in °C).

        A velocity that is missing is derived from its angle by central differences of the two neighbours (one-sided
        at the ends of the recording); it carries the encoder's quantisation and is not filtered.
        """
        return self.read_si((name,), start, stop)[name]

    def read_si(self, names: Sequence[str], start: int = 0, stop: int | None = None) -> dict[str, NDArray[np.float64]]:
        """Read several channels in SI units with the file opened once."""
        start, stop = self._bounds(start, stop)
        stored = [name for name in names if not self.is_derived(name)]
        result = {name: self._scaled(name, raw) for name, raw in self.read_raw(stored, start, stop).items()}
        for name in names:
            if name not in result:
                result[name] = self._derivative(DERIVED_FROM[name], start, stop)
        return result

    def read_raw(self, names: Sequence[str], start: int = 0, stop: int | None = None) -> dict[str, NDArray[Any]]:
        """Read several channels as they stand in the file, with the file opened once."""
        start, stop = self._bounds(start, stop)
        missing = [name for name in names if name not in self.specs]
        if missing:
            raise RecordingError(
                f"{self.path}: there is no channel '{missing[0]}'; the recording has {', '.join(self.channels)}."
            )
        try:
            descriptor = os.open(self.path, os.O_RDONLY)
        except OSError as error:
            raise RecordingError(f"{self.path}: cannot be opened ({error.strerror}).") from error
        try:
            return self._read(descriptor, names, start, stop)
        finally:
            os.close(descriptor)

    def _read(self, descriptor: int, names: Sequence[str], start: int, stop: int) -> dict[str, NDArray[Any]]:
        places = self.places
        if _stamp(descriptor) != self.stamp:
            # it goes on being written, or is another file by now
            places = guarded.call(self.path, _header, self.path)["places"]
        foreign = [name for name in names if places.get(name) is None]
        result = guarded.call(self.path, _rows, self.path, foreign, start, stop) if foreign else {}
        for name in names:
            place = places.get(name)
            if place is not None:
                try:
                    result[name] = place.read(descriptor, start, stop)
                except (OSError, MemoryError) as error:
                    raise unreadable(self.path, name, start, stop, error) from error
        return result

    def _bounds(self, start: int, stop: int | None) -> tuple[int, int]:
        stop = self.size if stop is None else stop
        if not 0 <= start <= stop <= self.size:
            raise RecordingError(
                f"{self.path}: rows {start} to {stop} were asked for, the recording has rows 0 to {self.size}."
            )
        return start, stop

    def _scaled(self, name: str, raw: NDArray[Any]) -> NDArray[np.float64]:
        spec = self.specs[name]
        values = raw.astype(np.float64, copy=False)
        if spec.scale != 1.0:
            values *= spec.scale
        if spec.offset != 0.0:
            values += spec.offset
        return values

    def _derivative(self, angle: str, start: int, stop: int) -> NDArray[np.float64]:
        # One neighbour on each side is read too, so that a value does not depend on the rows asked for.
        low, high = max(start - 1, 0), min(stop + 1, self.size)
        if high - low < 2:
            return np.full(stop - start, np.nan)
        values = self.read_si((angle, "time"), low, high)
        rows = np.arange(start, stop)
        before, after = np.maximum(rows - 1, 0) - low, np.minimum(rows + 1, self.size - 1) - low
        rise, run = (values[name][after] - values[name][before] for name in (angle, "time"))
        slope = np.full(rows.size, np.nan)
        np.divide(rise, run, out=slope, where=run != 0)
        return slope
