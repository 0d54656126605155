"""Rules on attributes and groups. Each rule yields (where, what is wrong and what is right, whether only a note)."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from bench.recording.file import attributes
from bench.recording.file.attributes import AttributeProblem
from bench.recording.header import AXES, FORMAT, FORMAT_VERSION, KINDS, PART_SUFFIX, SOURCES, TEETH
from bench.recording.rules.findings import Finding

_ROOT: dict[str, Callable[[Any], Any]] = {
    "format": attributes.text,
    "format_version": attributes.text,
    "recording_id": attributes.text,
    "campaign_id": attributes.text,
    "kind": attributes.text,
    "started_at": attributes.moment,
    "sample_rate": attributes.number,
    "source": attributes.text,
}
_BENCH: dict[str, Callable[[Any], Any]] = {
    "point_id": attributes.text,
    "take": attributes.integer,
    "accepted": attributes.boolean,
    "zero_id": attributes.text,
    "gearbox_serial": attributes.text,
    "axis": attributes.text,
    "imported_from": attributes.text,
}
_SETPOINTS = ("load_torque", "velocity", "temperature")
_SOFTWARE = ("name", "version", "revision")


def _one_of(*allowed: str) -> Callable[[Any], str | None]:
    return lambda value: None if value in allowed else f"is '{value}', it should be one of {', '.join(allowed)}"


def stem(path: Path) -> str:
    """Give the file's name without ``.h5`` and ``.part``."""
    name = path.name.removesuffix(PART_SUFFIX)
    return name[: name.rfind(".")] if "." in name else name


def root_attributes(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Check the table of root attributes: presence, type, value."""
    values: dict[str, Any] = {}
    for name, kind in _ROOT.items():
        try:
            values[name] = attributes.read(file.attrs, name, kind)
        except AttributeProblem as problem:
            yield "root", str(problem), False
    checks: dict[str, Callable[[Any], str | None]] = {
        "format": _one_of(FORMAT),
        "format_version": _one_of(FORMAT_VERSION),
        "kind": _one_of(*KINDS),
        "source": _one_of(*SOURCES),
        "recording_id": lambda value: (
            None if value == stem(path) else f"is '{value}', it should be the file's stem '{stem(path)}'"
        ),
        "campaign_id": lambda value: None if value else "is empty, it should name the campaign",
        "sample_rate": lambda value: (
            None if math.isfinite(value) and value > 0 else f"is {value}, it should be a finite frequency above 0 Hz"
        ),
        "started_at": lambda _: _not_utc(attributes.text(file.attrs["started_at"])),
    }
    for name, check in checks.items():
        wrong = check(values[name]) if name in values else None
        if wrong:
            yield "root attribute", f"'{name}' {wrong}", False
    yield from _bench_attributes(file)


def _not_utc(text: str) -> str | None:
    offset = datetime.fromisoformat(text.strip()).utcoffset()
    if offset == timedelta(0):
        return None
    return f"is '{text}', it should be in UTC and say so, such as 2026-11-21T09:00:00+00:00"


def _bench_attributes(file: h5py.File) -> Iterator[Finding]:
    if "complete" not in file.attrs:
        yield "root attribute", "'complete' is absent: the recording was cut short and holds a valid prefix", True
    else:
        try:
            if not attributes.read(file.attrs, "complete", attributes.boolean):
                yield "root attribute", "'complete' is false: the recording was cut short", True
        except AttributeProblem as problem:
            yield "root", str(problem), False
    for name, kind in _BENCH.items():
        if name not in file.attrs:
            continue
        try:
            value = attributes.read(file.attrs, name, kind)
        except AttributeProblem as problem:
            yield "root", str(problem), False
        else:
            if name == "take" and value < 1:
                yield "root attribute", f"'take' is {value}, takes count from 1", False
            elif name == "axis" and value not in AXES:
                yield "root attribute", f"'axis' is '{value}', it should be one of {', '.join(AXES)}", False


def groups(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Check the groups ``setpoint`` and ``gearbox``."""
    setpoint = file.get("setpoint")
    if not isinstance(setpoint, h5py.Group):
        yield "/setpoint", "is missing, it should be a group with load_torque, velocity and temperature", False
    else:
        for name in _SETPOINTS:
            try:
                value = attributes.read(setpoint.attrs, name, attributes.number)
            except AttributeProblem as problem:
                yield "/setpoint", f"{problem} (NaN where it was not commanded)", False
            else:
                if math.isinf(value):
                    yield "/setpoint", f"attribute '{name}' is {value}, it should be finite, or NaN", False
    gearbox = file.get("gearbox")
    if not isinstance(gearbox, h5py.Group):
        yield "/gearbox", "is missing, it should be a group with the attribute 'ratio'", False
        return
    try:
        ratio = attributes.read(gearbox.attrs, "ratio", attributes.number)
    except AttributeProblem as problem:
        yield "/gearbox", str(problem), False
    else:
        if not math.isfinite(ratio) or ratio == 0:
            yield "/gearbox", f"attribute 'ratio' is {ratio}, it should be finite and not 0", False
    for name in TEETH:
        if name not in gearbox.attrs:
            continue
        try:
            teeth = attributes.read(gearbox.attrs, name, attributes.integer)
        except AttributeProblem as problem:
            yield "/gearbox", str(problem), False
        else:
            if teeth < 1:
                yield "/gearbox", f"attribute '{name}' is {teeth}, it should be a number of teeth", False


def provenance(file: h5py.File, path: Path) -> Iterator[Finding]:
    """Check ``config`` and ``software``; their absence is only noted, readers never require them."""
    config = file.get("config")
    if config is None:
        yield "/config", "is absent: the bench configuration in force is not known", True
    elif not isinstance(config, h5py.Dataset):
        yield "/config", "is not a dataset, it should be one string", False
    else:
        try:
            tomllib.loads(attributes.text(np.asarray(config[()], dtype=object)))
        except tomllib.TOMLDecodeError as error:
            yield "/config", f"is not TOML ({error})", False
        except ValueError:
            yield "/config", f"is not text, it should be one string (it is {config.dtype})", False
    software = file.get("software")
    if not isinstance(software, h5py.Group):
        yield "/software", "is absent: what wrote the file is not known", True
        return
    for name in _SOFTWARE:
        if name not in software.attrs:
            yield "/software", f"attribute '{name}' is absent", True
