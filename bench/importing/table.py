"""All channels of one file on one clock: read, put in order, brought together, with notes of what had to be done."""

from __future__ import annotations

import itertools
from collections.abc import Mapping as Table
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import ConfigurationError, RecordingError
from bench.importing.axis import mixture
from bench.importing.channel import LINEAR, Channel, fill_missing, read_channel
from bench.importing.channel_mapping import ChannelMapping
from bench.importing.clock import read_clock
from bench.importing.files import Files
from bench.importing.fill import LEAST_FILL, fill_note
from bench.importing.held import Held, held, thinned
from bench.importing.mapping import Mapping
from bench.importing.motor_angle import add_motor_angle
from bench.importing.output_torque import to_motor
from bench.importing.stamps import (
    even_clock,
    evenness,
    gap_sentence,
    in_order,
    refuse_uneven,
    sampled_when_stamped,
    why_not_in_order,
)
from bench.signals import BY_NAME

_WORDS = ("word", "count")
ONE_MORE = 1
"""samples that channels of a file may have more than others: a state is logged once more after its last input"""
_LEAST_ROWS = 2
_MOVES = ("motor_angle", "load_angle", "motor_velocity")
"""Channels that a motion makes smooth."""
_MOST_LEFT_OUT = 0.5
"""Share of the rows of a file that ``invalid_rows = 'drop'`` leaves out at most: where most rows are bad, a wrong
column or rows in another order than that of time are likelier, and what is left tells little of the file."""
_NEAR = {1: 0.01, 2: 0.005, 3: 0.001}
"""Share by which a rate of so many digits may be off the mean rate of stamps that shake, or that miss rows: channels
are interpolated, so any clock is right, and files of one logger had better have one."""
_OTHER_RATE = 0.02
"""Share by which a stated rate may be off the stamps' own and still be the same: stamps are rounded."""


@dataclass(slots=True)
class ChannelTable:
    """Channels of equal length by name, ``time`` among them; ``starts`` where each stretch without a gap begins;
    ``held`` where rows of the file that only repeat values were left out; ``doubts``: sentences of what of the mapping
    cannot be.
    """

    channels: dict[str, Channel]
    started_at: datetime | None
    linear: bool
    notes: list[str] = field(default_factory=list)
    starts: list[int] = field(default_factory=list)
    held: Held | None = None
    doubts: list[str] = field(default_factory=list)

    @property
    def time(self) -> NDArray[np.float64]:
        """Seconds since the first sample."""
        return self.channels["time"].si

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self.channels["time"].raw.size)

    def row(self, of_file: int) -> int:
        """The row that a row of the file became."""
        return of_file if self.held is None else self.held.row_of(of_file, self.time)

    def rows_in_file(self, rows: slice) -> slice:
        """The rows of the file that some rows were made of."""
        return rows if self.held is None else self.held.rows_in_file(rows, self.time)

    def rate_asked_for(self, rate: float | None) -> float | None:
        """The sample rate of the mapping; None where it is that of a log whose rows repeat values."""
        if self.held is None or rate is None or abs(self.held.rate / rate - 1.0) > _OTHER_RATE:
            return rate
        return None

    def keep(self, rows: NDArray[np.bool_] | slice) -> None:
        """Keep the rows chosen."""
        self.channels = {name: channel.taken(rows) for name, channel in self.channels.items()}


