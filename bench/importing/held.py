"""Logs with more rows than the drives gave values: rows that repeat the values before them are no samples.

A logger that asks every millisecond writes each value of a drive that answers every 15 ms fifteen times. Steps between
such values would be taken for noise, and repeated values for measurements that agree.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.importing.channel import Channel
from bench.importing.stamps import evenness
from bench.signals import BY_NAME

TORQUES = ("motor_torque", "load_torque")
"""channels whose noise makes every new value another one: the first that a file has tells the cycle"""
OF_DRIVES = ("angle", "velocity", "torque")
"""quantities whose new values may come at other rows than those of the torque: they are taken by straight lines between
these, for what swings within a cycle is otherwise compared with what was there before
"""
NOT_MEASURED = ("word", "count", "time")
FEWEST_CHANGES = 50
"""changes of value below which nothing is said of how often a channel is given a new one"""
EARLY = 0.01
"""share of the changes that may come sooner after the one before than the cycle, by more than one row"""
BETWEEN = 0.05
"""share of the changes that may come between whole cycles after the one before"""
JUMP = 0.5
"""step from one value to the next, over the range of all, from which an angle starts again at 0, and is not
interpolated
"""

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Held:
    """A log whose rows repeat what the drives said.

    ``rows``: rows of a cycle; ``first`` (m,): row of each new value; ``stamps`` (n,): time of each row of the log in s.
    """

    rows: int
    first: IntArray
    stamps: FloatArray

    @property
    def rate(self) -> float:
        """Rows of the log a second."""
        return 1.0 / float(np.median(np.diff(self.stamps)))

    def row_of(self, of_file: int, time: FloatArray) -> int:
        """Row of a table (its ``time`` (k,) begins at the first new value) that a row of the log became; beyond the
        table by as much as beyond the log.
        """
        if of_file >= self.stamps.size:
            return int(time.size + of_file - self.stamps.size)
        since = self.stamps[of_file] - self.stamps[self.first[0]]
        return int(np.searchsorted(time, since - 0.5 / self.rate))

    def rows_in_file(self, rows: slice, time: FloatArray) -> slice:
        """Rows of the log that some rows of a table were made of."""
        since = self.stamps - self.stamps[self.first[0]] + 0.5 / self.rate
        edges = np.append(np.searchsorted(since, time), self.stamps.size)
        edges[0] = 0
        return slice(int(edges[min(rows.start, time.size)]), int(edges[min(rows.stop, time.size)]))


def held(channels: Mapping[str, Channel]) -> Held | None:
    """Find out whether each value is repeated for some rows, in every measured channel that changes often enough to
    tell; None where one has new values at other rows, or where nothing was recorded for a while.

    A quantity that changes slowly repeats its values as well, now for few rows and now for many: a cycle is told by
    that no value comes sooner, and hardly one between two cycles. Of channels without a torque nothing is said: an
    encoder that turns evenly changes at even distances by itself.
    """
    measured = {name: channel for name, channel in channels.items() if _quantity(name) not in NOT_MEASURED}
    changes = {name: _changes(channel) for name, channel in measured.items()}
    changes = {name: at for name, at in changes.items() if at.size >= FEWEST_CHANGES}
    torque = next((name for name in TORQUES if name in changes), None)
    if torque is None:
        return None
    rows = int(np.median(np.diff(changes[torque])))
    stamps = channels["time"].si
    if rows < 2 or not all(_cycles(np.diff(at), rows) for at in changes.values()) or evenness(stamps).gaps.size:
        return None
    return Held(rows, _refreshed(changes[torque], stamps.size, rows), stamps)


def _cycles(distances: IntArray, rows: int) -> bool:
    """Whether changes come whole cycles after one another; a cycle may be a row longer or shorter than it is."""
    within = 1 if rows > 3 else 0
    off = np.abs(distances - rows * np.maximum(np.round(distances / rows), 1.0))
    return bool(np.mean(distances < rows - within) <= EARLY and np.mean(off > within) <= BETWEEN)


def thinned(channels: Mapping[str, Channel], found: Held) -> Iterator[tuple[str, Channel]]:
    """The channels with a row for each new value. Those of the drives are taken by straight lines between their own new
    values, but for an angle that starts again; of all others the rows are taken.
    """
    for name, channel in channels.items():
        at, quantity = _changes(channel), _quantity(name)
        if quantity in OF_DRIVES and at.size >= FEWEST_CHANGES:
            fresh = _refreshed(at, channel.raw.size, found.rows)
            values = channel.si[fresh]
            largest = float(np.max(np.abs(np.diff(values))))
            if quantity != "angle" or largest < JUMP * float(np.ptp(values)):
                yield name, channel.with_si(np.interp(found.first, fresh, values))
                continue
        yield name, channel.taken(found.first)


def _quantity(name: str) -> str:
    return BY_NAME[name].quantity if name in BY_NAME else ""


def _changes(channel: Channel) -> IntArray:
    """Rows at which a channel has another value than in the row before."""
    return np.asarray(np.flatnonzero(np.diff(channel.raw) != 0) + 1, dtype=np.int64)


def _refreshed(changes: IntArray, size: int, rows: int) -> IntArray:
    """Rows at which a channel of ``size`` rows was given a value: where it changed, and where it was given the same one
    again.
    """
    before = np.arange(changes[0] % rows, changes[0], rows)
    lengths = np.diff(np.append(changes, size))
    parts = [
        a + np.arange(n) * length // n
        for a, length in zip(changes, lengths, strict=True)
        for n in [max(1, round(length / rows))]
    ]
    return np.concatenate([before, *parts]).astype(np.int64)
