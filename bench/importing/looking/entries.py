"""The tables of a mapping while it is drafted: values, why they are those, what is open, and how it is written."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.errors import ConfigurationError
from bench.importing.looking.column import Column
from bench.importing.looking.words import SIGNALS
from bench.importing.mapping import OPEN

NEEDED = {
    # with the torque, the output's angle or speed times the ratio stands for the motor's
    "the motor's angle or speed": ("motor_angle", "motor_velocity", "load_angle", "load_velocity"),
    "the motor's torque, force or current": ("motor_torque",),
}
"""what the analysis needs at least, and the channels of which one says it"""
_QUANTITIES = {
    "motor_angle": (("angle", "velocity"), ("angle in %", "angle in V")),
    "motor_torque": (("torque", "current"), ("torque in V",)),
}
"""quantities that a column may be of to be a channel that is needed, the likelier first"""
_NUMBERED = re.compile(r"(column|row)_\d+$")
_ANY = "_N"
"""stands for the number of a column without a name: none of them is likelier than the others"""


@dataclass(slots=True)
class Entry:
    """A value of a mapping, with ``why`` it is that, and whether it is ``sure``."""

    value: Any
    why: str = ""
    sure: bool = True


@dataclass(slots=True)
class Draft:
    """Tables of a mapping by name, and which column each channel was guessed to be."""

    tables: dict[str, dict[str, Entry]]
    channel_by_column: dict[str, str] = field(default_factory=dict)
    time: Column | None = None
    rate: float | None = None
    spare: dict[str, str] = field(default_factory=dict)
    """tables of columns that change and are no channel, with the quantity each seems to be of ("": not known)"""
    still: dict[str, tuple[str, float]] = field(default_factory=dict)
    """channels of which the only column is constant, with its name and its value in the file's unit"""
    remarks: list[str] = field(default_factory=list)
    """sentences of what does not go together in the file"""

    def open(self) -> list[str]:
        """Keys that are still open."""
        return [key for key, entry in self.entries().items() if entry.value == OPEN]

    def lacking(self) -> list[str]:
        """Sentences of what the analysis needs and no column was taken for: both angles do without a torque."""
        if {"channels.motor_angle", "channels.load_angle"} <= self.tables.keys():
            return []
        sentences: list[str] = []
        advised: set[str] = set()
        for what, names in NEEDED.items():
            if any(f"channels.{name}" in self.tables for name in names):
                continue
            still = next((self.still[name] for name in names if name in self.still), None)
            if still is not None:
                why = f"'{still[0]}' is {still[1]:g} in all samples, so nothing was measured there"
            else:
                table = self._spare_for(names[0], advised)
                advised.add(table)
                why = self._renamed(table, names[0])
            sentences.append(f"no column was taken for {what}, which the analysis needs: {why}")
        return sentences

    def _spare_for(self, channel: str, advised: set[str]) -> str:
        """The table that may be the one of a channel: of its quantity, or else of none that is known."""
        left = {table: quantity for table, quantity in self.spare.items() if table not in advised}
        for fits in (*_QUANTITIES[channel], ("",)):
            for table, quantity in left.items():
                if quantity in fits:
                    return table if quantity else _NUMBERED.sub(rf"\1{_ANY}", table)
        return "aux.NAME"

    def _renamed(self, table: str, channel: str) -> str:
        """How the table of a spare column becomes that of a channel."""
        if table.endswith(_ANY):
            return (
                f"no name says which column that is; its table, [{table}] with its number as N, should be renamed "
                f"to [channels.{channel}], and its unit given"
            )
        factor = SIGNALS.get(self.spare.get(table, ""))
        moving = factor is not None and channel == "motor_angle"
        of_output = " ([channels.load_angle] if it is the output's)" if moving else ""
        return (
            f"the table of the right one should be renamed, as [{table}] to [channels.{channel}]{of_output}, and "
            + (f"a factor given, {factor}" if factor else "its unit given")
        )

    def entries(self) -> dict[str, Entry]:
        """All values by key."""
        return {
            f"{table}.{key}".removeprefix("."): entry
            for table, table_entries in self.tables.items()
            for key, entry in table_entries.items()
        }

    def write(self, path: Path) -> None:
        """Write the mapping; one that is there already is kept.

        Raises
        ------
        ConfigurationError
            There is a file of that name, or it cannot be written.
        """
        write_new(path, self.text())

    def set(self, key: str, value: Any, why: str) -> None:
        """Put in a value that somebody gave."""
        table, _, name = key.rpartition(".")
        self.tables.setdefault(table, {})[name] = Entry(value, why)

    def text(self) -> str:
        """The mapping as TOML, each guess with a remark."""
        lines = [f"# {why}" for why in (*self.lacking(), *self.remarks)]
        for table, table_entries in self.tables.items():
            if table:
                lines += ["", f"[[{table}]]" if table == "recordings" else f"[{table}]"]
            for key, entry in table_entries.items():
                remark = f"  # {entry.why}" if entry.why else ""
                lines.append(f"{key} = {toml(entry.value)}{remark}")
        return "\n".join(lines) + "\n"


def write_new(path: Path, text: str) -> None:
    """Write a mapping; a file that is there already is kept.

    Raises
    ------
    ConfigurationError
        There is a file of that name, or it cannot be written.
    """
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise ConfigurationError(
            f"{path}: is there already and was not overwritten; --mapping should name another file."
        ) from None
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be written ({error.strerror}).") from error


def toml(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)
