"""One tone in several channels is one thing: a fan, a pump or a machine next door shakes the whole bench."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bench.mismatch import criteria
from bench.mismatch.discovery import UNNAMED, ChannelOutcome, Discovery
from bench.mismatch.recordings.vibration import SEGMENTS_S

FREQUENCY, HERTZ = "f", "Hz"
"""symbol and unit of a tone's frequency"""

RESOLUTION = 1.0 / SEGMENTS_S[0]
"""Hz, of the spectra: two lines closer than that are one"""


def shared_tones(outcomes: Sequence[ChannelOutcome]) -> dict[str, str]:
    """Channel (the first of those alike) with which each channel shares a tone that has no name, by channel.

    Two tones are one where their frequencies agree within what both are known to, and what spectra can tell apart.
    """
    tones_of = {o.channel: tones for o in outcomes if (tones := [_frequency(d) for d in o.discoveries if _is_tone(d)])}
    shared: dict[str, str] = {}
    for channel, tones in tones_of.items():
        others = [c for c in shared if any(_alike(a, b) for a in tones for b in tones_of[c])]
        shared[channel] = shared[others[0]] if others else channel
    return shared


def _is_tone(found: Discovery) -> bool:
    return found.effect == UNNAMED and any(p["symbol"] == FREQUENCY and p["unit"] == HERTZ for p in found.parameters)


def _frequency(found: Discovery) -> tuple[float, float]:
    """Frequency and its standard deviation, Hz."""
    parameter = next(p for p in found.parameters if p["symbol"] == FREQUENCY)
    return float(parameter["value"]), float(parameter["std"])


def _alike(one: tuple[float, float], other: tuple[float, float]) -> bool:
    return abs(one[0] - other[0]) <= max(RESOLUTION, criteria.SURE * math.hypot(one[1], other[1]))
