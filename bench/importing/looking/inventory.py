"""Everything a file holds, read once: names, shapes, units, ranges, rates, and a picture of a line each."""

from __future__ import annotations

import glob
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats import Source, Variable, open_source
from bench.importing.formats.text_layout import TextOptions
from bench.importing.looking.words import quantity_of

_MOST_COLUMNS = 40
_BLOCKS = "▁▂▃▄▅▆▇█"
PICTURE_WIDTH = 24
NAMELESS = "column "
"""begins the name of a column of a text file that has none"""


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """One line of numbers or of time stamps (N,) in a file, and how a mapping names it.

    ``number`` counts columns or rows (``along`` says which) of a matrix from 1; ``numeric`` is False for stamps;
    ``file``: its name, where each file holds one quantity.
    """

    variable: Variable
    values: NDArray[Any]
    number: int | None = None
    along: str = "column"
    file: str = ""

    @property
    def name(self) -> str:
        """Its name, with the number of its column or row."""
        return self.variable.name if self.number is None else f"{self.variable.name} {self.along} {self.number}"

    @property
    def stamps(self) -> bool:
        """Whether it holds dates."""
        return self.values.dtype.kind == "M"

    @property
    def seconds(self) -> NDArray[np.float64]:
        """Values as numbers; dates as seconds since the first."""
        if self.stamps:
            return np.asarray((self.values - self.values[0]) / np.timedelta64(1, "ns"), dtype=np.float64) * 1e-9
        return np.asarray(self.values, dtype=np.float64)

    @property
    def span(self) -> tuple[float, float]:
        """Smallest and largest value; NaN where there is none."""
        numbers = self.seconds[np.isfinite(self.seconds)]
        return (float(numbers.min()), float(numbers.max())) if numbers.size else (float("nan"), float("nan"))

    @property
    def empty(self) -> bool:
        """Whether it holds no number at all: a delimiter at the end of each line makes such columns."""
        return not self.stamps and math.isnan(self.span[0])

    @property
    def missing(self) -> NDArray[np.int64]:
        """Indices of samples that are no number: NaN, inf, or a stamp that is not there."""
        lost = np.isnat(self.values) if self.stamps else ~np.isfinite(self.seconds)
        return np.asarray(np.flatnonzero(lost), dtype=np.int64)

    @property
    def whole(self) -> bool:
        """Whether all its numbers are whole ones, as an encoder's counts are."""
        numbers = self.seconds[np.isfinite(self.seconds)]
        return not self.stamps and numbers.size > 0 and bool(np.all(numbers == np.round(numbers)))

    @property
    def constant(self) -> bool:
        """Whether all its numbers are the same: nothing was measured there."""
        return self.span[0] == self.span[1]


@dataclass(frozen=True, slots=True)
class Inventory:
    """A file and what it holds: ``columns`` of samples, ``constants`` of one number, ``others`` that are neither.

    ``pattern`` is what was asked for, where several files fit it.
    """

    file: Path
    pattern: str
    source: Source
    columns: tuple[Column, ...]
    constants: dict[str, float]
    others: tuple[tuple[Variable, str], ...]

    def location(self, column: Column, index: int) -> str:
        """Say where sample ``index`` (from 0) of a column stands."""
        # the source is the first of several files
        return f"index {index} of {column.file}" if column.file else self.source.location(index)

    def missing_samples(self) -> list[str]:
        """A sentence for each column, empty ones apart, in which samples are no number: how many, and the first."""
        return [
            f"{column.name}: {lost.size} of {column.values.size} samples {'is' if lost.size == 1 else 'are'} no number "
            f"(NaN, inf or empty), the first in {self.location(column, int(lost[0]))}"
            for column in self.columns
            if not column.empty
            for lost in [column.missing]
            if lost.size
        ]


def take_inventory(file: str | Path, options: TextOptions | None = None) -> Inventory:
    """Read a file; of a pattern such as ``run*.csv`` the first that fits.

    Raises
    ------
    RecordingError
        There is no such file, it cannot be read, or holds no samples.
    """
    pattern, path = str(file), Path(file)
    if any(mark in pattern for mark in "*?[") and not path.exists():
        fitting = sorted(glob.glob(pattern))
        if not fitting:
            raise RecordingError(f"{pattern}: no file fits this pattern, it should name at least one.")
        path = Path(fitting[0])
        alone = _a_file_each([Path(file) for file in fitting], options)
        if alone:
            return Inventory(path, str(path), open_source(path, options), alone, {}, ())
    source = open_source(path, options)
    columns: list[Column] = []
    constants: dict[str, float] = {}
    others: list[tuple[Variable, str]] = []
    for variable in source.variables():
        try:
            if _lines(variable) is None:
                others.append((variable, f"{len(variable.shape)} dimensions"))
            elif int(np.prod(variable.shape)) == 1:
                constants[variable.name] = float(source.read(variable.name)[0])
            else:
                columns += _columns(source, variable)
        except RecordingError as error:
            others.append((variable, str(error)))
    if not columns:
        why = next((reason for variable, reason in others if not variable.shape), None)
        raise RecordingError(why or f"{path}: holds no variable with more than one number, there should be samples.")
    return Inventory(path, pattern, source, tuple(columns), constants, tuple(others))


def _a_file_each(files: Sequence[Path], options: TextOptions | None) -> tuple[Column, ...]:
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
            columns.append(Column(named, source.read(variable.name), number, file=path.name))
    quantities = {quantity_of(path.stem.lower()) for path in files} - {""}
    if len(widths) != 1 or len({column.values.size for column in columns}) != 1:
        return ()
    return tuple(columns) if widths == {1} or len(quantities) > 1 else ()


def _lines(variable: Variable) -> int | None:
    """How many lines of samples a variable has; None where it is no matrix of few."""
    sides = [side for side in variable.shape if side != 1]
    if len(sides) <= 1:
        return 1
    return min(sides) if len(variable.shape) == 2 and min(sides) <= _MOST_COLUMNS else None


def _columns(source: Source, variable: Variable) -> list[Column]:
    count = _lines(variable) or 1
    if count == 1:
        return [Column(variable, source.read(variable.name))]
    if variable.shape[0] >= variable.shape[1]:
        return [Column(variable, source.read(variable.name, column=k), k) for k in range(1, count + 1)]
    return [Column(variable, source.read(variable.name, row=k), k, "row") for k in range(1, count + 1)]


def picture(values: NDArray[np.float64], width: int = PICTURE_WIDTH) -> str:
    """Draw values as a line of blocks, each the mean of its share; empty where nothing is finite."""
    numbers = values[np.isfinite(values)]
    if not numbers.size:
        return ""
    edges = np.linspace(0, numbers.size, min(width, numbers.size) + 1).astype(np.int64)
    means = np.add.reduceat(numbers, edges[:-1]) / np.diff(edges)
    low, high = float(means.min()), float(means.max())
    share = (means - low) / (high - low) if high > low else np.full(means.size, 0.0)
    return "".join(_BLOCKS[round(part * (len(_BLOCKS) - 1))] for part in share)
