"""Files of other tools as tables of named variables, each read when it is asked for."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.recording.importing.mapping import CsvMapping

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_MAT73_USER_BLOCK = 512


class Source(Protocol):
    """A file of variables."""

    def read(self, variable: str | None, column: int | None) -> NDArray[Any]:
        """Read a variable as a one-dimensional numeric array; ``column`` counts from 1.

        Raises
        ------
        RecordingError
            There is no such variable or column, or it is not numeric.
        """

    def names(self) -> list[str]:
        """Name the variables, for the error text."""


def open_source(path: Path, options: CsvMapping) -> Source:
    """Open a file by what it is, not by its name.

    Raises
    ------
    RecordingError
        The file is missing, damaged, or of a kind that is not known.
    """
    try:
        with path.open("rb") as file:
            head = file.read(_MAT73_USER_BLOCK + len(_HDF5_SIGNATURE))
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror}).") from error
    if head.startswith(_HDF5_SIGNATURE) or head[_MAT73_USER_BLOCK:].startswith(_HDF5_SIGNATURE):
        # MATLAB stores matrices column by column, HDF5 row by row: a v7.3 file shows them transposed.
        return Hdf5Source(path, transposed=head.startswith(b"MATLAB"))
    if head.startswith(b"MATLAB 5.0"):
        return MatSource(path)
    if head.startswith((b"TDSm", b"TDSh")):
        return TdmsSource(path)
    if path.suffix.lower() in (".csv", ".txt", ".dat", ".tsv"):
        return CsvSource(path, options)
    raise RecordingError(f"{path}: is none of MAT, HDF5, TDMS or CSV (.csv, .txt, .dat, .tsv).")


def _vector(values: Any, column: int | None, where: str) -> NDArray[Any]:
    """Make a one-dimensional numeric array of a variable."""
    array = np.asarray(values)
    if array.dtype.kind == "b":
        array = array.astype(np.uint8)
    if array.dtype.kind not in "iuf":
        raise RecordingError(f"{where} is {array.dtype}, it should be numeric.")
    if column is not None and array.ndim == 2:
        if column > array.shape[1]:
            raise RecordingError(f"{where} has {array.shape[1]} columns, column {column} was asked for.")
        return np.asarray(array[:, column - 1])
    if array.ndim > 1 and array.size != max(array.shape):
        raise RecordingError(f"{where} is a {' x '.join(map(str, array.shape))} matrix, 'column' should say which.")
    return array.reshape(-1)


def _unknown(path: Path, variable: str | None, names: list[str]) -> RecordingError:
    return RecordingError(f"{path}: there is no variable '{variable}'; the file has {', '.join(names)}.")


class MatSource:
    """A MATLAB file up to version 7; structure fields as ``structure.field``."""

    def __init__(self, path: Path) -> None:
        import scipy.io

        self._path = path
        try:
            self._contents = scipy.io.loadmat(path, squeeze_me=False, struct_as_record=False)
        except Exception as error:  # the reader raises many kinds on damaged files
            raise RecordingError(f"{path}: is not a readable MAT file ({error}).") from error

    def names(self) -> list[str]:
        """Name the variables."""
        return [name for name in self._contents if not name.startswith("__")]

    def read(self, variable: str | None, column: int | None) -> NDArray[Any]:
        """Read a variable, or a field of a structure."""
        first, *fields = (variable or "").split(".")
        if first not in self.names():
            raise _unknown(self._path, variable, self.names())
        value = self._contents[first]
        for field in fields:
            structure = value.reshape(-1)[0] if isinstance(value, np.ndarray) and value.size == 1 else value
            if not hasattr(structure, field):
                raise _unknown(self._path, variable, self.names())
            value = getattr(structure, field)
        return _vector(value, column, f"{self._path}: {variable}")


class Hdf5Source:
    """An HDF5 file, or a MATLAB 7.3 file; groups as ``group/dataset`` or ``structure.field``."""

    def __init__(self, path: Path, *, transposed: bool) -> None:
        self._path = path
        self._transposed = transposed

    def names(self) -> list[str]:
        """Name the datasets."""
        found: list[str] = []
        with h5py.File(self._path, "r") as file:
            file.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
        return found

    def read(self, variable: str | None, column: int | None) -> NDArray[Any]:
        """Read a dataset."""
        try:
            with h5py.File(self._path, "r") as file:
                item = file.get(variable or "") or file.get((variable or "").replace(".", "/"))
                if not isinstance(item, h5py.Dataset):
                    raise _unknown(self._path, variable, self.names())
                values = item[()]
        except (OSError, RuntimeError) as error:
            raise RecordingError(f"{self._path}: {variable} cannot be read ({error}).") from error
        return _vector(np.transpose(values) if self._transposed else values, column, f"{self._path}: {variable}")


class TdmsSource:
    """A LabVIEW TDMS file; channels as ``group/channel``. Needs the extra ``tdms`` (npTDMS)."""

    def __init__(self, path: Path) -> None:
        try:
            from nptdms import TdmsFile
        except ImportError:
            raise RecordingError(
                f"{path}: TDMS files need the package npTDMS, install the project with the extra 'tdms'."
            ) from None
        self._path = path
        try:
            self._file = TdmsFile.read(path)
        except Exception as error:  # the reader raises many kinds on damaged files
            raise RecordingError(f"{path}: is not a readable TDMS file ({error}).") from error

    def names(self) -> list[str]:
        """Name the channels."""
        return [f"{group.name}/{channel.name}" for group in self._file.groups() for channel in group.channels()]

    def read(self, variable: str | None, column: int | None) -> NDArray[Any]:
        """Read a channel."""
        if variable not in self.names():
            raise _unknown(self._path, variable, self.names())
        group, _, channel = variable.partition("/")
        return _vector(self._file[group][channel][:], column, f"{self._path}: {variable}")


class CsvSource:
    """A text table: numbers with one kind of separator, headings in the first line where there are any."""

    def __init__(self, path: Path, options: CsvMapping) -> None:
        self._path = path
        try:
            lines = path.read_text(encoding="utf-8-sig").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise RecordingError(f"{path}: is not readable as text ({error}).") from error
        self._decimal = options.decimal
        kept = [
            line
            for line in lines[options.skip_lines :]
            if line.strip() and not line.lstrip().startswith(options.comment)
        ]
        if not kept:
            raise RecordingError(f"{path}: holds no line of data.")
        self._delimiter = options.delimiter or _delimiter(kept[0], options.decimal)
        fields = [field.strip() for field in next(csv.reader([kept[0]], delimiter=self._delimiter))]
        self._headings = [] if all(self._is_number(field) for field in fields) else fields
        self._lines = kept[1:] if self._headings else kept
        self._width = len(fields)

    def names(self) -> list[str]:
        """Name the columns."""
        return self._headings or [f"column {index + 1}" for index in range(self._width)]

    def read(self, variable: str | None, column: int | None) -> NDArray[Any]:
        """Read a column by heading or number."""
        if variable is not None:
            if variable not in self._headings:
                raise _unknown(self._path, variable, self.names())
            column = self._headings.index(variable) + 1
        if column is None or column > self._width:
            raise RecordingError(f"{self._path}: has {self._width} columns, column {column} was asked for.")
        text = "\n".join(self._lines)
        if self._decimal == ",":
            text = text.replace(",", ".") if self._delimiter != "," else text
        try:
            return np.loadtxt(io.StringIO(text), delimiter=self._delimiter, usecols=column - 1, ndmin=1, quotechar='"')
        except ValueError as error:
            raise RecordingError(f"{self._path}: {self.names()[column - 1]} is not numeric ({error}).") from error

    def _is_number(self, field: str) -> bool:
        try:
            float(field.replace(",", ".") if self._decimal == "," else field)
        except ValueError:
            return False
        return True


def _delimiter(line: str, decimal: str) -> str:
    """Choose the separator that occurs most often in the first line; a decimal comma separates nothing."""
    candidates = [mark for mark in ";\t,| " if mark != decimal]
    return max(candidates, key=line.count)
