"""HDF5 files of any layout, and MATLAB 7.3 files, which are HDF5 inside."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats.source import Variable, at_index, one_dimensional, unknown_variable

_UNITS = ("unit", "units", "Unit", "Units")
_RATES = ("sample_rate", "sampling_rate", "sampling_frequency", "fs", "rate")
_INTERNAL = ("#refs#", "#subsystem#")
T = TypeVar("T")


class Hdf5Source:
    """An HDF5 file: ``group/dataset`` (or ``group.dataset``), and ``table.field`` where rows are records.

    ``transposed``: MATLAB stores matrices column by column, HDF5 row by row, so a v7.3 file shows them transposed.
    """

    started_at: datetime | None = None
    notes: tuple[str, ...] = ()

    def __init__(self, path: Path, *, transposed: bool) -> None:
        self._path = path
        self._transposed = transposed
        self._variables = {variable.name: variable for variable in self._guarded(self._found)}

    def variables(self) -> list[Variable]:
        """Name the datasets of numbers."""
        return list(self._variables.values())

    def read(self, variable: str | None, column: int | None = None, row: int | None = None) -> NDArray[Any]:
        """Read a dataset, or a field of a table."""
        values = self._guarded(lambda file: self._values(file, variable or ""))
        if self._transposed and values.dtype.kind not in "SUO":
            values = np.transpose(values)
        return one_dimensional(values, column, row, f"{self._path}: {variable}")

    location = staticmethod(at_index)

    def _values(self, file: h5py.File, variable: str) -> NDArray[Any]:
        item = file.get(variable) or file.get(variable.replace(".", "/"))
        if isinstance(item, h5py.Dataset) and item.dtype.names is None:
            return np.asarray(item[()])
        name, _, field = variable.rpartition(".")
        table = file.get(name) if name else None
        if isinstance(table, h5py.Dataset) and field in (table.dtype.names or ()):
            return np.asarray(table[field])
        raise unknown_variable(self._path, variable, self._variables)

    def _found(self, file: h5py.File) -> list[Variable]:
        found: list[Variable] = []

        def visit(name: str, item: Any) -> None:
            if not isinstance(item, h5py.Dataset) or name.startswith(_INTERNAL) or item.attrs.get("MATLAB_empty", 0):
                return
            if item.dtype.names is not None:
                kinds = {field: item.dtype[field] for field in item.dtype.names}
                found.extend(
                    Variable(f"{name}.{field}", item.shape, str(kind))
                    for field, kind in kinds.items()
                    if kind.kind in "biuf"
                )
            elif item.dtype.kind in "biuf" and _text(item.attrs.get("MATLAB_class")) != "char" and item.ndim > 0:
                shape = item.shape[::-1] if self._transposed else item.shape
                unit = next((_text(item.attrs[key]) for key in _UNITS if key in item.attrs), "")
                rate = next((_number(item.attrs[key]) for key in _RATES if key in item.attrs), None)
                found.append(Variable(name, shape, str(item.dtype), unit, rate, _clock(item, name)))

        file.visititems(visit)
        return found

    def _guarded(self, act: Callable[[h5py.File], T]) -> T:
        try:
            with h5py.File(self._path, "r", locking=False) as file:
                return act(file)
        except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
            raise RecordingError(f"{self._path}: is not readable as HDF5, cannot be read ({error}).") from error


def _clock(item: h5py.Dataset, name: str) -> str | None:
    """Name the dimension scale of the first axis, where there is one other than the dataset itself."""
    for scale in item.dims[0].values():
        if scale.name.lstrip("/") != name and scale.dtype.kind in "iuf":
            return str(scale.name.lstrip("/"))
    return None


def _text(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.reshape(-1)[0] if value.size else ""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value or "")


def _number(value: Any) -> float | None:
    try:
        number = float(np.asarray(value).reshape(-1)[0])
    except (TypeError, ValueError, IndexError):
        return None
    return number if np.isfinite(number) and number > 0 else None
