"""From what stands behind ``--simulation``, or in a simulation file, to a simulation that can be run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench.errors import ConfigurationError
from bench.foreign.base import Base, Values
from bench.foreign.columns import WORD, Columns
from bench.foreign.python import Function, free_of

FMU_SUFFIXES = (".fmu", ".toml")
_BEGIN = 64
"""bytes in which a JSON object begins"""
_BLANKS = b"\xef\xbb\xbf \t\r\n"
"""what may stand before it: a byte order mark, spaces and ends of lines"""


def open_base(source: str, values: Values | None = None) -> Base | None:
    """Open ``columns``, an FMU or its mapping, or ``module:name``; None for anything else, such as a ``model.json``.

    Raises
    ------
    ConfigurationError
        It is one of these, and cannot be opened.
    """
    if source == WORD:
        return Base.of(Columns())
    if Path(source).suffix.lower() in FMU_SUFFIXES:
        from bench.foreign.fmu import open_fmu

        return open_fmu(Path(source), values)
    if ":" in source and not Path(source).exists():
        return Base.of(Function(source), free_of(source), values)
    if _is_no_json(Path(source)):
        raise ConfigurationError(
            f"{source}: is no simulation; it should be a model.json, an FMU (.fmu) or the mapping of one (.toml), "
            f"a Python function module:name, or {WORD}."
        )
    return None


def _is_no_json(path: Path) -> bool:
    """Whether a file is there and does not begin as a JSON object does."""
    try:
        with path.open("rb") as file:
            return not file.read(_BEGIN).lstrip(_BLANKS).startswith(b"{")
    except OSError:
        # what is not there, or not to be read, is said where it is opened
        return False


def base_of(content: Mapping[str, Any], beside: Path, store: Path | None = None) -> Base | None:
    """The simulation on which a simulation file in the folder ``beside`` stands; None where it stands alone.

    ``content``: what the file holds beside its terms. Raises ConfigurationError where it cannot be opened.
    """
    entry = content.get("base")
    if entry is None:
        return None
    try:
        source, kind = str(entry["source"]), str(entry["kind"])
        values = {str(name): float(parameter["value"]) for name, parameter in entry.get("parameters", {}).items()}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ConfigurationError(
            f"the simulation's base should have kind, source and parameters, each with a value ({error!r})."
        ) from error
    base = open_base(str(beside / source) if kind == "fmu" else source, values)
    if base is None or base.simulator.kind != kind:
        raise ConfigurationError(
            f"the simulation's base '{source}' of kind '{kind}' should be {WORD}, an FMU, or module:name."
        )
    return replace(base, store=store)
