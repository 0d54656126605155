"""A mapping to begin with: what the file says, what is guessed (and says so), what is left open as ``?``."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bench.errors import ConfigurationError
from bench.importing.channel import LINEAR
from bench.importing.looking.guesses import overflow, ratio_of, rises_evenly, step_of, unit_of_time
from bench.importing.looking.inventory import NAMELESS, Column, Inventory
from bench.importing.looking.names import Meaning, busiest_axis, channel_of, meaning, plain
from bench.importing.mapping import OPEN
from bench.importing.units import unit_of
from bench.signals import BY_NAME

NEEDED = {
    "the motor's angle or speed": ("motor_angle", "motor_velocity"),
    "the motor's torque, force or current": ("motor_torque",),
}
"""what the analysis needs at least, and the channels of which one says it"""
_GUESS = "a guess"
_TOLD = "the file says so"


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

    def open(self) -> list[str]:
        """Keys that are still open."""
        return [key for key, entry in self.entries().items() if entry.value == OPEN]

    def lacking(self) -> list[str]:
        """Sentences of what the analysis needs and no column was taken for."""
        spare = next((table for table in self.tables if table.startswith("aux.")), "aux.NAME")
        return [
            f"no column was taken for {what}, which the analysis needs: the table of the right one should be renamed,"
            f" as [{spare}] to [channels.{names[0]}], and its unit given"
            for what, names in NEEDED.items()
            if not any(f"channels.{name}" in self.tables for name in names)
        ]

    def entries(self) -> dict[str, Entry]:
        """All values by key."""
        return {
            f"{table}.{key}".removeprefix("."): entry
            for table, own in self.tables.items()
            for key, entry in own.items()
        }

    def write(self, path: Path) -> None:
        """Write the mapping; one that is there already is kept.

        Raises
        ------
        ConfigurationError
            There is a file of that name, or it cannot be written.
        """
        try:
            with path.open("x", encoding="utf-8") as file:
                file.write(self.text())
        except FileExistsError:
            raise ConfigurationError(
                f"{path}: is there already and was not overwritten; --mapping should name another file."
            ) from None
        except OSError as error:
            raise ConfigurationError(f"{path}: cannot be written ({error.strerror}).") from error

    def set(self, key: str, value: Any, why: str) -> None:
        """Put in a value that somebody gave."""
        table, _, name = key.rpartition(".")
        self.tables.setdefault(table, {})[name] = Entry(value, why)

    def text(self) -> str:
        """The mapping as TOML, each guess with a remark."""
        lines = [f"# {why}" for why in self.lacking()]
        for table, own in self.tables.items():
            if table:
                lines += ["", f"[[{table}]]" if table == "recordings" else f"[{table}]"]
            for key, entry in own.items():
                told = f"  # {entry.why}" if entry.why else ""
                lines.append(f"{key} = {toml(entry.value)}{told}")
        return "\n".join(lines) + "\n"


def toml(value: Any) -> str:
    """A value as TOML writes it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(own)}" for key, own in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else repr(value)


def draft(found: Inventory, mapping: Path) -> Draft:
    """Make a mapping of what is in a file; ``mapping`` is where it will stand."""
    meanings = {column.name: meaning(column) for column in found.columns}
    time = _clock(found, meanings)
    out = Draft({"": {}, "gearbox": {}, "channels.time": {}}, time=time)
    out.tables[""] = {"campaign_id": Entry(plain(found.file.stem), "any name")}
    out.tables["channels.time"] = _time_entries(found, time, meanings)
    out.rate = _rate(found, time, out.tables["channels.time"])
    taken: dict[str, Column] = {}
    rest: list[Column] = []
    busiest = busiest_axis(found.columns, meanings)
    for column in sorted(found.columns, key=lambda own: (not meanings[own.name].sure, own.number != busiest)):
        name = channel_of(meanings[column.name])
        if column is time or column.stamps or column.values.size != _size(found, time) or column.empty:
            continue
        if name is None or name in taken or meanings[column.name].setpoint or column.constant:
            rest.append(column)
        else:
            taken[name] = column
    for name in BY_NAME:
        if name in taken:
            own = meanings[taken[name].name]
            out.tables[f"channels.{name}"] = _channel_entries(taken[name], own)
            out.channel_by_column[taken[name].name] = name
    _gearbox(out, taken, meanings)
    for column in sorted(rest, key=lambda own: found.columns.index(own)):
        _further(out, column, meanings[column.name])
    _own_clocks(out, found, time, meanings)
    path = os.path.relpath(found.pattern, mapping.parent)
    out.tables["recordings"] = {"file": Entry(Path(path).as_posix())}
    return out


