"""Rows made of recordings, one after another.

Three reductions of the same recordings: slow rows (a quarter of a second, finer after reversals) for the torques and
the offset of the transmission error; angle rows (some 5,000 a revolution, finer than any order of the simulation) for
its harmonics; and rows of two seconds for the heat balance.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.lines import OrderSpectrum, order_spectrum
from bench.mismatch.motor_ripple import ShaftSpectrum, shaft_spectrum
from bench.mismatch.prepare import Prepared, block_edges, block_mean, reduce
from bench.mismatch.rows import Rows
from bench.mismatch.tones import ToneSpectrum, tone_spectrum
from bench.simulation.frame import FloatArray, Frame, IntArray

SLOW_S = 0.25
LIVELY_S = 0.02
HEAT_S = 2.0
ANGLE_STEP = 1.2e-3
ANGLE_STEP_S = 0.1


def _rows(prepared: Prepared, reduced: Frame, edges: IntArray, channel: str, inner: FloatArray) -> Rows:
    own = prepared.measured[channel]
    mean, number = block_mean(own.mean, own.number, edges)
    square = np.add.reduceat(inner**2 * own.number + own.scatter, edges)
    return Rows(reduced, mean, number, square / np.maximum(number - 1.0, 1.0))


def _angle_rows(prepared: Prepared) -> Rows:
    """Rows over the angle, with how the samples inside a row follow the angle: fast orders move within a row."""
    edges = _angle_edges(prepared)
    inner = _inside(prepared, "transmission_error", edges)
    rows = _rows(prepared, reduce(prepared.frame, edges), edges, "transmission_error", inner)
    count = prepared.measured["transmission_error"].number
    angle, _ = block_mean(prepared.frame.theta, count, edges)
    turned = np.where(count > 0, prepared.frame.theta - np.repeat(angle, np.diff(np.append(edges, count.size))), 0.0)
    number = np.maximum(rows.number, 1.0)
    lean = np.add.reduceat(inner * turned * count + prepared.leaning, edges) / number
    sweep = np.add.reduceat(turned**2 * count + prepared.swept, edges) / number
    return replace(rows, lean=lean, sweep=sweep)


def _inside(prepared: Prepared, channel: str, edges: IntArray) -> FloatArray:
    """The deviations from their block's mean that the simulation does not explain; 0 where nothing is valid."""
    own = prepared.measured[channel]
    valid = own.number > 0
    mean, _ = block_mean(own.mean, own.number, edges)
    width = np.diff(np.append(edges, valid.size))
    inner = np.where(valid, own.mean - np.repeat(mean, width), 0.0)
    return np.where(valid, inner - _explained_inside(prepared, channel, inner, valid, edges, width), 0.0)


def _explained_inside(
    prepared: Prepared,
    channel: str,
    inner: FloatArray,
    valid: NDArray[np.bool_],
    edges: IntArray,
    width: IntArray,
) -> FloatArray:
    """What the simulation's own quantities explain of the deviations from their block's mean.

    A speed that wavers faster than a block accelerates the inertia: that is no noise.
    """
    names = {
        "motor_torque": ("acceleration", "torque", "velocity"),
        "load_torque": ("load_acceleration", "load_motor_torque"),
        "transmission_error": ("torque", "velocity"),
    }.get(channel, ())
    if not names:
        return np.zeros(inner.size)
    parts = []
    for name in names:
        values = getattr(prepared.frame, name)
        average = np.add.reduceat(values, edges) / width
        parts.append(values - np.repeat(average, width))
    design = np.array(parts)
    scale = np.maximum(np.sqrt(np.mean(design**2, axis=1)), 1e-30)
    design /= scale[:, None]
    chosen = valid & (np.abs(inner) < 6.0 * max(float(np.std(inner[valid])) if valid.any() else 1.0, 1e-30))
    told = design[:, chosen]
    normal = told @ told.T + 1e-6 * max(float(chosen.sum()), 1.0) * np.eye(len(names))
    return np.asarray(np.linalg.solve(normal, told @ inner[chosen]) @ design)


