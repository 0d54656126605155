"""Parquet files; one column is one variable. Needs the extra ``parquet`` (pyarrow)."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats.source import Variable, at_index, missing_package, one_dimensional, unknown_variable

_UNITS = (b"unit", b"units")


class ParquetSource:
    """A Parquet file; missing values are NaN, stamps with a zone are UTC."""

    started_at: datetime | None = None
    notes: tuple[str, ...] = ()

    def __init__(self, path: Path) -> None:
        try:
            from pyarrow import parquet
        except ImportError:
            raise missing_package(path, "Parquet", "pyarrow", "parquet") from None
        self._path = path
        try:
            self._file = parquet.ParquetFile(path)
            self._schema = self._file.schema_arrow
        except Exception as error:
            raise RecordingError(f"{path}: is not a readable Parquet file ({error}).") from error

    def variables(self) -> list[Variable]:
        """Name the columns."""
        rows = self._file.metadata.num_rows
        found = []
        for field in self._schema:
            notes = field.metadata or {}
            unit = next((notes[key].decode("utf-8", "replace") for key in _UNITS if key in notes), "")
            zoned = getattr(field.type, "tz", None) is not None
            found.append(Variable(field.name, (rows,), str(field.type), unit, zoned=zoned, flat=True))
        return found

    def read(self, variable: str | None, column: int | None = None, row: int | None = None) -> NDArray[Any]:
        """Read a column."""
        if variable not in self._schema.names:
            raise unknown_variable(self._path, variable, self._schema.names)
        where = f"{self._path}: {variable}"
        try:
            values = self._file.read(columns=[variable]).column(variable).to_numpy()
        except Exception as error:
            raise RecordingError(f"{where} cannot be read ({error}).") from error
        if values.dtype.kind == "O" and all(value is None for value in values[:1]):
            values = np.array([np.nan if value is None else value for value in values])
        return one_dimensional(values, column, row, where)

    location = staticmethod(at_index)
