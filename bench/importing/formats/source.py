"""What every kind of file looks like from here: a list of variables, each read when it is asked for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.importing.headings import split_heading
from bench.importing.units import split_unit

_LISTED = 30


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of a file, as the file describes it.

    ``shape`` as the mapping counts rows and columns; ``unit`` empty and ``rate`` (Hz) None where the file says none;
    ``clock`` names the variable that holds its time stamps, where the file says so; ``zoned``: it holds stamps
    that say their time zone, and are read as UTC; ``flat``: its name is the heading of a column, and a ``/`` in it
    divides no groups.
    """

    name: str
    shape: tuple[int, ...]
    dtype: str
    unit: str = ""
    rate: float | None = None
    clock: str | None = None
    zoned: bool = False
    flat: bool = False

    @property
    def heading(self) -> tuple[str, str]:
        """Its name without a unit, and the unit that its name has; empty where it has none."""
        return split_heading(self.name) if self.flat else split_unit(self.name)


class Source(Protocol):
    """A file of variables."""

    def variables(self) -> list[Variable]:
        """Say what is in the file."""

    def read(self, variable: str | None, column: int | None = None, row: int | None = None) -> NDArray[Any]:
        """Read a variable as a one-dimensional array of numbers or of time stamps (``datetime64``).

        ``column`` and ``row`` count from 1; an array of two dimensions needs one of them.

        Raises
        ------
        RecordingError
            There is no such variable, row or column, or it holds neither numbers nor stamps.
        """

    def location(self, index: int) -> str:
        """Say where sample ``index`` (from 0) stands in the file."""

    @property
    def started_at(self) -> datetime | None:
        """When the file says that it begins."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What was taken for granted in reading it, one sentence each."""


def at_index(index: int) -> str:
    """Name a sample by its index, where a file knows nothing better."""
    return f"index {index}"


def one_dimensional(values: Any, column: int | None, row: int | None, where: str) -> NDArray[Any]:
    """Make a one-dimensional array of numbers or stamps of a variable (``where`` names file and variable).

    Raises
    ------
    RecordingError
        It is neither, or is a matrix of which neither row nor column was asked for, or not of those there are.
    """
    array = np.asarray(values)
    if array.dtype.kind == "b":
        array = array.astype(np.uint8)
    if array.dtype.kind not in "iufM":
        raise RecordingError(f"{where} is {_kind(array)}, it should be numeric.")
    if array.ndim == 2 and (column is not None or row is not None):
        axis, number, word = (1, column, "column") if column is not None else (0, row, "row")
        assert number is not None
        if number > array.shape[axis]:
            raise RecordingError(f"{where} has {array.shape[axis]} {word}s, {word} {number} was asked for.")
        return np.asarray(np.take(array, number - 1, axis=axis))
    if array.ndim > 1 and array.size != max(array.shape):
        shape = " x ".join(map(str, array.shape))
        raise RecordingError(
            f"{where} is a {shape} matrix, 'column' (or 'row', where data lie in rows) should say which."
        )
    return array.reshape(-1)


def _kind(array: NDArray[Any]) -> str:
    return {"U": "text", "S": "text", "O": "text or a mixture", "c": "complex"}.get(array.dtype.kind, str(array.dtype))


def unknown_variable(path: Path, variable: str | None, names: Iterable[str]) -> RecordingError:
    """Say that there is no such variable, and which there are; the likely one first."""
    listed = list(names)
    near = get_close_matches(variable or "", listed, 1)
    meant = f" (did you mean '{near[0]}'?)" if near else ""
    more = f" and {len(listed) - _LISTED} more" if len(listed) > _LISTED else ""
    return RecordingError(
        f"{path}: there is no variable '{variable}'; the file has {', '.join(listed[:_LISTED])}{more}{meant}."
    )


def missing_package(path: Path, what: str, package: str, extra: str) -> RecordingError:
    """Say which optional package reads this kind of file."""
    return RecordingError(
        f"{path}: {what} files need the package {package}, install the project with the extra '{extra}'."
    )