def read_table(mapping: Mapping, wanted: Table[str, ChannelMapping], files: Files, where: str) -> ChannelTable:
    """Read the channels of one recording, in the order of their mapping, and make one table of them.

    Raises
    ------
    ConfigurationError, RecordingError
        The mapping or the file is wrong.
    """
    linear = {"linear": True, "rotary": False, None: None if mapping.gearbox.ratio == 1.0 else False}[
        mapping.gearbox.axis
    ]
    keys = {name: f"{where}: {_key(name)}" for name in wanted}
    others = {name: entry for name, entry in wanted.items() if name != "time"}
    as_read = {name: read_channel(name, entry, files, keys[name], linear) for name, entry in others.items()}
    sides = to_motor(as_read, others, mapping.gearbox.ratio, where)
    read = {name: fill_missing(channel, others[name].missing) for name, channel in as_read.items()}
    sizes = [channel.raw.size for name, channel in read.items() if not _constant(others[name])]
    if not sizes:
        raise ConfigurationError(f"{where}: every channel has a 'value', one besides the time should stand in a file.")
    size = sizes[0]
    for name in (name for name in read if _constant(others[name])):
        read[name] = read[name].taken(np.zeros(size, dtype=np.int64))
    clock = read_clock(wanted["time"], files, keys["time"], size)
    table = ChannelTable(
        {}, clock.started_at, _is_linear(read, wanted, where, linear), [*files.notes(), *clock.notes, *sides]
    )
    table.notes += [
        fill_note(name, channel.filled, channel.raw.size, channel.source.location(channel.filled[0]))
        for name, channel in as_read.items()
        if channel.filled
    ]
    table.doubts += [doubt for channel in (clock.channel, *as_read.values()) for doubt in channel.doubts]
    table.channels["time"] = clock.channel
    own_clocks = {name: entry for name, entry in others.items() if entry.time is not None}
    table.channels.update({name: channel for name, channel in read.items() if name not in own_clocks})
    _check_lengths(table, files.main)
    _check_rows(table, mapping.invalid_rows, files.main)
    if mapping.repeated == "leave_out":
        _leave_out_repeated(table, mapping.irregular)
    _regular(table, mapping, files.main)
    for name, entry in own_clocks.items():
        _join(table, name, read[name], entry, wanted["time"], files)
    _from_zero(table)
    add_motor_angle(table.channels, table.notes, ratio=mapping.gearbox.ratio, linear=table.linear)
    return table


def _constant(wanted: ChannelMapping) -> bool:
    """Whether nothing of a channel stands in a file."""
    return all(part.value is not None for part in wanted.sum or (wanted,))


def _key(name: str) -> str:
    return name.replace("/", ".", 1) if name.startswith("aux/") else f"channels.{name}"


def _is_linear(read: dict[str, Channel], wanted: Table[str, ChannelMapping], where: str, linear: bool | None) -> bool:
    """Whether the units are those of a linear axis; refuse a mixture of both."""
    units = {name: channel.spec.unit for name, channel in read.items() if name in BY_NAME}
    mixed = mixture({name: (unit, wanted[name].unit) for name, unit in units.items()})
    if mixed is not None:
        raise ConfigurationError(f"{where}: {mixed}.")
    metric = [name for name, unit in units.items() if unit in LINEAR.values()]
    turning = [name for name, unit in units.items() if unit in LINEAR]
    if metric and turning:
        raise ConfigurationError(
            f"{where}: channels.{turning[0]} becomes {units[turning[0]]} and channels.{metric[0]} "
            f"{units[metric[0]]}; on a linear axis all should be of metres and newtons, 'factor' or "
            "'torque_constant' with a unit makes them so, such as '10 mm/rev' or '80 N/A'."
        )
    return bool(metric) or linear is True


def _check_lengths(table: ChannelTable, file: Path) -> None:
    lengths = {name: channel.raw.size for name, channel in table.channels.items()}
    shortest = min(lengths.values())
    longer = [name for name, length in lengths.items() if length == shortest + ONE_MORE]
    if shortest and longer and max(lengths.values()) == shortest + ONE_MORE:
        for name in longer:
            table.channels[name] = table.channels[name].taken(slice(shortest))
        table.notes.append(f"the last sample of {', '.join(longer)} was left out, the other channels have one less")
        return
    if len(set(lengths.values())) != 1:
        listed = ", ".join(f"{name} {length}" for name, length in lengths.items())
        raise RecordingError(
            f"{file}: the variables differ in length ({listed}), they should be equally long; a channel with a "
            "clock of its own has it in 'time'."
        )


def _check_rows(table: ChannelTable, invalid_rows: str, file: Path) -> None:
    """Find rows that no recording may hold, and drop or refuse them."""
    time = table.channels["time"]
    if table.size < _LEAST_ROWS:
        raise RecordingError(f"{file}: has {table.size} rows, a recording should have at least {_LEAST_ROWS}.")
    good = np.ones(table.size, dtype=bool)
    for name, channel in table.channels.items():
        finite = np.isfinite(channel.raw)
        if not finite.any():
            raise RecordingError(f"{file}: {name} holds no number in any sample; leave the channel out of the mapping.")
        if invalid_rows == "refuse" and not finite.all():
            index = int(np.argmin(finite))
            value = f"a fill value ({LEAST_FILL:g} or more)" if index in channel.filled else channel.raw[index]
            raise RecordingError(
                f"{file}: {name} is {value} in {channel.source.location(index)}, every sample should be a "
                f"number; missing = 'hold' or 'interpolate' of the channel fills it, invalid_rows = 'drop' "
                "leaves it out."
            )
        good &= finite
    stamps = np.where(good, time.si, -np.inf)
    later = in_order(stamps)
    if invalid_rows == "refuse" and not later.all():
        raise RecordingError(f"{file}: {why_not_in_order(time.si, time.source.location)}.")
    good &= later
    if good.all():
        return
    if not good.any():
        raise RecordingError(f"{file}: holds no row without NaN and with increasing time, such rows should be there.")
    if np.mean(~good) > _MOST_LEFT_OUT:
        raise RecordingError(f"{file}: {_too_many(table, later)}.")
    place = time.source.location(int(np.argmin(good)))
    table.notes.append(
        f"{int(np.sum(~good))} rows with NaN or without increasing time were left out, the first in {place}"
    )
    table.keep(good)


