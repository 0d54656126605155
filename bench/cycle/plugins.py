"""Masters and drivers by name, found through entry points: the bench never imports them itself."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from bench.errors import ConfigurationError

MASTERS, DRIVERS = "bench.masters", "bench.drivers"


def plugin(group: str, name: str) -> Callable[..., Any]:
    """Return what is registered under a name.

    Raises
    ------
    ConfigurationError
        If nothing is; lists what there is.
    """
    found = _installed_entry_points(group)
    for entry in found:
        if entry.name == name:
            loaded: Callable[..., Any] = entry.load()
            return loaded
    known = ", ".join(sorted(entry.name for entry in found)) or "none"
    kind = "master" if group == MASTERS else "driver"
    raise ConfigurationError(f'there is no {kind} "{name}"; installed are {known}')


@cache
def _installed_entry_points(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group; looking through all packages takes longer than opening a bench."""
    return tuple(entry_points(group=group))
