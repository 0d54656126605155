"""A mapping to begin with: what the file says, what is guessed (and says so), what is left open as ``?``."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.importing.axis import mixture
from bench.importing.channel import LINEAR
from bench.importing.looking.clocks import clock_of, coarse_clock, counts_rows, rate_entry, why_no_clock
from bench.importing.looking.column import Column
from bench.importing.looking.entries import Draft, Entry
from bench.importing.looking.guesses import counts_by_one, power_of_two, rate_of, sign_bit, step_of, unit_of_time
from bench.importing.looking.inventory import Inventory
from bench.importing.looking.joint import mark_joint, to_joint
from bench.importing.looking.motion import Motion, values_of
from bench.importing.looking.names import Meaning, axes_of, busiest_axis, channel_of, meanings_of, plain
from bench.importing.looking.tables import FROM_FILE, GUESS, channel_entries, place_of
from bench.importing.mapping import OPEN
from bench.importing.units import si_of, split_unit, unit_of
from bench.signals import BY_NAME

_PAIRS = (
    ("motor_angle", "load_angle"),
    ("motor_velocity", "load_velocity"),
    ("motor_velocity", "load_angle"),
    ("motor_angle", "load_velocity"),
)
"""channels of both sides whose ratio is that of the gearbox, the surer first"""


def draft(found: Inventory, mapping: Path) -> Draft:
    """Make a mapping of what is in a file; ``mapping`` is where it will stand."""
    meanings = meanings_of(found.columns)
    time = clock_of(found, meanings)
    coarse = coarse_clock(found, meanings) if time is None else None
    out = Draft({"": {}, "gearbox": {}, "channels.time": {}}, time=time)
    out.tables[""] = {"campaign_id": Entry(plain(split_unit(found.file.stem)[0]), "any name")}
    out.tables["channels.time"] = _time_entries(found, time, meanings) if coarse is None else rate_entry(coarse)
    if coarse is not None:
        out.channel_by_column[coarse.name] = "coarser than the samples"
    rows = [column for column in found.columns if column is not time and counts_rows(column, meanings)]
    out.channel_by_column.update({column.name: "counts the rows, left out" for column in rows})
    out.rate = _rate(found, time, out.tables["channels.time"])
    taken: dict[str, Column] = {}
    rest: list[Column] = []
    axes = axes_of(found.columns, meanings)
    busiest = busiest_axis(found.columns, meanings, axes)
    motion = Motion(meanings, _seconds(out))
    strangers = motion.strangers(column for column in found.columns if column not in rows)

    def likely(column: Column) -> tuple[bool, bool, bool, bool]:
        meaning = meanings[column.name]
        return not meaning.sure, axes.get(column.name) != busiest, not meaning.measured, not meaning.of_motor

    for column in sorted(found.columns, key=likely):
        name = channel_of(meanings[column.name])
        if column in (time, coarse, *rows) or column.stamps or column.values.size != _size(found, time) or column.empty:
            continue
        column_meaning = meanings[column.name]
        if name is None or name in taken or column_meaning.setpoint or column.constant or column.name in strangers:
            rest.append(column)
        else:
            taken[name] = column
    if {"motor_angle", "motor_velocity"} <= taken.keys() and motion.against(
        taken["motor_angle"], taken["motor_velocity"]
    ):
        rest.append(taken.pop("motor_angle"))
    if {"motor_angle", "motor_velocity"} <= taken.keys():
        slower = motion.of_output(taken["motor_angle"], taken["motor_velocity"])
        name = "motor_angle" if slower is taken["motor_angle"] else "motor_velocity"
        if slower is not None and name.replace("motor", "load") not in taken:
            taken[name.replace("motor", "load")] = taken.pop(name)
    joint = to_joint(taken, meanings)
    if not axes:
        _other_side(taken, rest, motion)
    for name in BY_NAME:
        if name in taken:
            column_meaning = meanings[taken[name].name]
            out.tables[f"channels.{name}"] = channel_entries(taken[name], column_meaning)
            out.channel_by_column[taken[name].name] = name
    if joint:
        mark_joint(out, taken)
    _counts(out, taken, motion)
    _gearbox(out, taken, motion)
    _hardly_turns(out, taken, motion)
    _rate_of_motion(out, taken, meanings)
    for column in sorted(rest, key=lambda column: found.columns.index(column)):
        _further(out, column, meanings[column.name])
    _own_clocks(out, found, time, meanings)
    path = os.path.relpath(found.pattern, mapping.parent)
    why = "of several recordings: '*' in this and every other 'file' for the part of the name that differs"
    out.tables["recordings"] = {"file": Entry(Path(path).as_posix(), why if found.several else "")}
    out.remarks += [
        f"{column.name} seems to have its sign in bit {bit}: the values go on from {2**bit} as they do from 0. "
        f"sign_bit = {bit} in its table gives the sign back; it should be left out if they are unsigned"
        for column in found.columns
        for bit in [sign_bit(column)]
        if bit is not None
    ]
    out.remarks += found.source.notes
    unlike = found.unlike()
    if unlike is not None:
        out.remarks.append(
            f"{unlike} has other columns than {found.file.name}, so the files of the pattern are no recordings of the "
            "same channels: a pattern of the files of one recording shows them together"
        )
    return out


def _other_side(taken: dict[str, Column], rest: list[Column], motion: Motion) -> None:
    """Take an angle that turns with the motor's, but less far, for the output's where there is none."""
    if "motor_angle" not in taken or {"load_angle", "load_velocity"} & taken.keys():
        return
    first, meanings = taken["motor_angle"], motion.meanings
    second = motion.other_side(first, [column for column in rest if not meanings[column.name].of_motor])
    if second is None:
        return
    if motion.turned(second) < motion.turned(first):
        taken["load_angle"] = second
    elif not meanings[first.name].sided and "motor_velocity" not in taken:
        taken["motor_angle"], taken["load_angle"] = second, first
    else:
        return
    rest.remove(second)


def _size(found: Inventory, time: Column | None) -> int:
    if time is not None:
        return int(time.values.size)
    sizes = [column.values.size for column in found.columns]
    return max(set(sizes), key=lambda size: (sizes.count(size), size))


def _time_entries(found: Inventory, time: Column | None, meanings: dict[str, Meaning]) -> dict[str, Entry]:
    if time is None:
        rates = [column.variable.rate for column in found.columns if column.variable.rate]
        if rates:
            return {"rate": Entry(max(rates), f"Hz, {FROM_FILE}")}
        return {"rate": Entry(OPEN, f"samples per second: {why_no_clock(found, meanings)}", sure=False)}
    entries = place_of(time)
    if not time.stamps and meanings[time.name].quantity != "time" and time.variable.clock is None:
        next(iter(entries.values())).why = f"{GUESS}, it rises as a clock does"
    if time.stamps:
        if not time.variable.zoned:
            entries["timezone"] = Entry("UTC", f"{GUESS}: the stamps say no zone, such as 'Europe/Berlin'", sure=False)
        return entries
    unit_in_file = meanings[time.name].unit
    unit, sure = (unit_in_file, True) if unit_in_file else unit_of_time(time)
    why = f"{GUESS}, the step is {step_of(time):g}"
    if counts_by_one(time):
        why += " in all rows: if it counts them, 'rate' (samples per second) instead of variable and unit"
    entries["unit"] = Entry(unit, FROM_FILE if unit_in_file else "" if sure else why, sure)
    return entries


def _rate(found: Inventory, time: Column | None, entries: dict[str, Entry]) -> float | None:
    """Samples per second, where that is known."""
    if time is None:
        rate = entries["rate"].value
        return None if rate == OPEN else float(rate)
    step = step_of(time)
    unit = "s" if time.stamps else str(entries["unit"].value)
    return None if step is None or unit == OPEN else 1.0 / (step * unit_of(unit, str(found.file), "s").factor)


def _gearbox(out: Draft, taken: dict[str, Column], motion: Motion) -> None:
    """Ratio and kind of axis: from both angles where they are there, 1 where something is in metres."""
    units = {name: si_of(motion.meanings[column.name].unit) for name, column in taken.items()}
    # the angle says what kind of axis it is: a cylinder's force acts on a joint by a lever
    turning = any(units.get(name) == "rad" for name in ("motor_angle", "load_angle"))
    mixed = mixture({name: (si, motion.meanings[taken[name].name].unit) for name, si in units.items()})
    if mixed is not None:
        out.remarks.append(mixed)
    elif not turning and any(units[name] in LINEAR.values() for name in units):
        out.tables["gearbox"] = {"ratio": Entry(1.0, "a linear axis"), "axis": Entry("linear", "from the units")}
        return
    if turning and units.get("motor_torque") == "N":
        lever = Entry(OPEN, "lever of the force about the axis, such as '0.3 m'", sure=False)
        out.tables["channels.motor_torque"]["factor"] = lever
    ratio = None
    for motor, load in _PAIRS:
        if ratio is None and {motor, load} <= taken.keys() and units[motor] and units[load]:
            ratio = motion.ratio(taken[motor], taken[load])
    why = "motor revolutions per revolution of the output; 1 for a direct drive"
    if ratio is not None:
        whole = ratio == round(ratio)
        twisted = "" if whole else "; a load that twists the gearbox changes it a little, so the data sheet's is better"
        together = f"{GUESS}: as the angles (speeds) of motor and output go together{twisted}"
        out.tables["gearbox"] = {"ratio": Entry(ratio, together, sure=whole)}
    else:
        out.tables["gearbox"] = {"ratio": Entry(OPEN, why, sure=False)}


def _counts(out: Draft, taken: dict[str, Column], motion: Motion) -> None:
    """Counts per revolution of an encoder, from the speed of its shaft; an overflow alone may be of several turns."""
    for side in ("motor", "load"):
        angle, velocity = taken.get(f"{side}_angle"), taken.get(f"{side}_velocity")
        if angle is None or velocity is None or not motion.meanings[angle.name].counted:
            continue
        counts = motion.counts_per_revolution(angle, velocity)
        if counts is None:
            continue
        usual = power_of_two(counts)
        out.tables[f"channels.{side}_angle"]["counts_per_revolution"] = (
            Entry(OPEN, f"of its shaft; {velocity.name} says {counts:.4g} if it is of the same shaft", sure=False)
            if usual is None
            else Entry(usual, f"{GUESS}: {velocity.name} is the rate of the angle then", sure=False)
        )


def _hardly_turns(out: Draft, taken: dict[str, Column], motion: Motion) -> None:
    """Remark that an angle without a side, taken for the motor's, turns less than once: it may be a joint's."""
    angle = taken.get("motor_angle")
    if angle is None or "load_angle" in taken or motion.meanings[angle.name].sided:
        return
    if si_of(motion.meanings[angle.name].unit) != "rad" or motion.turned(angle) >= 2 * np.pi:
        return
    velocity = taken.get("motor_velocity")
    both = velocity is not None and not motion.meanings[velocity.name].sided
    out.remarks.append(
        f"channels.motor_angle ({angle.name}) turns over {motion.turned(angle) / (2 * np.pi):.2g} revolutions in all: "
        f"if it is the output's (a joint's), its table is [channels.load_angle]"
        + (", and that of its speed [channels.load_velocity]" if both else "")
    )


def _rate_of_motion(out: Draft, taken: dict[str, Column], meanings: dict[str, Meaning]) -> None:
    """A rate that no column says, from an angle and its speed."""
    entries = out.tables["channels.time"]
    pair = [name for name in ("motor_angle", "motor_velocity") if name in taken]
    units = [str(out.tables[f"channels.{name}"]["unit"].value) for name in pair]
    if "rate" not in entries or entries["rate"].value != OPEN or len(pair) < 2 or not all(map(si_of, units)):
        return
    angle, velocity = (values_of(taken[name], meanings[taken[name].name]) for name in pair)
    out.rate = rate_of(angle, velocity)
    if out.rate is not None:
        entries["rate"] = Entry(out.rate, f"Hz, {GUESS}: the speed is the rate of the angle then", sure=False)


def _seconds(out: Draft) -> NDArray[np.float64] | None:
    """The clock of a draft in seconds; None where there is none or its unit is open."""
    if out.time is None or out.time.stamps:
        return None if out.time is None else out.time.seconds
    unit = str(out.tables["channels.time"]["unit"].value)
    return None if unit == OPEN else out.time.seconds * unit_of(unit, "", "s").factor


def _further(out: Draft, column: Column, column_meaning: Meaning) -> None:
    """What is no channel: set values by their name, everything else as a quantity that something may depend on."""
    name = plain(column.name if column.number is not None else column.variable.heading[0])
    table = f"channels.{name}" if column_meaning.setpoint else f"aux.{name}"
    count = 2
    while table in out.tables:
        table, count = f"{table.rstrip('0123456789_')}_{count}", count + 1
    entries = place_of(column)
    why = (
        "a set value: kept, not analysed"
        if column_meaning.setpoint
        else "no channel of the bench: kept, and may be depended on"
    )
    next(iter(entries.values())).why = why
    if column_meaning.unit and si_of(column_meaning.unit):
        entries["unit"] = Entry(column_meaning.unit, FROM_FILE)
    out.tables[table] = entries
    channel = channel_of(column_meaning)
    if not column.constant and not column_meaning.setpoint and not column.stamps:
        out.spare[table] = column_meaning.quantity
    elif column.constant and channel is not None:
        out.still.setdefault(channel, (column.name, column.span[0]))
    out.channel_by_column[column.name] = table.replace("aux.", "aux/").removeprefix("channels.")


def _own_clocks(out: Draft, found: Inventory, time: Column | None, meanings: dict[str, Meaning]) -> None:
    """Channels of another length whose own clock the file names."""
    size = _size(found, time)
    clocks = {column.variable.clock for column in found.columns}
    for column in found.columns:
        clock = column.variable.clock
        if column.values.size == size or column.name in clocks or clock is None or column.stamps:
            continue
        column_meaning = meanings[column.name]
        name = channel_of(column_meaning)
        if name is None or f"channels.{name}" in out.tables:
            _further(out, column, column_meaning)
            name = out.channel_by_column[column.name]
        else:
            out.tables[f"channels.{name}"] = channel_entries(column, column_meaning)
            out.channel_by_column[column.name] = name
        table = name.replace("aux/", "aux.") if name.startswith("aux/") else f"channels.{name}"
        out.tables[table]["time"] = Entry(clock, "its own clock")
