"""Where a finding shows: ranges of speed, load, temperature and time that hold most of its energy, in words and
numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

import numpy as np

from bench.simulation.frame import FloatArray, Frame

BINS = 48


@dataclass(slots=True)
class Location:
    """The report's location of a finding; units as in the mismatch report."""

    text: str
    conditions: dict[str, Any]
    orders: list[float] = field(default_factory=list)
    angle_windows: list[list[float]] = field(default_factory=list)
    time_window: list[str] | None = None
    recordings: list[str] = field(default_factory=list)
    share_of_excess: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """The location as the report has it."""
        return {
            "text": self.text,
            "conditions": self.conditions,
            "orders": self.orders,
            "angle_windows": self.angle_windows,
            "time_window": self.time_window,
            "recordings": self.recordings,
            "share_of_excess": round(float(self.share_of_excess), 4),
        }


def _range(values: FloatArray) -> list[float]:
    return [float(np.min(values)), float(np.max(values))] if values.size else [0.0, 0.0]


def _energetic(values: FloatArray, energy: FloatArray, count: FloatArray) -> list[float]:
    """Smallest interval at one or both ends of the values' range outside of which the energy a sample is low."""
    low, high = np.percentile(values, [1, 99])
    if high <= low:
        return [float(low), float(high)]
    edges = np.linspace(low, high, BINS + 1)
    number = np.clip(np.digitize(values, edges) - 1, 0, BINS - 1)
    weight = np.bincount(number, count, BINS)
    mean = np.bincount(number, energy * count, BINS) / np.maximum(weight, 1e-12)
    mean[weight == 0] = 0.0
    strong = np.flatnonzero(mean > 0.12 * mean.max())
    if strong.size == 0:
        return [float(low), float(high)]
    return [float(edges[strong[0]]), float(edges[strong[-1] + 1])]


def conditions(frame: Frame, effect: FloatArray, variables: Sequence[str]) -> dict[str, Any]:
    """Ranges in which ``effect`` (what the finding contributes at the rows) has its energy.

    A quantity the effect does not depend on keeps the whole range of the recordings.
    """
    energy = effect**2
    speed = np.abs(frame.velocity)
    quantities = {
        "velocity": (speed, {"speed", "velocity", "order_frequency"}),
        "load_torque": (frame.torque, {"torque", "torque_path", "load_motor_torque"}),
        "temperature": (frame.temperature, {"temperature"}),
    }
    out: dict[str, Any] = {}
    for name, (values, own) in quantities.items():
        dependent = bool(own & set(variables))
        out[name] = _energetic(values, energy, frame.count) if dependent else _range(values)
    if out["velocity"][0] < 0.15 * out["velocity"][1]:
        out["velocity"][0] = 0.0
    forward = float(np.sum(energy[frame.last_direction > 0])) / max(
        float(np.sum(frame.count[frame.last_direction > 0])), 1.0
    )
    backward = float(np.sum(energy[frame.last_direction < 0])) / max(
        float(np.sum(frame.count[frame.last_direction < 0])), 1.0
    )
    total = max(forward + backward, 1e-300)
    out["direction"] = "positive" if forward / total > 0.93 else "negative" if backward / total > 0.93 else "both"
    return out


def strongest(frame: Frame, effect: FloatArray, names: dict[int, str], most: int = 5) -> list[str]:
    """Recordings in which the effect's mean energy is highest."""
    energy = np.bincount(frame.recording, effect**2 * frame.count)
    number = np.bincount(frame.recording, frame.count)
    mean = energy / np.maximum(number, 1.0)
    order = np.argsort(-mean)
    return [names[int(r)] for r in order[:most] if int(r) in names and mean[r] > 0]


def time_window(frame: Frame, effect: FloatArray, campaign_start: float) -> list[str]:
    """The two times between which the effect has most of its energy."""
    energy = np.cumsum((effect - effect.min()) ** 2 * frame.count)
    if energy[-1] <= 0:
        return [_iso(campaign_start + float(frame.time[0])), _iso(campaign_start + float(frame.time[-1]))]
    a = int(np.searchsorted(energy, 0.02 * energy[-1]))
    b = int(np.searchsorted(energy, 0.98 * energy[-1]))
    return [
        _iso(campaign_start + float(frame.time[a])),
        _iso(campaign_start + float(frame.time[min(b, frame.size - 1)])),
    ]


def _iso(posix: float) -> str:
    return datetime.fromtimestamp(posix, UTC).isoformat(timespec="seconds").replace("+00:00", "Z")


def text(
    where: dict[str, Any], variables: Sequence[str], orders: Sequence[float], windows: Sequence[Sequence[float]]
) -> str:
    """The location in words, for people: degrees and degrees a second."""
    parts: list[str] = []
    if orders:
        parts.append("at order" + ("s " if len(orders) > 1 else " ") + ", ".join(f"{f:g}" for f in orders))
    if windows:
        parts.append("at " + ", ".join(f"{np.degrees(a):.1f} to {np.degrees(b):.1f}°" for a, b in windows) + " of θ")
    names = set(variables)
    if names & {"speed", "velocity", "order_frequency"}:
        a, b = np.degrees(where["velocity"])
        parts.append(f"{a:.2f} to {b:.2f} deg/s")
    if names & {"torque", "torque_path", "load_motor_torque"}:
        parts.append(f"{where['load_torque'][0]:.0f} to {where['load_torque'][1]:.0f} N·m")
    if "temperature" in names:
        parts.append(f"{where['temperature'][0]:.1f} to {where['temperature'][1]:.1f} °C")
    if "time" in names:
        parts.append("through the campaign's time")
    if names & {"since_reversal", "transient"}:
        parts.append("just after a start, a reversal or a change of the loss")
    if "elapsed" in names:
        parts.append("in the time after a recording's start")
    if "speeding_up" in names:
        parts.append("where the speed changes")
    if "torque_rate" in names:
        parts.append("where the load changes")
    parts.append("both directions" if where["direction"] == "both" else f"{where['direction']} direction")
    return ", ".join(parts)