def _angle_edges(prepared: Prepared) -> IntArray:
    frame = prepared.frame
    smooth = np.abs(frame.velocity) / prepared.sample_rate / ANGLE_STEP
    number = np.floor(np.cumsum(np.maximum(smooth, 1.0 / (ANGLE_STEP_S * prepared.sample_rate))))
    change = np.diff(number) != 0
    change |= np.diff(prepared.label) != 0
    change |= np.diff(frame.direction) != 0
    return np.concatenate(([0], np.flatnonzero(change) + 1)).astype(np.int64)


@dataclass(slots=True)
class Collected:
    """Rows of the recordings read so far."""

    slow: dict[str, list[Rows]] = field(default_factory=dict)
    heat: list[Rows] = field(default_factory=list)
    angle: list[Rows] = field(default_factory=list)
    shaft: list[ShaftSpectrum] = field(default_factory=list)
    tones: dict[str, list[ToneSpectrum]] = field(default_factory=dict)
    lines: dict[str, list[OrderSpectrum]] = field(default_factory=dict)

    def add(self, prepared: Prepared, channels: frozenset[str]) -> None:
        """Reduce a recording to rows of the channels in which it can be compared."""
        edges = block_edges(prepared, SLOW_S, LIVELY_S)
        reduced = reduce(prepared.frame, edges)
        for channel in channels & set(prepared.measured) - {"temperature"}:
            self._listen(prepared, channel)
            if channel == "transmission_error":
                continue  # it has rows over the angle
            inner = _inside(prepared, channel, edges)
            self.slow.setdefault(channel, []).append(_rows(prepared, reduced, edges, channel, inner))
            if channel == "motor_torque":
                spectrum = shaft_spectrum(prepared, prepared.measured[channel].mean - inner)
                if spectrum is not None:
                    self.shaft.append(spectrum)
        if "temperature" in channels and "temperature" in prepared.measured:
            width = max(1, round(HEAT_S * prepared.sample_rate))
            edges = np.arange(0, prepared.frame.size, width)
            inner = _inside(prepared, "temperature", edges)
            self.heat.append(_rows(prepared, reduce(prepared.frame, edges), edges, "temperature", inner))
        driven = prepared.kind != "heating"
        if "transmission_error" in channels and "transmission_error" in prepared.measured and driven:
            self.angle.append(_angle_rows(prepared))

    def travelled_before(self, distance: float) -> None:
        """Count the distance run before these recordings, rad at the output."""
        for rows in (*self.slow.values(), self.heat, self.angle):
            rows[:] = [replace(r, frame=replace(r.frame, travel=r.frame.travel + distance)) for r in rows]

    def take(self, other: Collected) -> None:
        """Append the rows of further recordings."""
        for channel, rows in other.slow.items():
            self.slow.setdefault(channel, []).extend(rows)
        for channel, heard in other.tones.items():
            self.tones.setdefault(channel, []).extend(heard)
        for channel, seen in other.lines.items():
            self.lines.setdefault(channel, []).extend(seen)
        self.heat += other.heat
        self.angle += other.angle
        self.shaft += other.shaft

    def _listen(self, prepared: Prepared, channel: str) -> None:
        frame, own, thinning = prepared.frame, prepared.measured[channel], prepared.thinning
        size = own.samples.size
        steady = (frame.steady > 0.5) & (frame.direction != 0)
        valid = own.valid & thinning.spread(own.number > 0, size)
        rate = prepared.sample_rate * thinning.group
        velocity = thinning.spread(frame.velocity, size)
        index = int(frame.recording[0])
        heard = tone_spectrum(index, own.samples, valid, thinning.spread(steady, size), rate, velocity)
        if heard is not None:
            self.tones.setdefault(channel, []).append(heard)
        if channel != "transmission_error":  # whose orders are seen when the series has been taken off
            line = order_spectrum(index, own.mean, own.number > 0, steady, prepared.sample_rate, frame.theta)
            if line is not None:
                self.lines.setdefault(channel, []).append(line)
