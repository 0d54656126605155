"""Logs with more rows than the drive gave values: rows that repeat the values before them are no samples.

A logger that asks every millisecond writes each value of a drive that answers every 15 ms fifteen times. Steps between
such values would be taken for noise, and repeated values for measurements that agree.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.importing.channel import Channel

DRIVE = ("motor_angle", "load_angle", "motor_velocity", "load_velocity", "motor_torque", "load_torque")
"""channels that change with every sample of a machine that moves: others (a thermometer) may be slower"""
TORQUES = ("motor_torque", "load_torque")
FEWEST_CHANGES = 50
"""changes of value below which nothing is said of how often a channel is given a new one"""
EARLY = 0.01
"""share of the changes that may come sooner after the one before than the drive's cycle, but for one row"""

IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Held:
    """Rows that hold the values before them: a new one comes every ``rows`` rows; ``first`` row of each new value of
    the channel that the others are brought to (M,).
    """

    rows: int
    first: IntArray
    size: int
    """rows of the log"""

    def of_file(self, row: int) -> int:
        """The row of the thinned table that a row of the log belongs to."""
        return self.first.size if row >= self.size else int(np.searchsorted(self.first, row))

    def in_file(self, rows: slice) -> slice:
        """The rows of the log that some rows of the thinned table were made of."""
        edges = np.append(self.first, self.size)
        return slice(int(edges[rows.start]), int(edges[rows.stop]))


def held(channels: Mapping[str, Channel]) -> Held | None:
    """Find out whether each value is repeated for some rows in every channel of the drives; None where one has new
    values at any row.

    A quantity that changes slowly repeats its values as well, now and then for few rows and now and then for many: a
    drive's cycle is told by that no value comes sooner, of any channel. Of channels without a torque nothing is said:
    an encoder that turns evenly changes at even distances by itself.
    """
    changes = {name: np.flatnonzero(np.diff(channels[name].raw) != 0) + 1 for name in DRIVE if name in channels}
    changes = {name: at for name, at in changes.items() if at.size >= FEWEST_CHANGES}
    torque = next((name for name in TORQUES if name in changes), None)
    if torque is None:
        return None
    rows = int(np.median(np.diff(changes[torque])))
    if rows < 2 or any(np.mean(np.diff(at) < max(rows - 1, 2)) > EARLY for at in changes.values()):
        return None
    size = channels[torque].raw.size
    return Held(rows, _refreshed(changes[torque], size, rows), size)


def thinned(channels: Mapping[str, Channel], found: Held) -> Iterator[tuple[str, Channel]]:
    """The channels with a row for each new value. Those of the drives are taken by straight lines between their own new
    values, which may come at other moments; of all others, the time among them, the rows are taken.
    """
    for name, channel in channels.items():
        at = np.flatnonzero(np.diff(channel.raw) != 0) + 1
        if name in DRIVE and at.size >= FEWEST_CHANGES:
            fresh = _refreshed(at, channel.raw.size, found.rows)
            yield name, channel.with_si(np.interp(found.first, fresh, channel.si[fresh]))
        else:
            yield name, channel.taken(found.first)


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
