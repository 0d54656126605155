"""What ``bench import --look`` and ``--ask`` print."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from bench.cli._plain import line, plain, say

if TYPE_CHECKING:
    from bench.importing.looking import Draft, Inventory

_WIDEST_NAME = 40
"""marks of a column's name that are shown; the mapping has all of it"""
_NARROWEST_UNIT = 6


def look(file: str, mapping: Path | None, changes: dict[str, Any], *, asking: bool, as_json: bool) -> Path:
    """Show what is in a file, write a mapping to begin with (``asking``: ask for what is open), and give its path."""
    if file.lower().endswith(".fmu"):
        return _look_at_fmu(Path(file), mapping, changes, asking=asking, as_json=as_json)
    from bench.importing.looking import ask, draft, take_inventory

    found = take_inventory(file)
    target = mapping or Path(f"{found.file.stem}.toml")
    made = draft(found, target)
    if not as_json:
        _show(found, made)
    for key, value in changes.items():
        made.set(key, value, "given on the command line")
    if asking:
        ask(made, lambda question, guess: str(typer.prompt(plain(question), default=guess)), say)
    made.write(target)
    if as_json:
        say(json.dumps(_as_dict(found, made, target), ensure_ascii=False))
        return target
    say(f"mapping: {target}")
    for why in (*made.lacking(), *made.remarks):
        say(f"  {line(why)}")
    for key in made.open():
        say(f"  {key} is open: {made.entries()[key].why}; --set {key}=… or the file itself gives it")
    return target


def _look_at_fmu(file: Path, mapping: Path | None, changes: dict[str, Any], *, asking: bool, as_json: bool) -> Path:
    """Show what an FMU says of itself, and write the mapping that ``bench mismatch --simulation`` takes."""
    from bench.errors import ConfigurationError
    from bench.foreign.looking import draft, take_inventory
    from bench.importing.looking import write_new

    if asking:
        raise ConfigurationError(f"{file}: --ask is for files of measurements; --look writes the mapping of an FMU.")
    found = take_inventory(file)
    target = mapping or Path(f"{file.stem}.toml")
    write_new(target, draft(found, target, changes))
    if as_json:
        say(json.dumps({"file": str(file), "mapping": str(target), "variables": [asdict(v) for v in found.variables]}))
        return target
    say(f"{file}: {found.title}, FMI {found.version}, {found.kind}")
    width = max((len(variable.name) for variable in found.variables), default=0)
    for variable in found.variables:
        start = "" if variable.start is None else f"{variable.start:g}"
        given = changes.get(f"{variable.causality}s.{variable.name}")
        channel = given if isinstance(given, str) else variable.channel
        say(
            (
                f"{line(variable.name):<{width}} {variable.causality:<9} {variable.unit:<12} {start:>12}  {channel}"
            ).rstrip()
        )
    say(f"mapping: {target}; bench mismatch RECORDINGS --simulation {target} --out REPORT takes it")
    for variable in found.of("input"):
        if not variable.channel and f"inputs.{variable.name}" not in changes:
            kept = "its start value" if variable.start is None else f"{variable.start:g} {variable.unit}".rstrip()
            say(
                f"  inputs.{variable.name} has no channel and stays at {kept}, for its name and unit suggest none; "
                f"--set inputs.{variable.name}=CHANNEL gives it one"
            )
    return target


def _short(name: str) -> str:
    """A name with its middle left out where it is too long for a column: names of one file mostly begin alike."""
    half = (_WIDEST_NAME - 1) // 2
    return name if len(name) <= _WIDEST_NAME else f"{name[:half]}…{name[-half:]}"


def _show(found: Inventory, made: Draft) -> None:
    from bench.importing.looking.inventory import picture

    if found.unseen:
        say(f"{found.file} is the first of {len(found.unseen) + 1} files that fit; the others are not shown")
    lengths = sorted({column.values.size for column in found.columns}, reverse=True)
    rate = "rate not known" if made.rate is None else f"{made.rate:.6g} Hz"
    say(f"{found.file}: {len(found.columns)} columns of {', '.join(map(str, lengths[:4]))} samples, {rate}")
    if made.time is not None and made.time.stamps:
        first, last = (str(np.datetime_as_string(stamp, unit="ms")) for stamp in made.time.values[[0, -1]])
        say(f"time stamps from {first} to {last}{' UTC' if made.time.variable.zoned else ', which say no zone'}")
    names = [_short(line(column.name)) for column in found.columns]
    constants = {_short(line(name)): value for name, value in found.constants.items()}
    width = max(map(len, (*names, *constants)))
    units = max(_NARROWEST_UNIT, *(len(line(column.variable.unit)) for column in found.columns))
    for name, column in zip(names, found.columns, strict=True):
        low, high = column.span
        span = "" if column.stamps or math.isnan(low) else f"{low:10.4g} … {high:<10.4g}"
        unit = line(column.variable.unit)
        role = "time" if column is made.time else made.channel_by_column.get(column.name, "")
        role = "empty, left out" if column.empty else role
        shape = "x".join(map(str, column.variable.shape))
        drawn = picture(column.seconds)
        say(f"{name:<{width}} {shape:>8} {unit:<{units}} {span:<23} {drawn:<24} {role}".rstrip())
    for sentence in found.missing_samples():
        say(line(sentence))
    for name, value in constants.items():
        say(f"{name:<{width}}        1 = {value:g}, may be a scale")
    for variable, why in found.others:
        say(f"{_short(line(variable.name)):<{width}} {'x'.join(map(str, variable.shape)):>8} left out: {line(why)}")


def _as_dict(found: Inventory, made: Draft, target: Path) -> dict[str, Any]:
    return {
        "file": str(found.file),
        "mapping": str(target),
        "sample_rate": made.rate,
        "columns": [
            {
                "name": column.name,
                "shape": list(column.variable.shape),
                "samples": int(column.values.size),
                "dtype": column.variable.dtype,
                "unit": column.variable.unit,
                "min": None if math.isnan(column.span[0]) else column.span[0],
                "max": None if math.isnan(column.span[1]) else column.span[1],
                "missing": int(column.missing.size),
                "channel": "time" if column is made.time else made.channel_by_column.get(column.name),
            }
            for column in found.columns
        ],
        "constants": found.constants,
        "left_out": {variable.name: why for variable, why in found.others},
        "open": made.open(),
        "lacking": made.lacking(),
        "remarks": made.remarks,
    }
