"""Masters and drivers by name, found through entry points: the bench never imports them itself."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import entry_points
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
    found = entry_points(group=group)
    for entry in found:
        if entry.name == name:
            loaded: Callable[..., Any] = entry.load()
            return loaded
    known = ", ".join(sorted(entry.name for entry in found)) or "none"
    kind = "master" if group == MASTERS else "driver"
    raise ConfigurationError(f'there is no {kind} "{name}"; installed are {known}')
