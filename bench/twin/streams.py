"""What is looked at in a recording: one number of each recording and stream.

Torques and transmission error at one operating point: the mean of what the model leaves, the same times the direction,
its variance. Of the transmission error also the amplitude at each order and the mean in each window of the input angle,
where a whole revolution was turned. Of the temperature: where it is at the end, from where it was at the beginning.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch.recordings.rows import Rows
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR

AT_ONE_POINT = ("constant_velocity", "validation")
"""kinds of recordings that are compared: one speed, one load"""
WINDOWS = 72
"""windows of the input angle, 5° each"""
PROFILE = 32 * WINDOWS
"""parts of a revolution by which what is left is averaged"""
LOW_ORDERS = 30
"""orders up to here are looked at whether the model has them or not"""
TURNED = 0.995
"""revolutions that have to be turned for orders and windows"""
END_S = 6.0
"""last seconds of a recording whose mean temperature is compared"""
FEWEST = 10
"""rows of a channel that are compared, at least"""

MEAN, OFFSET, DIRECTION, SPREAD = "mean", "offset", "direction", "spread"
ORDER, WINDOW, END = "order", "window", "end"


@dataclass(frozen=True, slots=True)
class Stream:
    """A channel, what of it, and which one: order, window, or the direction of a mean.

    The mean of a recording is measured (``MEAN``) and looked at twice: as it is (``OFFSET``) and times the direction.
    """

    channel: str
    what: str
    number: int = 0

    @property
    def signed(self) -> bool:
        """Whether its number has a sign that means something."""
        return self.what != ORDER

    @property
    def words(self) -> str:
        """What it is, for people."""
        return {
            MEAN: f"its mean {'forwards' if self.number > 0 else 'backwards'}",
            OFFSET: "its mean",
            DIRECTION: "its mean along the direction",
            SPREAD: "its scatter",
            ORDER: f"order {self.number}",
            WINDOW: f"input angle {self.number * 360 // WINDOWS}° to {(self.number + 1) * 360 // WINDOWS}°",
            END: "its course",
        }[self.what]


_SHARES: dict[str, float] = {OFFSET: 0.3, DIRECTION: 0.3, SPREAD: 0.1, ORDER: 0.15, WINDOW: 0.15, END: 1.0}


def streams(channels: Iterable[str], orders: Sequence[int]) -> dict[Stream, float]:
    """The streams of some channels, each with its weight; the weights sum to 1, each channel has the same."""
    out: dict[Stream, float] = {}
    present = [c for c in (TRANSMISSION_ERROR, MOTOR_TORQUE, LOAD_TORQUE, TEMPERATURE) if c in set(channels)]
    for channel in present:
        by_kind: dict[str, list[Stream]] = {END: [Stream(channel, END)]}
        if channel != TEMPERATURE:
            by_kind = {what: [Stream(channel, what)] for what in (OFFSET, DIRECTION, SPREAD)}
        if channel == TRANSMISSION_ERROR:
            by_kind[ORDER] = [Stream(channel, ORDER, f) for f in orders]
            by_kind[WINDOW] = [Stream(channel, WINDOW, k) for k in range(WINDOWS)]
        total = sum(_SHARES[what] for what in by_kind) * len(present)
        for what, listed in by_kind.items():
            for stream in listed:
                out[stream] = _SHARES[what] / total / len(listed)
    return out


def looked_at_orders(model_orders: Iterable[float]) -> tuple[int, ...]:
    """Orders of the model that are whole numbers, and all low ones."""
    whole = {round(f) for f in model_orders if abs(f - round(f)) < 1e-9 and 0 < f < PROFILE // 4}
    return tuple(sorted(whole | set(range(1, LOW_ORDERS + 1))))


def measure(channel: str, left: FloatArray, rows: Rows, orders: Sequence[int]) -> Mapping[Stream, float]:
    """The numbers of one channel of one recording; of an order its amplitude, never below 0.

    ``left`` (n,): measured less predicted at ``rows``, in the channel's unit.
    """
    frame = rows.frame
    counts = (rows.number > 0) & np.isfinite(left)
    if channel == TEMPERATURE:
        chosen = np.flatnonzero((frame.elapsed >= frame.elapsed[-1] - END_S) & counts)
        return {Stream(channel, END): float(left[chosen].mean())} if chosen.size else {}
    chosen = np.flatnonzero((frame.steady > 0.5) & counts & (frame.direction != 0))
    if chosen.size < FEWEST:
        return {}
    values, weight = left[chosen], rows.number[chosen] / rows.number[chosen].sum()
    mean, side = float(weight @ values), float(np.sign(frame.direction[chosen].sum()))
    if side == 0.0:
        return {}
    out = {
        Stream(channel, MEAN, int(side)): mean,
        Stream(channel, SPREAD): float(weight @ (values - mean) ** 2),
    }
    turned = float(np.ptp(frame.theta[chosen])) / (2.0 * np.pi)
    if channel == TRANSMISSION_ERROR and turned >= TURNED:
        profile = _profile(frame.theta[chosen], values - mean)
        lines = np.abs(np.fft.rfft(profile)) * 2.0 / profile.size
        out |= {Stream(channel, ORDER, f): float(lines[f]) for f in orders}
        windows = profile.reshape(WINDOWS, -1).mean(axis=1)
        out |= {Stream(channel, WINDOW, k): float(v) for k, v in enumerate(windows)}
    return out


def _profile(theta: FloatArray, values: FloatArray) -> FloatArray:
    """Means (PROFILE,) over parts of the revolution; parts without a sample are interpolated."""
    place = np.floor(np.mod(theta, 2.0 * np.pi) * (PROFILE / (2.0 * np.pi))).astype(np.int64) % PROFILE
    number = np.bincount(place, minlength=PROFILE)
    total = np.bincount(place, weights=values, minlength=PROFILE)
    have = np.flatnonzero(number)
    return np.asarray(np.interp(np.arange(PROFILE), have, total[have] / number[have], period=PROFILE))