def _size(found: Inventory, time: Column | None) -> int:
    if time is not None:
        return int(time.values.size)
    sizes = [column.values.size for column in found.columns]
    return max(set(sizes), key=lambda size: (sizes.count(size), size))


def _clock(found: Inventory, meanings: dict[str, Meaning]) -> Column | None:
    """The column that is the time: one the file names, one called so, or the first without a meaning whose numbers rise
    as a clock's do.
    """
    told = [column.variable.clock for column in found.columns if column.variable.clock]
    rising = [column for column in found.columns if step_of(column) is not None]
    named = [column for column in rising if column.name in told]
    called = [column for column in rising if meanings[column.name].quantity == "time"]
    by_file = sorted(named, key=lambda own: (told.count(own.name), own.values.size), reverse=True)
    by_name = sorted(called, key=lambda own: (own.values.size, own.stamps, meanings[own.name].sure), reverse=True)
    by_numbers = [column for column in found.columns if not meanings[column.name].quantity and rises_evenly(column)]
    return next(iter([*by_file, *by_name, *(by_numbers if len(found.columns) > 1 else ())]), None)


def _time_entries(found: Inventory, time: Column | None, meanings: dict[str, Meaning]) -> dict[str, Entry]:
    if time is None:
        rates = [column.variable.rate for column in found.columns if column.variable.rate]
        if rates:
            return {"rate": Entry(max(rates), f"Hz, {_TOLD}")}
        return {"rate": Entry(OPEN, "samples per second: no column is a time", sure=False)}
    entries = _place(time)
    if not time.stamps and meanings[time.name].quantity != "time" and time.variable.clock is None:
        next(iter(entries.values())).why = f"{_GUESS}, it rises as a clock does"
    if time.stamps:
        if not time.variable.zoned:
            entries["timezone"] = Entry("UTC", f"{_GUESS}: the stamps say no zone, such as 'Europe/Berlin'", sure=False)
        return entries
    told = meanings[time.name].unit
    unit, sure = (told, True) if told else unit_of_time(time)
    entries["unit"] = Entry(unit, _TOLD if told else "" if sure else f"{_GUESS}, the step is {step_of(time):g}", sure)
    return entries


def _rate(found: Inventory, time: Column | None, entries: dict[str, Entry]) -> float | None:
    """Samples per second, where that is known."""
    if time is None:
        rate = entries["rate"].value
        return None if rate == OPEN else float(rate)
    step = step_of(time)
    unit = "s" if time.stamps else str(entries["unit"].value)
    return None if step is None or unit == OPEN else 1.0 / (step * unit_of(unit, str(found.file), "s").factor)


def _place(column: Column) -> dict[str, Entry]:
    """Where a column stands, as a mapping says it."""
    entries: dict[str, Entry] = {}
    if column.file:
        return {"file": Entry(column.file), "column": Entry(1)}
    headed = not column.variable.name.startswith((NAMELESS, "row "))
    if headed:
        entries["variable"] = Entry(column.variable.name)
    else:
        entries["column"] = Entry(int(column.variable.name.split()[1]))
    if column.number is not None:
        entries[column.along] = Entry(column.number)
    return entries


