"""Everything a file holds, read once: names, shapes, units, ranges, rates, and a picture of a line each."""

from __future__ import annotations

import glob
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.formats import Source, Variable, open_source
from bench.importing.formats.text_layout import TextOptions
from bench.importing.looking.column import Column, columns_of, lines_of
from bench.importing.looking.several import a_file_each, a_file_for_each_channel, a_matrix_each

_BLOCKS = "▁▂▃▄▅▆▇█"
PICTURE_WIDTH = 24


@dataclass(frozen=True, slots=True)
class Inventory:
    """A file and what it holds: ``columns`` of samples, ``constants`` of one number, ``others`` that are neither.

    ``pattern`` is what was asked for, where several files fit it; ``unseen`` are the files that fit and were not shown.
    """

    file: Path
    pattern: str
    source: Source
    columns: tuple[Column, ...]
    constants: dict[str, float]
    others: tuple[tuple[Variable, str], ...]
    unseen: tuple[str, ...] = ()

    @property
    def several(self) -> bool:
        """Whether its columns are of several files that are one recording."""
        return any(column.file for column in self.columns)

    def unlike(self) -> str | None:
        """Name of the next file that fits the pattern, where its variables are not called like this file's."""
        if not self.unseen:
            return None
        other = Path(self.unseen[0])
        names = [{variable.name for variable in source.variables()} for source in (self.source, open_source(other))]
        return None if names[0] == names[1] else other.name

    def location(self, column: Column, index: int) -> str:
        """Say where sample ``index`` (from 0) of a column stands."""
        # the source is the first of several files
        return f"index {index} of {column.file}" if column.file else self.source.location(index)

    def missing_samples(self) -> list[str]:
        """A sentence for each column, empty ones apart, in which samples are no number: how many, and the first."""
        return [
            f"{column.name}: {lost.size} of {column.values.size} samples {'is' if lost.size == 1 else 'are'} no number "
            f"(NaN, inf, empty or a fill value), the first in {self.location(column, int(lost[0]))}"
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
    unseen: tuple[str, ...] = ()
    if any(mark in pattern for mark in "*?[") and not path.exists():
        fitting = sorted(glob.glob(pattern))
        if not fitting:
            raise RecordingError(f"{pattern}: no file fits this pattern, it should name at least one.")
        path = Path(fitting[0])
        files = [Path(file) for file in fitting]
        alone = a_file_each(files, options) or a_matrix_each(files, options)
        together = (alone, ()) if alone else a_file_for_each_channel(files, options)
        if together[0]:
            return Inventory(path, str(path), open_source(path, options), together[0], {}, together[1])
        unseen = tuple(fitting[1:])
    source = open_source(path, options)
    columns: list[Column] = []
    constants: dict[str, float] = {}
    others: list[tuple[Variable, str]] = []
    for variable in source.variables():
        try:
            if lines_of(variable) is None:
                others.append((variable, f"{len(variable.shape)} dimensions"))
            elif int(np.prod(variable.shape)) == 1:
                constants[variable.name] = float(source.read(variable.name)[0])
            else:
                columns += columns_of(source, variable)
        except RecordingError as error:
            others.append((variable, str(error)))
    if not columns:
        why = next((reason for variable, reason in others if not variable.shape), None)
        raise RecordingError(why or f"{path}: holds no variable with more than one number, there should be samples.")
    return Inventory(path, pattern, source, tuple(columns), constants, tuple(others), unseen)


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
