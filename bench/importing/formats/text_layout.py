"""How a text file is laid out: separator, decimal mark, headings, units, and where its data begin."""

from __future__ import annotations

import csv
import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from bench.importing.formats.text_stamps import is_stamp
from bench.importing.headings import split_heading
from bench.importing.units import is_unit

_SAMPLE = 200
_STEADY = 4
_HEADINGS = 3
_LEAST_NAMES = 2
"""names that a line with one name less than there are columns has to have: a single word may be a title"""
_FEW_LINES, _MANY_FIELDS = 64, 50
_MISSING = frozenset(("", "nan", "na", "n/a", "null", "none", "-", "--", "inf", "-inf"))
_SEPARATORS = (";", "\t", ",", "|", None)
csv.field_size_limit(2**31 - 1)  # a line of a whole recording may be one field of a separator that is not its own
_NUMBERS = {mark: re.compile(rf"[+-]?(\d+({mark}\d*)?|{mark}\d+)([eEdD][+-]?\d+)?") for mark in (r"\.", ",")}


@dataclass(frozen=True, slots=True)
class TextOptions:
    """What a mapping says of a text file; None: found from the file.

    ``comment`` begins a line of remarks; ``skip_lines`` are passed over before anything is looked at; ``data_in`` is
    ``columns`` or ``rows``; ``encoding`` as Python names it.
    """

    delimiter: str | None = None
    decimal: str | None = None
    comment: str = "#"
    skip_lines: int = 0
    data_in: str | None = None
    encoding: str | None = None


@dataclass(frozen=True, slots=True)
class TextLayout:
    """What was found. ``delimiter`` None is any white space; ``first`` counts the lines given; ``rows``: a variable a
    line; ``one_less``: the headings name all columns but the last.
    """

    delimiter: str | None
    decimal: str
    first: int
    width: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    rows: bool = False
    one_less: bool = False


def split(line: str, delimiter: str | None) -> list[str]:
    """Split a line into fields without the space around them."""
    if delimiter is None:
        return line.split()
    return [field.strip() for field in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]


def is_number(field: str, decimal: str) -> bool:
    """Whether a field is a number, written with this decimal mark."""
    return _NUMBERS[r"\." if decimal == "." else ","].fullmatch(field) is not None