def _channel_entries(column: Column, own: Meaning) -> dict[str, Entry]:
    entries = _place(column)
    next(iter(entries.values())).why = "" if own.sure else f"{_GUESS}, from its name" if own.quantity else _GUESS
    wraps = overflow(column, own.unit, own.counted) if own.quantity == "angle" else None
    if own.counted:
        entries["unit"] = Entry("counts")
        sure = wraps is not None
        entries["counts_per_revolution"] = Entry(
            wraps if sure else OPEN, f"{_GUESS}, it overflows there" if sure else "of its shaft", sure=False
        )
    elif own.quantity == "current":
        entries["unit"] = Entry(own.unit or "A", "" if own.unit else _GUESS, sure=bool(own.unit))
        entries["torque_constant"] = Entry(OPEN, 'N·m/A at the motor\'s shaft (a linear axis: "… N/A")', sure=False)
    elif own.unit:
        entries["unit"] = Entry(own.unit, _TOLD)
    elif own.quantity == "temperature":
        entries["unit"] = Entry("degC", _GUESS, sure=False)
    else:
        low, high = column.span
        entries["unit"] = Entry(OPEN, f"the values are {low:.4g} to {high:.4g}", sure=False)
    if wraps is not None:
        entries["wraps_at"] = Entry(wraps, f"{_GUESS}: it starts again there")
    return entries


def _gearbox(out: Draft, taken: dict[str, Column], meanings: dict[str, Meaning]) -> None:
    """Ratio and kind of axis: from both angles where they are there, 1 where something is in metres."""
    units = {name: _si(meanings[column.name].unit) for name, column in taken.items()}
    if any(units[name] in LINEAR.values() for name in units):
        out.tables["gearbox"] = {"ratio": Entry(1.0, "a linear axis"), "axis": Entry("linear", "from the units")}
        return
    ratio = None
    pairs = [("motor_angle", "load_angle"), ("motor_velocity", "load_velocity")]
    for motor, load in pairs:
        if ratio is None and {motor, load} <= taken.keys() and units[motor] and units[load]:
            values = [_values(taken[name], out.tables[f"channels.{name}"]) for name in (motor, load)]
            ratio = ratio_of(values[0], values[1])
    why = "motor revolutions per revolution of the output; 1 for a direct drive"
    if ratio is not None:
        out.tables["gearbox"] = {
            "ratio": Entry(ratio, f"{_GUESS}: as the angles (speeds) of motor and output go together")
        }
    else:
        out.tables["gearbox"] = {"ratio": Entry(OPEN, why, sure=False)}


def _si(unit: str) -> str:
    try:
        return unit_of(unit, "").si if unit else ""
    except ConfigurationError:
        return ""


def _values(column: Column, entries: dict[str, Entry]) -> Any:
    """Values in SI units, unwrapped, as far as the entries say it."""
    values = column.seconds
    if "wraps_at" in entries:
        values = np.unwrap(values, period=float(entries["wraps_at"].value))
    return values * unit_of(str(entries["unit"].value), "").factor


def _further(out: Draft, column: Column, own: Meaning) -> None:
    """What is no channel: set values by their name, everything else as a quantity that something may depend on."""
    name = plain(column.name if column.number is not None else column.variable.name)
    table = f"channels.{name}" if own.setpoint else f"aux.{name}"
    count = 2
    while table in out.tables:
        table, count = f"{table.rstrip('0123456789_')}_{count}", count + 1
    entries = _place(column)
    why = "a set value: kept, not analysed" if own.setpoint else "no channel of the bench: kept, and may be depended on"
    next(iter(entries.values())).why = why
    if own.unit and _si(own.unit):
        entries["unit"] = Entry(own.unit, _TOLD)
    out.tables[table] = entries
    out.channel_by_column[column.name] = table.replace("aux.", "aux/").removeprefix("channels.")


def _own_clocks(out: Draft, found: Inventory, time: Column | None, meanings: dict[str, Meaning]) -> None:
    """Channels of another length whose own clock the file names."""
    size = _size(found, time)
    clocks = {column.variable.clock for column in found.columns}
    for column in found.columns:
        clock = column.variable.clock
        if column.values.size == size or column.name in clocks or clock is None or column.stamps:
            continue
        own = meanings[column.name]
        name = channel_of(own)
        if name is None or f"channels.{name}" in out.tables:
            _further(out, column, own)
            name = out.channel_by_column[column.name]
        else:
            out.tables[f"channels.{name}"] = _channel_entries(column, own)
            out.channel_by_column[column.name] = name
        table = name.replace("aux/", "aux.") if name.startswith("aux/") else f"channels.{name}"
        out.tables[table]["time"] = Entry(clock, "its own clock")
