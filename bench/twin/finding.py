"""What no longer holds: since which recording, in which channel, orders or angles, at which conditions, how much."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bench.simulation.frame import FloatArray
from bench.simulation.terms import CHANNEL_UNITS
from bench.twin.scale import measured_for
from bench.twin.streams import SPREAD, Stream
from bench.twin.watch import Seen, Watch

MOST = 5
"""streams that are named"""
ONE_SIDED = 0.85
"""share of the change's energy from which it is said to be at one kind of condition only"""
_FEWEST = 4
"""recordings of either side of a condition for it to be named"""


@dataclass(frozen=True, slots=True)
class Changed:
    """One stream that changed. ``size``: mean change since, in ``unit``; of an order its amplitude, never below 0;
    ``evidence``: log of the stream's own.
    """

    stream: Stream
    size: float
    unit: str
    evidence: float

    @property
    def words(self) -> str:
        """One line."""
        return f"{self.stream.channel.replace('_', ' ')}, {self.stream.words}: {self.size:+.3g} {self.unit}"


@dataclass(frozen=True, slots=True)
class Finding:
    """Why the model no longer holds. ``since``: index in ``Watch.seen`` of the likeliest first recording with the
    change; ``noticed``: after which one it was said; ``streams`` the most telling first; ``conditions`` in words.
    """

    since: int
    noticed: int
    streams: tuple[Changed, ...]
    conditions: tuple[str, ...]


def found(watch: Watch) -> Finding | None:
    """Where and since when, as far as the recordings seen so far show; None while the model holds."""
    if watch.alarmed is None:
        return None
    ranked = sorted(watch.evidence, key=lambda s: -watch.evidence[s].log)
    first = watch.evidence[ranked[0]].since()
    assert first is not None
    since = len(watch.seen) - watch.tested + first - 1
    # of the others those with half the strongest's evidence, named once: a mean and the same along the direction differ
    least = 0.5 * watch.evidence[ranked[0]].log
    kept: list[Stream] = []
    for stream in ranked:
        same = any(measured_for(stream) == measured_for(other) for other in kept)
        if watch.evidence[stream].log >= least and not same:
            kept.append(stream)
    changed = tuple(_change_of_stream(watch, stream, since) for stream in kept[:MOST])
    return Finding(since, watch.alarmed, changed, tuple(_conditions(watch, ranked[0], since)))


def _change_of_stream(watch: Watch, stream: Stream, since: int) -> Changed:
    scale = watch.scales[stream]
    offs = [off for seen in watch.seen[since:] if (off := scale.change(seen.values)) is not None]
    unit = CHANNEL_UNITS[stream.channel]
    return Changed(
        stream,
        float(np.mean(offs)) if offs else float("nan"),
        f"{unit}²" if stream.what == SPREAD else unit,
        watch.evidence[stream].log,
    )


def _load(seen: Seen) -> float:
    return seen.recording.setpoint.load_torque


def _speed(seen: Seen) -> float:
    return seen.recording.setpoint.velocity


_CONDITIONS: tuple[tuple[str, str, Callable[[Seen], float]], ...] = (
    ("forwards", "backwards", lambda seen: np.sign(_speed(seen))),
    ("loaded forwards", "loaded backwards", lambda seen: np.sign(_load(seen))),
    ("at high load", "at low load", lambda seen: abs(_load(seen))),
    ("fast", "slow", lambda seen: abs(_speed(seen))),
    ("warm", "cold", lambda seen: seen.recording.setpoint.temperature),
)


def _conditions(watch: Watch, stream: Stream, since: int) -> list[str]:
    """Conditions to which the change is confined: one half of the recordings since has nearly all of its energy."""
    with_stream = [one for one in watch.seen[since:] if stream in one.innovations]
    energy = np.array([one.innovations[stream] ** 2 for one in with_stream])
    words = []
    for high, low, of in _CONDITIONS:
        values = np.array([of(one) for one in with_stream])
        side = _sides(values)
        if side is None or min((side > 0).sum(), (side < 0).sum()) < _FEWEST:
            continue
        up, down = float(energy[side > 0].mean()), float(energy[side < 0].mean())
        if max(up, down) > ONE_SIDED * (up + down):
            words.append(high if up > down else low)
    return words


def _sides(values: FloatArray) -> FloatArray | None:
    """+1 above the middle of the values, −1 below, 0 at it; None where they hardly differ or are not known."""
    if values.size == 0 or not np.isfinite(values).all() or np.ptp(values) <= 1e-9:
        return None
    middle = 0.0 if values.min() < 0.0 < values.max() else float(np.median(values))
    return np.sign(values - middle)


def names(streams: Sequence[Changed]) -> str:
    """Names of the streams, as part of a sentence."""
    return "; ".join(changed.words for changed in streams)
