"""NumPy files: the arrays of an ``.npz``, the one array or table of an ``.npy``; nothing that is pickled is run."""

from __future__ import annotations

import zipfile
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats.source import Variable, at_index, one_dimensional, unknown_variable

ONE = "array"
"""name of the array of a file that holds one without a name"""
SIGNATURE = b"\x93NUMPY"
ARCHIVE = b"PK\x03\x04"
ENDING = ".npy"


class NumpySource:
    """A file of NumPy; fields of a table are variables of their own."""

    started_at: datetime | None = None
    notes: tuple[str, ...] = ()

    def __init__(self, path: Path) -> None:
        self._path = path
        self._arrays: dict[str, NDArray[Any]] = {}
        self._pickled: list[str] = []
        try:
            contents = np.load(path, allow_pickle=False, mmap_mode="r")
            if isinstance(contents, np.ndarray):
                self._take(ONE, contents)
            else:
                with contents:
                    for name in contents.files:
                        self._open(name, contents)
        except Exception as error:
            raise RecordingError(f"{path}: is not a readable NumPy file ({error}).") from error

    def _open(self, name: str, contents: Any) -> None:
        try:
            self._take(name, contents[name])
        except ValueError:  # the others are read: what is pickled is no array of numbers
            self._pickled.append(name)

    def _take(self, name: str, array: NDArray[Any]) -> None:
        if array.dtype.names is None:
            self._arrays[name] = array
        else:
            self._arrays |= {f"{name}.{field}": array[field] for field in array.dtype.names}

    def variables(self) -> list[Variable]:
        """Name the arrays, and the fields of tables."""
        found = [Variable(name, array.shape, str(array.dtype)) for name, array in self._arrays.items()]
        return found + [Variable(name, (), "object") for name in self._pickled]

    def read(self, variable: str | None, column: int | None = None, row: int | None = None) -> NDArray[Any]:
        """Read an array, or a field of a table."""
        if variable in self._pickled:
            raise RecordingError(f"{self._path}: {variable} is pickled, it should be an array of numbers.")
        if variable not in self._arrays:
            raise unknown_variable(self._path, variable, self._arrays)
        return one_dimensional(self._arrays[variable], column, row, f"{self._path}: {variable}")

    location = staticmethod(at_index)


def is_archive(path: Path, head: bytes) -> bool:
    """Whether a file is an archive of arrays, as ``numpy.savez`` makes it."""
    if not head.startswith(ARCHIVE):
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except (zipfile.BadZipFile, OSError):
        return path.suffix.lower() == ".npz"
    return bool(names) and all(name.endswith(ENDING) for name in names)
