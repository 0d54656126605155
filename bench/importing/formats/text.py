"""Text tables of any separator: CSV, tab separated, columns of white space, loggers' files with a preamble."""

from __future__ import annotations

import io
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats.source import Variable, one_dimensional, unknown_variable
from bench.importing.formats.text_layout import TextOptions, find_layout, is_number, split
from bench.importing.formats.text_stamps import has_zone, is_stamp, is_time_of_day, parse_stamps, seconds_of_day

_ENCODINGS = ("utf-8-sig", "cp1252")
_SHOWN = 60
"""marks of a line that a message repeats"""
_UTF16 = (b"\xff\xfe", b"\xfe\xff")


class TextSource:
    """A text table. Columns are named by their headings, or ``column 1``, ``column 2``, …; lines count from 1."""

    started_at: datetime | None = None

    def __init__(self, path: Path, options: TextOptions) -> None:
        self._path = path
        numbered = [
            (number, line)
            for number, line in enumerate(_text(path, options).splitlines(), 1)
            if number > options.skip_lines and line.strip()
        ]
        if any("\0" in line for _, line in numbered[:20]):
            raise RecordingError(f"{path}: is not readable as text (it holds binary data).")
        remark = options.comment
        kept = [(n, line) for n, line in numbered if not (remark and line.lstrip().startswith(remark))]
        first_kept = kept[0][0] if kept else 0
        remarks = [line.lstrip()[len(remark) :] for n, line in numbered if n < first_kept]
        if not kept:
            raise RecordingError(f"{path}: holds no line of data.")
        layout = find_layout([line for _, line in kept], remarks, options)
        if layout is None:
            raise RecordingError(
                f"{path}: holds no table of numbers in columns with one separator; where it does, [csv] delimiter, "
                "decimal and skip_lines should say how."
            )
        self.layout = layout
        data = kept[layout.first :]
        self._numbers = [number for number, _ in data]
        self._columns = self._transposed(data) if layout.rows else self._table(data)
        self.notes = (
            (
                f"the headings name {layout.width - 1} of {layout.width} columns: they are taken for the first "
                f"{layout.width - 1}, the last one is '{layout.names[-1]}'",
            )
            if layout.one_less
            else ()
        )
        self._names = layout.names or tuple(f"column {index + 1}" for index in range(layout.width))

    def variables(self) -> list[Variable]:
        """Name the columns that hold anything."""
        found = []
        for name, unit, values in zip(self._names, self.layout.units, self._columns, strict=True):
            if values.size and not (
                values.dtype.kind == "f" and not layout_named(self.layout.names) and _empty(values)
            ):
                first = str(values[0]).strip() if values.dtype.kind == "O" else ""
                kind = "time stamps" if is_stamp(first) else "text" if first else str(values.dtype)
                unit = "s" if is_time_of_day(first) else unit
                found.append(Variable(name, (values.size,), kind, unit, zoned=has_zone(first), flat=True))
        return found

    def read(self, variable: str | None, column: int | None = None, row: int | None = None) -> NDArray[Any]:
        """Read a column by heading, or by number."""
        number = column if column is not None else row
        if variable is not None:
            if variable not in self._names:
                raise unknown_variable(self._path, variable, self._names)
            number = self._names.index(variable) + 1
        if number is None or number > len(self._names):
            what = "rows" if self.layout.rows else "columns"
            raise RecordingError(f"{self._path}: has {len(self._names)} {what}, {what[:-1]} {number} was asked for.")
        values, where = self._columns[number - 1], f"{self._path}: {self._names[number - 1]}"
        if values.dtype.kind != "O":
            return one_dimensional(values, None, None, where)
        first = str(values[0]).strip()
        if is_time_of_day(first):
            return seconds_of_day(values.tolist(), where)
        if is_stamp(first):
            return parse_stamps(values.tolist(), where)
        wrong = next(i for i, text in enumerate(values) if not is_number(str(text).strip(), self.layout.decimal))
        raise RecordingError(f"{where} is not numeric: '{values[wrong]}' stands in {self.location(wrong)}.")

    def location(self, index: int) -> str:
        """Name the line of a sample."""
        if self.layout.rows or index >= len(self._numbers):
            return f"index {index}"
        return f"line {self._numbers[index]}"

    def _table(self, data: list[tuple[int, str]]) -> list[NDArray[Any]]:
        import pandas

        layout = self.layout
        if layout.delimiter == "," and layout.decimal == ",":
            raise RecordingError(f"{self._path}: [csv] delimiter and decimal are both ',', they should differ.")
        try:
            frame = pandas.read_csv(
                io.StringIO("\n".join(line for _, line in data)),
                header=None,
                names=list(range(layout.width)),
                index_col=False,
                sep=r"\s+" if layout.delimiter is None else layout.delimiter,
                decimal=layout.decimal,
                skipinitialspace=True,
                skip_blank_lines=False,
                na_values=["-", "--"],
                low_memory=False,
            )
        except (ValueError, pandas.errors.ParserError) as error:
            raise RecordingError(f"{self._path}: {self._wider(data) or _first_line(error)}.") from error
        return [_plain(frame[index]) for index in frame.columns]

    def _wider(self, data: list[tuple[int, str]]) -> str:
        """Name the first line that has more columns than the table, what stands there, and what would pass over it;
        empty where there is none.
        """
        width = self.layout.width
        for number, text in data:
            fields = split(text, self.layout.delimiter)
            if len(fields) > width:
                shown = text.strip() if len(text.strip()) <= _SHOWN else f"{text.strip()[:_SHOWN]}…"
                word = "" if is_number(fields[0], self.layout.decimal) else fields[0].split()[0]
                right = f"; [csv] comment = '{word}' passes over lines that begin so" if word else ""
                return (
                    f"is not a table of {width} columns: line {number} has {len(fields)} of them ('{shown}'), it should"
                    f" have {width}{right}"
                )
        return ""

    def _transposed(self, data: list[tuple[int, str]]) -> list[NDArray[Any]]:
        columns = []
        for number, line in data:
            fields = split(line, self.layout.delimiter)
            start = next((i for i, field in enumerate(fields) if is_number(field, self.layout.decimal)), 0)
            texts = [field.replace(self.layout.decimal, ".") for field in fields[start:]]
            try:
                columns.append(np.array([float(text) if text else np.nan for text in texts]))
            except ValueError as error:
                raise RecordingError(f"{self._path}: line {number} is not numeric ({error}).") from error
        return columns


def _first_line(error: Exception) -> str:
    """An error of the parser in one line."""
    return f"is not a table of numbers ({' '.join(str(error).split())})"


def layout_named(names: tuple[str, ...]) -> bool:
    """Whether the columns have headings."""
    return bool(names)


def _empty(values: NDArray[Any]) -> bool:
    return bool(np.isnan(values).all())


def _plain(series: Any) -> NDArray[Any]:
    """A column as integers, floats or texts (of which a missing one is empty)."""
    if series.dtype.kind in "iufb":
        return np.asarray(series.to_numpy())
    return np.asarray(series.astype(object).where(series.notna(), "").to_numpy(), dtype=object)


def _text(path: Path, options: TextOptions) -> str:
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror}).") from error
    encodings = (options.encoding,) if options.encoding else ("utf-16",) if raw.startswith(_UTF16) else _ENCODINGS
    for encoding in encodings:
        try:
            return raw.decode(encoding)
        except (UnicodeDecodeError, LookupError):
            continue
    raise RecordingError(
        f"{path}: is not readable as text in {' or '.join(encodings)}; [csv] encoding should say which."
    )
