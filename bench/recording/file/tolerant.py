"""Attributes, groups and small tables of a file, read as far as they can be: what cannot is a problem, no error."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np
from numpy.typing import NDArray

from bench.recording.file import attributes
from bench.recording.file.attributes import AttributeMissing, AttributeProblem

_T = TypeVar("_T")


def optional(
    attrs: Any, name: str, kind: Callable[[Any], _T], default: _T | None, where: str, problems: list[str]
) -> _T | None:
    """Read an attribute; ``default`` where it is missing, and with a problem where it cannot be read."""
    try:
        return attributes.read(attrs, name, kind)
    except AttributeMissing:
        return default
    except AttributeProblem as problem:
        problems.append(f"{where} {problem}.")
        return default


def group_of(file: h5py.File, name: str, path: Path, problems: list[str]) -> h5py.Group | None:
    """Return a group; None, and a problem, where there is none."""
    try:
        group = file.get(name)
    except (OSError, KeyError, RuntimeError) as error:
        problems.append(f"{path}: group /{name} cannot be read ({error}).")
        return None
    if not isinstance(group, h5py.Group):
        problems.append(f"{path}: there is no group /{name}.")
        return None
    return group


def columns_of(
    file: h5py.File, group_name: str, names: tuple[str, ...], path: Path, problems: list[str]
) -> list[NDArray[Any]] | None:
    """Read the datasets of a small table; None, and a problem, where they are not a table."""
    group = group_of(file, group_name, path, problems)
    if group is None:
        return None
    columns: list[NDArray[Any]] = []
    for name in names:
        try:
            columns.append(np.atleast_1d(group[name][()]))
        except (OSError, KeyError, RuntimeError, TypeError, AttributeError) as error:
            problems.append(f"{path}: /{group_name}/{name} cannot be read ({error}); the group is left out.")
            return None
    # A table that was being extended when the writer was killed is as long as its shortest column.
    length = min(column.size for column in columns)
    return [column[:length] for column in columns]