def _too_many(table: ChannelTable, later: NDArray[np.bool_]) -> str:
    """Say of which channel most of the rows would be left out, where the first stands, and what would be right."""
    finite = {name: np.isfinite(channel.raw) for name, channel in table.channels.items()}
    name = min(finite, key=lambda name: int(np.sum(finite[name])))
    whole = np.logical_and.reduce(list(finite.values()))
    late = whole & ~later
    what, right, first = (
        (
            f"{name} is no number in {int(np.sum(~finite[name]))}",
            f"missing = 'hold' or 'interpolate' of {name}, or a mapping without it",
            np.argmin(finite[name]),
        )
        if np.sum(~whole) > np.sum(late)
        else (
            f"time does not increase in {int(np.sum(late))}",
            "rows in the order of time, start and stop where the clock begins anew, or channels.time.rate",
            np.argmax(late),
        )
    )
    place = table.channels["time"].source.location(int(first))
    return (
        f"invalid_rows = 'drop' would leave out {int(np.sum(~(whole & later)))} of {table.size} rows, it should be "
        f"half of them at most: {what}, the first in {place}; {right} would be right"
    )


def _regular(table: ChannelTable, mapping: Mapping, file: Path) -> None:
    """Find gaps, and bring uneven stamps onto an even clock, or refuse them."""
    time = table.time
    if time.size <= _LEAST_ROWS:
        table.starts = [0]
        return
    found = evenness(time)
    if found.gaps.size and mapping.gaps == "refuse":
        raise RecordingError(
            f"{file}: {gap_sentence(time, found, table.channels['time'].source.location)}; gaps = 'cut' makes "
            "recordings of what stands between them."
        )
    table.starts = [0, *(int(index) for index in found.gaps)] if mapping.gaps == "cut" else [0]
    wanted = table.rate_asked_for(mapping.sample_rate)
    if (
        found.even
        and wanted is not None
        and abs(found.step * wanted - 1.0) > _OTHER_RATE
        and mapping.irregular != "keep"
    ):
        _at_rate_asked_for(table, found.step, wanted, mapping.irregular == "refuse", file)
        return
    moved = (table.channels[name].si for name in _MOVES if name in table.channels)
    by_stamps = found.even and found.shakes and mapping.irregular == "resample" and sampled_when_stamped(time, moved)
    if found.even and found.lost:
        table.notes.append(f"by the time stamps {found.lost} of {time.size + found.lost} samples are missing")
    if (found.even and not by_stamps) or mapping.irregular == "keep":
        if not found.even:
            table.notes.append(f"steps of time differ ({found.shortest:g} to {found.longest:g} s) and were kept so")
        return
    if mapping.irregular == "refuse":
        raise refuse_uneven(found, str(file))
    # files of one logger are brought onto one clock, though their stamps shake and rows are missing
    rate = wanted or _round(1.0 / found.mean)
    _resample(table, 1.0 / rate)
    table.notes.append(
        f"steps of time differ ({found.shortest:g} to {found.longest:g} s): all channels were brought onto an even "
        f"clock of {rate:g} Hz by straight lines"
    )


def _round(rate: float) -> float:
    """The roundest of the rates near one in Hz, as near as :data:`_NEAR` says; itself where there is none."""
    rounder = ((float(f"{rate:.{digits}g}"), near) for digits, near in _NEAR.items())
    return next((r for r, near in rounder if abs(r / rate - 1.0) < near), rate)


