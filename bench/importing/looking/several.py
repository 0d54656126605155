"""Files that are one recording together: each holds one quantity, or one channel beside the time."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.errors import RecordingError
from bench.importing.formats import Variable, open_source
from bench.importing.formats.text_layout import TextOptions
from bench.importing.looking.column import NAMELESS, Column, columns_of, lines_of
from bench.importing.looking.words import quantity_of


def a_file_each(files: Sequence[Path], options: TextOptions | None) -> tuple[Column, ...]:
    """The columns of several files that hold one quantity each and no names, all as long; none where they are others.

    The name of the file is the name of what stands in it. Files of several columns, of one for each joint, say, may as
    well be runs of one machine: they are taken so only where their names are of different quantities.
    """
    columns: list[Column] = []
    widths: set[int] = set()
    for path in files if len(files) > 1 else ():
        source = open_source(path, options)
        held = source.variables()
        if not held or not all(variable.name.startswith(NAMELESS) for variable in held):
            return ()
        widths.add(len(held))
        for k, variable in enumerate(held, 1):
            number = k if len(held) > 1 else None
            named = replace(variable, name=path.stem)
            columns.append(Column(named, source.read(variable.name), number, file=path.name, headed=False))
    quantities = {quantity_of(path.stem.lower()) for path in files} - {""}
    if len(widths) != 1 or len({column.values.size for column in columns}) != 1:
        return ()
    return tuple(columns) if widths == {1} or len(quantities) > 1 else ()


def a_file_for_each_channel(
    files: Sequence[Path], options: TextOptions | None
) -> tuple[tuple[Column, ...], tuple[tuple[Variable, str], ...]]:
    """The columns of files that hold the time and channels of their own, and the variables that cannot be read with the
    reason; nothing where the files are runs of one machine.

    Of runs the columns are called alike. The first two files say whether they are, so that many runs are not all
    opened. A file whose time is not that of the first keeps it, as the clock of its channels.
    """
    if len(files) < 2 or not _differ([open_source(path, options).variables() for path in files[:2]]):
        return (), ()
    sources = {path: open_source(path, options) for path in files}
    held = {path: source.variables() for path, source in sources.items()}
    counts = Counter(variable.name for variables in held.values() for variable in variables)
    clocks = [name for name, count in counts.items() if count == len(files)]
    # a column in some of the files: they are of several recordings
    in_one = all(sum(counts[own.name] == 1 for own in variables) == len(variables) - 1 for variables in held.values())
    if len(clocks) != 1 or not in_one or not all(_line(own) for variables in held.values() for own in variables):
        return (), ()
    clock = clocks[0]
    first = sources[files[0]].read(clock)
    columns: list[Column] = []
    others: list[tuple[Variable, str]] = []
    for path, source in sources.items():
        stamps = source.read(clock)
        alike = stamps.shape == first.shape and stamps.dtype.kind == first.dtype.kind and np.array_equal(stamps, first)
        for variable in held[path]:
            if variable.name == clock and path != files[0]:
                continue
            own = variable if alike or variable.name == clock else replace(variable, clock=clock)
            try:
                columns.append(Column(own, source.read(variable.name), file="" if path == files[0] else path.name))
            except RecordingError as error:
                others.append((variable, str(error)))
    return tuple(columns), tuple(others)


def a_matrix_each(files: Sequence[Path], options: TextOptions | None) -> tuple[Column, ...]:
    """The columns of files that hold the same columns (or one matrix, called alike), each of another quantity, which
    the name of the file says and theirs do not: a column for each joint, say. None where they are other files.

    A column that is the same in all files, as a clock is, is shown once.
    """
    if len(files) < 2 or not _of_different_quantities([path.stem for path in files]):
        return ()
    sources = {path: open_source(path, options) for path in files}
    held = [source.variables() for source in sources.values()]
    names = [[variable.name for variable in variables] for variables in held]
    if any(other != names[0] for other in names) or any(name.startswith(NAMELESS) for name in names[0]):
        return ()
    said = {quantity_of(name.lower()) for name in names[0]}
    if said - {"", "time", "number"} or not all(lines_of(own) and np.prod(own.shape) > 1 for own in held[0]):
        return ()
    first: list[Column] = []
    columns: list[Column] = []
    for path, source in sources.items():
        try:
            own = [column for variable in source.variables() for column in columns_of(source, variable)]
        except RecordingError:
            return ()
        first = first or own
        if len(own) != len(first) or {column.values.size for column in own} != {first[0].values.size}:
            return ()
        for column, alike in zip(own, first, strict=True):
            if path == files[0]:
                columns.append(_titled(column, path, ""))
            elif not np.array_equal(column.values, alike.values):
                columns.append(_titled(column, path, path.name))
    return tuple(columns)


def _titled(column: Column, path: Path, file: str) -> Column:
    """A column with the name of its file before its own, but for a clock."""
    inside = column.variable.name
    if quantity_of(inside.lower()) == "time":
        return replace(column, file=file)
    named = f"{path.stem} {inside}" if column.number is None else path.stem
    return replace(column, variable=replace(column.variable, name=named), file=file, inside=inside)


def _of_different_quantities(stems: Sequence[str]) -> bool:
    """Whether the names of files are of a quantity each and of no two the same; one of them may be of none known, as a
    ``joint`` beside a ``torque``, where the names differ in one word.
    """
    quantities = [quantity_of(stem.lower()) for stem in stems]
    if len(set(quantities)) < len(quantities):
        return False
    words = [re.split(r"[_\- .]", stem) for stem in stems]
    alike = len({len(split) for split in words}) == 1
    return "" not in quantities or (alike and sum(len(set(place)) > 1 for place in zip(*words, strict=True)) == 1)


def _differ(held: Sequence[Sequence[Variable]]) -> bool:
    """Whether each of two files has a column with a heading that the other lacks."""
    one, other = ({variable.name for variable in variables} for variables in held)
    headed = not any(name.startswith(NAMELESS) for name in one | other)
    return headed and bool(one - other) and bool(other - one)


def _line(variable: Variable) -> bool:
    """Whether a variable is one line of several samples."""
    return len(variable.shape) == 1 and variable.shape[0] > 1
