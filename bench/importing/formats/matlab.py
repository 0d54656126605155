"""MATLAB files up to version 7 (4 and 5 inside); fields of structures as ``structure.field``."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from struct import unpack_from
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats.source import Variable, at_index, one_dimensional, unknown_variable

_HEADER = 20
_LONGEST_NAME = 256
_BYTES = (8, 4, 4, 2, 2, 1)
"""of a number of each type that MATLAB 4 stores"""
_ARRAYS = {
    "timetable": ", as v = NAME.Variables and t = seconds(NAME.Properties.RowTimes)",
    "table": ", as v = NAME.Variables",
    "timeseries": ", as v = NAME.Data and t = NAME.Time",
}
"""how MATLAB makes arrays of its own kinds of tables"""


def is_version_4(head: bytes, size: int) -> bool:
    """Whether a file begins as MATLAB 4 files do, which have no signature: five integers that fit, and a name.

    Some writers end the name without NUL. The first variable then has to lie within the ``size`` of the file (bytes):
    integers of other binary files fit more easily.
    """
    if len(head) < _HEADER + 1:
        return False
    for order in "<>":
        kind, rows, columns, imaginary, length = unpack_from(f"{order}5i", head)
        digits = [kind // 1000, kind // 100 % 10, kind // 10 % 10, kind % 10]
        fits = 0 <= kind < 5000 and digits[1] == 0 and digits[2] <= 5 and digits[3] <= 2
        if fits and rows >= 0 and columns >= 0 and imaginary in (0, 1) and 1 <= length <= _LONGEST_NAME:
            name = head[_HEADER : _HEADER + length]
            end = _HEADER + length + rows * columns * _BYTES[digits[2]] * (1 + imaginary)
            if name.strip(b"\0").decode("ascii", "replace").isidentifier() and (name[-1:] == b"\0" or end <= size):
                return True
    return False


class MatlabSource:
    """A MATLAB file that SciPy reads."""

    started_at: datetime | None = None
    notes: tuple[str, ...] = ()

    def __init__(self, path: Path) -> None:
        import scipy.io

        self._path = path
        try:
            contents = scipy.io.loadmat(path, squeeze_me=False, struct_as_record=False)
        except Exception as error:
            raise RecordingError(f"{path}: is not a readable MAT file ({error}).") from error
        self._arrays: dict[str, NDArray[Any]] = {}
        self._objects: dict[str, str] = {}
        for name, value in contents.items():
            if isinstance(value, scipy.io.matlab.MatlabOpaque):
                key, kind = value[0]["s0"], value[0]["s2"]
                self._objects[key.decode() or name] = kind.decode()
            elif not name.startswith("__"):
                self._arrays.update(_flat(name, value))

    def variables(self) -> list[Variable]:
        """Name the variables, and the fields of structures."""
        found = [Variable(name, array.shape, str(array.dtype)) for name, array in self._arrays.items()]
        return found + [Variable(name, (), kind) for name, kind in self._objects.items()]

    def read(self, variable: str | None, column: int | None = None, row: int | None = None) -> NDArray[Any]:
        """Read a variable, or a field of a structure."""
        if variable in self._objects:
            raise RecordingError(
                f"{self._path}: {variable} is a MATLAB {self._objects[variable]}, which only MATLAB reads; its numbers"
                f" should be saved as arrays{_ARRAYS.get(self._objects[variable], '').replace('NAME', variable)}."
            )
        if variable not in self._arrays:
            raise unknown_variable(self._path, variable, self._arrays)
        return one_dimensional(self._arrays[variable], column, row, f"{self._path}: {variable}")

    location = staticmethod(at_index)


def _flat(name: str, value: Any) -> Iterator[tuple[str, NDArray[Any]]]:
    """Give the arrays of numbers under a name; of an array of structures ``name(2).field``, as MATLAB writes it."""
    if hasattr(value, "_fieldnames"):
        for field in value._fieldnames:
            yield from _flat(f"{name}.{field}", getattr(value, field))
    elif isinstance(value, np.ndarray) and value.dtype.kind == "O":
        items = value.reshape(-1)
        for index, item in enumerate(items):
            yield from _flat(name if items.size == 1 else f"{name}({index + 1})", item)
    elif isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        yield name, value