def _at_rate_asked_for(table: ChannelTable, step: float, wanted: float, refuse: bool, file: Path) -> None:
    """Bring channels whose stamps are even, but at another rate than the mapping says, onto that rate."""
    if refuse:
        raise RecordingError(
            f"{file}: sample_rate is {wanted:g} Hz and the stamps are {1.0 / step:.6g} Hz, they should agree; "
            "irregular = 'resample' brings the channels onto the rate asked for."
        )
    _resample(table, 1.0 / wanted)
    table.notes.append(
        f"the stamps are {1.0 / step:.6g} Hz: all channels were brought onto the {wanted:g} Hz asked for by straight "
        "lines"
    )


def _resample(table: ChannelTable, step: float) -> None:
    """Bring all channels onto an even clock, each stretch between gaps by itself; words are held, not interpolated."""
    time = table.time
    edges = [*table.starts, time.size]
    clocks = [even_clock(time[a:b], step) for a, b in itertools.pairwise(edges)]
    clock = np.concatenate(clocks)
    for name, channel in table.channels.items():
        table.channels[name] = _resample_channel(name, channel, time, clock)
    table.starts = [0, *(int(end) for end in np.cumsum([one_clock.size for one_clock in clocks])[:-1])]


def _resample_channel(name: str, channel: Channel, time: NDArray[np.float64], clock: NDArray[np.float64]) -> Channel:
    signal = BY_NAME.get(name)
    if name == "time":
        return channel.with_si(clock)
    if signal is not None and signal.quantity in _WORDS:
        rows = np.clip(np.searchsorted(time, clock, side="right") - 1, 0, time.size - 1)
        return channel.taken(rows)
    return channel.with_si(np.interp(clock, time, channel.si))


def _join(
    table: ChannelTable, name: str, channel: Channel, entry: ChannelMapping, common: ChannelMapping, files: Files
) -> None:
    """Bring a channel with a clock of its own onto the common one; what is outside of its time is cut off."""
    stamps = ChannelMapping(variable=entry.time, unit=common.unit, timezone=common.timezone, file=entry.file)
    clock = read_clock(stamps, files, f"{files.main}: {name}.time", channel.raw.size)
    if clock.channel.raw.size != channel.raw.size:
        raise RecordingError(
            f"{files.main}: {name} has {channel.raw.size} samples and its time '{entry.time}' "
            f"{clock.channel.raw.size}, they should be equally many."
        )
    theirs = clock.channel.si
    why = why_not_in_order(theirs, channel.source.location)
    if why is not None:
        raise RecordingError(f"{files.main}: of {name}, {why}.")
    if clock.started_at is not None and table.started_at is not None:
        theirs = theirs + (clock.started_at - table.started_at).total_seconds()
    time = table.time
    inside = (time >= theirs[0]) & (time <= theirs[-1])
    if np.sum(inside) < _LEAST_ROWS:
        raise RecordingError(
            f"{files.main}: {name} was recorded from {theirs[0]:g} to {theirs[-1]:g} s and the others from "
            f"{time[0]:g} to {time[-1]:g} s, they should overlap."
        )
    if not inside.all():
        first = int(np.argmax(inside))
        kept = slice(first, first + int(np.sum(inside)))
        table.keep(kept)
        table.starts = [0, *(start - first for start in table.starts if kept.start < start < kept.stop)]
        table.notes.append(f"{int(np.sum(~inside))} rows outside of the time of {name} were left out")
    table.channels[name] = _resample_channel(name, channel, theirs, table.time)
    rate = 1.0 / float(np.median(np.diff(theirs)))
    table.notes.append(f"{name} has a clock of its own ({rate:.6g} Hz) and was brought onto the common one")


def _leave_out_repeated(table: ChannelTable, irregular: str) -> None:
    """Leave out the rows of a log that repeat what the drives said before; not where that makes a clock uneven that is
    to be kept.
    """
    found = held(table.channels)
    if found is None or (irregular != "resample" and not evenness(found.stamps[found.first]).even):
        return
    rate = 1.0 / float(np.median(np.diff(found.stamps[found.first])))
    table.channels = dict(thinned(table.channels, found))
    table.held = found
    table.notes.append(
        f"the file has {found.rate:.6g} rows a second, but new values only every {found.rows} rows ({rate:.4g} Hz): "
        "rows that repeat values were left out, repeated = 'keep' keeps them"
    )


def _from_zero(table: ChannelTable) -> None:
    """Count time from the first sample."""
    channel = table.channels["time"]
    raw: NDArray[Any] = channel.raw - channel.raw[0]
    table.channels["time"] = replace(channel, raw=raw, spec=replace(channel.spec, offset=0.0))
