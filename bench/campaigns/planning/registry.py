"""Sequences by name, found through the entry points of the group ``bench.sequences``."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import entry_points
from typing import Any, get_type_hints

from bench.configuration import parse_quantity
from bench.errors import ConfigurationError
from bench.protocols import Sequence, Unit

_NOT_OPTIONS = {"kind", "prepares_temperature"}


def sequence_names() -> tuple[str, ...]:
    """Names of all installed sequences."""
    return tuple(sorted(entry.name for entry in entry_points(group="bench.sequences")))


@cache
def sequence_class(name: str) -> type[Any]:
    """Return the class of a sequence.

    Raises
    ------
    ConfigurationError
        If no installed package offers it.
    """
    for entry in entry_points(group="bench.sequences"):
        if entry.name == name:
            loaded: type[Any] = entry.load()
            if not is_dataclass(loaded):
                raise ConfigurationError(f'sequence "{name}" ({entry.value}) must be a dataclass of its options')
            return loaded
    raise ConfigurationError(f'there is no sequence "{name}"; installed are {", ".join(sequence_names())}')


@cache
def build_sequence(name: str, options: tuple[tuple[str, float], ...] = ()) -> Sequence:
    """Make a sequence with its options (SI values).

    Raises
    ------
    ConfigurationError
        If the sequence or an option is unknown.
    """
    cls = sequence_class(name)
    _check_options(name, (key for key, _ in options))
    sequence: Sequence = cls(**dict(options))
    return sequence


def parse_options(name: str, options: dict[str, object]) -> tuple[tuple[str, float], ...]:
    """Turn the option table of a campaign file into SI values, by the units the sequence declares.

    Raises
    ------
    ConfigurationError
        If an option is unknown or its value is of the wrong kind.
    """
    cls = sequence_class(name)
    _check_options(name, options)
    hints = get_type_hints(cls, include_extras=True)
    parsed = []
    for key, value in sorted(options.items()):
        unit = next((mark for mark in getattr(hints[key], "__metadata__", ()) if isinstance(mark, Unit)), None)
        try:
            parsed.append((key, _number(value, hints[key]) if unit is None else parse_quantity(value, unit.kind)))
        except ValueError as error:
            raise ConfigurationError(f"option {key} = {value!r} of {name}: {error}") from error
    return tuple(parsed)


def _check_options(name: str, keys: Iterable[str]) -> None:
    known = [field.name for field in fields(sequence_class(name)) if field.name not in _NOT_OPTIONS]
    for key in keys:
        if key not in known:
            offered = f"it knows {', '.join(known)}" if known else "it has none"
            raise ConfigurationError(f'sequence "{name}" has no option "{key}"; {offered}')


def _number(value: object, hint: object) -> float:
    if hint is int:
        if isinstance(value, int) and not isinstance(value, bool):
            return value
        raise ValueError("this must be a whole number")
    if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value):
        return float(value)
    raise ValueError("this must be a finite number")