def find_layout(lines: Sequence[str], remarks: Sequence[str], options: TextOptions) -> TextLayout | None:
    """Find the layout of a file from its lines (without empty ones and ``remarks``); None where nothing is a table."""
    middle = min(len(lines) // 2, max(len(lines) - _SAMPLE, 0))
    sample = lines[middle : middle + _SAMPLE]
    separators = _SEPARATORS if options.delimiter is None else (_separator(options.delimiter),)
    marks = (".", ",") if options.decimal is None else (options.decimal,)
    best: tuple[tuple[float, bool, int], str | None, str, int] | None = None
    for delimiter in separators:
        for mark in marks:
            if delimiter == mark:
                continue
            rating = _rate_separator(lines, sample, delimiter, mark)
            if rating is not None and (best is None or rating[0] > best[0]):
                best = (rating[0], delimiter, mark, rating[1])
    if best is None:
        return None
    _, delimiter, mark, width = best
    first = _first_data_line(lines, delimiter, mark, width)
    few = len(lines) - first <= _FEW_LINES and width >= _MANY_FIELDS and width > 3 * (len(lines) - first)
    names, units = _headings(lines[:first], remarks, delimiter, mark, width)
    one_less = not names and width > _LEAST_NAMES and _first_is_named(lines[first:][:_SAMPLE], delimiter, mark)
    if one_less:
        fitting = [line for line in remarks[-1:] if delimiter and len(split(line, delimiter)) == width - 1]
        names, units = _headings(lines[:first], fitting, delimiter, mark, width - 1)
        names, units = (*names, f"column {width}") if names else (), (*units, "")
    # where each column has a heading few lines are a short recording of many variables
    if options.data_in == "rows" or (options.data_in is None and few and not names):
        return _in_rows(lines[first:], delimiter, mark, first, width)
    return TextLayout(delimiter, mark, first, width, names, units, one_less=one_less and bool(names))


def _separator(delimiter: str) -> str | None:
    """The separator a mapping gives; a space is any white space."""
    return {" ": None, "\\t": "\t", "tab": "\t"}.get(delimiter, delimiter)


def _rate_separator(
    lines: Sequence[str], sample: Sequence[str], delimiter: str | None, mark: str
) -> tuple[tuple[float, bool, int], int] | None:
    """Rate a separator: share of fields that are data, whether the headings have as many, number of columns."""
    fields = [split(line, delimiter) for line in sample]
    widths = Counter(len(row) for row in fields)
    width, often = max(widths.items(), key=lambda item: (item[1], item[0]))
    every = [field for row in fields for field in row]
    numbers = sum(is_number(field, mark) for field in every)
    good = numbers + sum(field.lower() in _MISSING or is_stamp(field) for field in every)
    if not numbers or not width:
        return None
    first = _first_data_line(lines, delimiter, mark, width)
    agrees = first == 0 or len(split(lines[first - 1], delimiter)) >= min(width, max(width - 1, _LEAST_NAMES))
    return (round(good / len(every) * often / len(sample), 3), agrees, width), width


def _first_data_line(lines: Sequence[str], delimiter: str | None, mark: str, width: int) -> int:
    """Index of the first line of data: it and the next few look like data."""
    looks = partial(_is_data, delimiter=delimiter, mark=mark, width=width)
    return next(
        (
            index
            for index in range(len(lines))
            if len(split(lines[index], delimiter)) == width
            and all(looks(line) for line in lines[index : index + _STEADY])
        ),
        0,
    )


def _is_data(line: str, *, delimiter: str | None, mark: str, width: int) -> bool:
    fields = split(line, delimiter)
    numbers = sum(is_number(field, mark) for field in fields)
    good = numbers + sum(field.lower() in _MISSING or is_stamp(field) for field in fields)
    return numbers > 0 and len(fields) <= width and 2 * good >= max(len(fields), 1)


def _headings(
    above: Sequence[str], remarks: Sequence[str], delimiter: str | None, mark: str, width: int
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names and units of the columns from the lines above the data, or from the last remark."""
    block: list[list[str]] = []
    for line in reversed(above[-_HEADINGS:]):
        fields = split(line, delimiter)
        if len(fields) < width or any(is_number(field, mark) for field in fields):
            break
        block.insert(0, fields[:width])
    if not block and remarks:
        fields = split(remarks[-1], delimiter)
        fields = fields if len(fields) == width else split(remarks[-1], None)
        block = [fields] if len(fields) == width and not any(is_number(field, mark) for field in fields) else []
    if not block:
        return (), ("",) * width
    units = [""] * width
    if len(block) > 1 and _all_units(block[-1]):
        units = [field.strip("[]() ") for field in block.pop()]
    heading = block[-1]
    if len(block) > 1 and len(set(heading)) < width:  # X and Y of each quantity, whose name stands above
        heading = [f"{over} {name}".strip() for over, name in zip(_filled(block[-2]), heading, strict=True)]
    names = _distinct_names(heading)
    return names, tuple(unit or split_heading(name)[1] for name, unit in zip(names, units, strict=True))


def _first_is_named(data: Sequence[str], delimiter: str | None, mark: str) -> bool:
    """Whether of headings with one name less than there are columns the first belongs to the first column.

    The column without a name may be the first as well: row numbers or labels, or a date before a time of day.
    """
    fields = [split(line, delimiter) for line in data]
    first, last = [row[0] for row in fields], [row[-1] for row in fields]
    numbers = all(is_number(field, mark) for field in first)
    row_numbers = all(map(str.isdecimal, first)) and all(int(b) - int(a) == 1 for a, b in itertools.pairwise(first))
    if len(set(last)) == 1:  # an empty field after a delimiter, or a 0 that a program wrote in every line
        return numbers or delimiter is not None
    return numbers and not row_numbers


def _filled(fields: Sequence[str]) -> list[str]:
    """Headings that stand over several columns, over each of them."""
    out: list[str] = []
    for field in fields:
        out.append(field or (out[-1] if out else ""))
    return out


def _all_units(fields: Sequence[str]) -> bool:
    filled = [field for field in fields if field]
    fits = sum(is_unit(field.strip("[]() ")) or (field[0] in "[(" and field[-1] in ")]") for field in filled)
    return bool(filled) and 2 * fits > len(filled)


def _distinct_names(names: Sequence[str]) -> tuple[str, ...]:
    seen: Counter[str] = Counter()
    out = []
    for index, name in enumerate(names):
        heading = name or f"column {index + 1}"
        seen[heading] += 1
        out.append(heading if seen[heading] == 1 else f"{heading}_{seen[heading]}")
    return tuple(out)


def _in_rows(lines: Sequence[str], delimiter: str | None, mark: str, first: int, width: int) -> TextLayout:
    """A variable a line: its name stands before the numbers, and its unit perhaps between."""
    fields = [split(line, delimiter) for line in lines]
    named = all(not is_number(row[0], mark) for row in fields)
    names = _distinct_names([row[0] if named else f"row {index + 1}" for index, row in enumerate(fields)])
    second = named and all(len(row) > 1 and not is_number(row[1], mark) for row in fields)
    units = [
        row[1].strip("[]() ") if second else split_heading(name)[1] for row, name in zip(fields, names, strict=True)
    ]
    return TextLayout(delimiter, mark, first, width, names, tuple(units), rows=True)
