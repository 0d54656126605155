"""JSON files: arrays and matrices of numbers, lists of records whose fields become columns, and JSON lines."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats.numpy_file import ONE
from bench.importing.formats.source import Variable, at_index, one_dimensional, unknown_variable
from bench.importing.formats.text_stamps import has_zone, is_stamp, is_time_of_day, parse_stamps, seconds_of_day

_BEGINS = re.compile(rb"(\xef\xbb\xbf)?\s*(\{\s*[\"}]|\[\s*[\[{])")
"""an object, or a list of lists or objects; a heading in brackets or a list of bare numbers may be another text"""


def is_json(head: bytes) -> bool:
    """Whether a file begins as an object or a list of rows or records does."""
    return _BEGINS.match(head) is not None


class JsonSource:
    """A JSON file, or one with an object in each line.

    Names of nested objects are joined by dots; the fields of a list of records are variables, with NaN where a record
    has none.
    """

    started_at: datetime | None = None
    notes: tuple[str, ...] = ()

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            content = _parsed(path.read_text(encoding="utf-8-sig"))
            self._arrays: dict[str, NDArray[Any]] = dict(_flat("", content))
        except json.JSONDecodeError as error:
            raise RecordingError(
                f"{path}: is not readable as JSON ({error.msg} in line {error.lineno}, column {error.colno})."
            ) from error
        except UnicodeDecodeError as error:
            raise RecordingError(f"{path}: is not readable as JSON in UTF-8 ({error}).") from error
        except RecursionError as error:
            raise RecordingError(f"{path}: is JSON that is nested too deep to be measurements.") from error

    def variables(self) -> list[Variable]:
        """Name the arrays, the fields of records, and single numbers."""
        found = []
        for name, array in self._arrays.items():
            first = _first(array)
            kind = "time stamps" if is_stamp(first) else "text" if array.dtype.kind == "O" else str(array.dtype)
            unit = "s" if is_time_of_day(first) else ""
            found.append(Variable(name, array.shape, kind, unit, zoned=has_zone(first), flat=True))
        return found

    def read(self, variable: str | None, column: int | None = None, row: int | None = None) -> NDArray[Any]:
        """Read an array, or a field of records."""
        if variable not in self._arrays:
            raise unknown_variable(self._path, variable, self._arrays)
        array, where = self._arrays[variable], f"{self._path}: {variable}"
        first = _first(array)
        if is_stamp(first):
            texts = array.tolist()
            return seconds_of_day(texts, where) if is_time_of_day(first) else parse_stamps(texts, where)
        if first and array.size == 1:
            raise RecordingError(f"{where} is text ('{first}'), it should be numeric.")
        return one_dimensional(array, column, row, where)

    location = staticmethod(at_index)


def _parsed(text: str) -> Any:
    try:
        return json.loads(text)
    except json.JSONDecodeError as error:
        if error.msg != "Extra data":
            raise
        lines = [line for line in text.splitlines() if line.strip()]
        try:
            return [json.loads(line) for line in lines]
        except json.JSONDecodeError:
            raise error from None


def _flat(name: str, value: Any) -> Iterator[tuple[str, NDArray[Any]]]:
    """Give the arrays that stand in a value, by name."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield from _flat(f"{name}.{key}" if name else str(key), part)
    elif isinstance(value, list) and value and all(isinstance(part, dict) for part in value):
        fields = list(dict.fromkeys(key for part in value for key in part))
        for field in fields:
            yield from _flat(f"{name}.{field}" if name else field, [part.get(field) for part in value])
    elif isinstance(value, list) and _nested(value):
        # records of which some have no such object, or lists of unequal length, are no matrix
        if all(isinstance(part, dict) or part is None for part in value):
            yield from _flat(name, [part or {} for part in value])
        else:
            yield name or ONE, _matrix(value)
    else:
        yield name or ONE, _array(value)


def _nested(value: list[Any]) -> bool:
    return any(isinstance(part, dict | list) for part in value)


def _matrix(value: list[Any]) -> NDArray[Any]:
    """Rows of equal length as a matrix; anything else as it stands."""
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        return np.array([None, *value], dtype=object)[1:]


def _array(value: Any) -> NDArray[Any]:
    """Numbers, with NaN where there is none, or texts."""
    parts = value if isinstance(value, list) else [value]
    kinds = {type(part) for part in parts}
    if kinds and kinds <= {int, bool} and all(-(2**63) <= part < 2**63 for part in parts):
        return np.array(parts, dtype=np.int64)
    if kinds and kinds <= {int, float, bool, type(None)}:
        return np.array([np.nan if part is None else float(part) for part in parts])
    return np.array(["" if part is None else str(part) for part in parts], dtype=object)


def _first(array: NDArray[Any]) -> str:
    return str(array[0]).strip() if array.dtype.kind == "O" and array.size else ""
