"""One line of numbers or stamps in a file, as the first look sees it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.importing.fill import filled
from bench.importing.formats import Source, Variable

NAMELESS = "column "
"""begins the name of a column of a text file that has none"""
_MOST_COLUMNS = 40
"""lines of a matrix up to which each is shown as a column"""


@dataclass(frozen=True, slots=True, eq=False)
class Column:
    """One line of numbers or of time stamps (N,) in a file, and how a mapping names it.

    ``number`` counts columns or rows (``along`` says which) of a matrix from 1; ``numeric`` is False for stamps;
    ``file``: its name, where a recording has several; ``headed`` is False where the column's name is its file's.
    ``inside`` is the variable's name in its file, where its name here has that of the file before it.
    """

    variable: Variable
    values: NDArray[Any]
    number: int | None = None
    along: str = "column"
    file: str = ""
    headed: bool = True
    inside: str = ""

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
        """Values as numbers, NaN for fill values; dates as seconds since the first."""
        if self.stamps:
            return np.asarray((self.values - self.values[0]) / np.timedelta64(1, "ns"), dtype=np.float64) * 1e-9
        return np.where(filled(self.values), np.nan, np.asarray(self.values, dtype=np.float64))

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
        """Indices of samples that are no number: NaN, inf, a fill value, or a stamp that is not there."""
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


def lines_of(variable: Variable) -> int | None:
    """How many lines of samples a variable has; None where it is no matrix of few."""
    sides = [side for side in variable.shape if side != 1]
    if len(sides) <= 1:
        return 1
    return min(sides) if len(variable.shape) == 2 and min(sides) <= _MOST_COLUMNS else None


def columns_of(source: Source, variable: Variable) -> list[Column]:
    """The lines of a variable that has some, along its longer side."""
    count = lines_of(variable) or 1
    if count == 1:
        return [Column(variable, source.read(variable.name))]
    if variable.shape[0] >= variable.shape[1]:
        return [Column(variable, source.read(variable.name, column=k), k) for k in range(1, count + 1)]
    return [Column(variable, source.read(variable.name, row=k), k, "row") for k in range(1, count + 1)]
