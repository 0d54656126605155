"""Ranges of channels, read block by block, and the units people read them in."""

from __future__ import annotations

import math

import numpy as np

from bench.errors import RecordingError
from bench.recording.reader import Recording

_BLOCK_ROWS = 1 << 20

_SHOWN: dict[str, tuple[str, float]] = {"rad": ("°", math.degrees(1.0)), "rad/s": ("°/s", math.degrees(1.0))}


def shown_unit(unit: str) -> tuple[str, float]:
    """Give the unit shown to people in place of an SI unit, and the factor to it: degrees for radians."""
    return _SHOWN.get(unit, (unit, 1.0))


def channel_ranges(recording: Recording) -> dict[str, tuple[float, float, float]]:
    """Give minimum, mean and maximum of every channel in SI, NaN samples left out.

    NaN where there is no other sample, or where the channel cannot be read (validation says why).
    """
    return {name: _range(recording, name) for name in recording.channels}


def _range(recording: Recording, name: str) -> tuple[float, float, float]:
    low, high, total, count = math.inf, -math.inf, 0.0, 0
    for start in range(0, recording.size, _BLOCK_ROWS):
        try:
            values = recording.si(name, start, min(start + _BLOCK_ROWS, recording.size))
        except RecordingError:
            return math.nan, math.nan, math.nan
        values = values[~np.isnan(values)]
        if values.size:
            low, high = min(low, float(values.min())), max(high, float(values.max()))
            total, count = total + float(values.sum()), count + values.size
    return (low, total / count, high) if count else (math.nan, math.nan, math.nan)
