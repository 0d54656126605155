"""What is drawn of a finding, before and after, at the place where it shows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from bench.mismatch.columns import RIPPLE_ORDERS
from bench.mismatch.drawing import Pair, drawn
from bench.mismatch.findings import Finding
from bench.mismatch.harmonics import Harmonics
from bench.mismatch.linear import ChannelModel, Found, predict, predict_named
from bench.mismatch.motor_ripple import Ripple
from bench.mismatch.peaks import Peak
from bench.mismatch.rows import Rows
from bench.mismatch.spectrum import states, turns
from bench.mismatch.transmission import TransmissionModel
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.laws import Law

if TYPE_CHECKING:
    from bench.mismatch.channels import Analysis
    from bench.mismatch.dataset import Dataset
    from bench.mismatch.evaluate import Scores

PULSE_BIN_DEG = 0.1
_BEYOND = 2.5
"""how far beyond its place a finding over speed is drawn"""
UNITS: dict[str, tuple[str, float]] = {
    "transmission_error": ("µrad", 1e6),
    "motor_torque": ("N·m", 1.0),
    "load_torque": ("N·m", 1.0),
    "temperature": ("K", 1.0),
}


# variable of a finding -> axis label, values, logarithmic
_AXES: dict[str, tuple[str, Callable[[Frame], FloatArray], bool]] = {
    "speed": ("speed / (deg/s)", lambda f: np.degrees(np.abs(f.velocity)), False),
    "velocity": ("velocity / (deg/s)", lambda f: np.degrees(f.velocity), False),
    "direction": ("velocity / (deg/s)", lambda f: np.degrees(f.velocity), False),
    "temperature": ("lubricant temperature / °C", lambda f: f.temperature, False),
    "torque": ("load torque / N·m", lambda f: f.torque, False),
    "torque_path": ("load torque / N·m", lambda f: f.torque, False),
    "load_motor_torque": ("load motor's torque / N·m", lambda f: f.load_motor_torque, False),
    "torque_rate": ("change of the load torque / (N·m/s)", lambda f: f.torque_rate, False),
    "time": ("time since the campaign began / h", lambda f: f.time / 3600.0, False),
    "transient": ("time since the recording began / s", lambda f: f.elapsed, False),
    "elapsed": ("time since the recording began / s", lambda f: f.elapsed, False),
    "since_reversal": (
        "distance since start or reversal / deg",
        lambda f: np.degrees(f.reversal_travel) + 1e-4,
        True,
    ),
    "acceleration": ("acceleration of the motor / (rad/s²)", lambda f: f.acceleration, False),
    "angle": ("output angle / deg", lambda f: np.degrees(np.mod(f.theta, 2.0 * np.pi)), False),
}


def plot(finding: Finding, analysis: Analysis, data: Dataset, score: Scores | None = None) -> str:
    """An SVG of the finding, empty where there is nothing to draw; ``score`` is that of its channel."""
    pair = _pair(finding, analysis, data)
    if pair is None and finding.source is None and score is not None and finding.channel in analysis.models:
        pair = _left(finding, analysis, score)
    return "" if pair is None or pair.x.size == 0 else drawn(pair)


def _pair(finding: Finding, analysis: Analysis, data: Dataset) -> Pair | None:
    source = finding.source
    model = analysis.transmission
    harmonics = model.harmonics if model is not None else None
    if isinstance(source, Found):
        return _regressed(analysis.models[finding.channel], source, finding, data)
    if isinstance(source, Law) and model is not None and harmonics is not None:
        return _law(source, model, harmonics)
    if isinstance(source, list) and source and isinstance(source[0], Ripple):
        return _ripple(source, data)
    peaks = isinstance(source, list) and bool(source) and isinstance(source[0], Peak)
    if peaks and model is not None and harmonics is not None:
        return (_pulse if source[0].kind == "pulse" else _orders)(source, model, harmonics)
    return None


def _left(finding: Finding, analysis: Analysis, score: Scores) -> Pair | None:
    """What is left of a channel on held-out recordings, over the speed: structure that nothing follows."""
    transmission = analysis.transmission if finding.channel == "transmission_error" else None
    frame = analysis.models[finding.channel].rows.frame if transmission is None else transmission.angle.frame
    unit, scale = UNITS[finding.channel]
    before, after = score.residual_before, score.residual_after
    if after.size == frame.size:
        before, after = before[score.rows], after[score.rows]
    shown = frame.take(score.rows)
    if after.size != shown.size:
        return None
    label, values, _ = _AXES["speed"]
    titles = ("given simulation, held-out recordings", "improved")
    return Pair(values(shown), scale * before, scale * after, shown.last_direction, label, unit, titles=titles)


def _regressed(model: ChannelModel, found: Found, finding: Finding, data: Dataset) -> Pair:
    """Residual without the finding, all else refitted, and with it; over the quantity it depends on."""
    frame = model.rows.frame
    unit, scale = UNITS[model.channel]
    before = model.rows.y - predict_named(model, frame, found.entry)
    after = model.rows.y - predict_named(model, frame)
    name = next((v for v in found.entry.variables if v in _AXES), "speed")
    label, values, logarithmic = _AXES[name]
    rows = (frame.direction != 0) & (model.rows.number > 0)
    if model.channel == "temperature":
        rows = model.rows.number > 0
        before, after = (_centred(r, frame) for r in (before, after))
    if name in ("transient", "elapsed"):
        # the recording in which the finding does most tells a course of time
        energy = np.bincount(frame.recording[rows], ((before - after) ** 2)[rows])
        told = int(np.argmax(energy))
        rows &= frame.recording == told
        label = f"{label}, recording {next((m.name for m in data.members if m.index == told), '')}"
    if name == "speed" and "velocity" in finding.location.conditions:
        # warm-ups are far faster than any operating point
        rows &= np.abs(frame.velocity) < _BEYOND * max(float(finding.location.conditions["velocity"][1]), 1e-6)
    return Pair(
        values(frame)[rows],
        scale * before[rows],
        scale * after[rows],
        frame.last_direction[rows],
        label,
        unit,
        logarithmic=logarithmic,
    )


def _centred(residual: FloatArray, frame: Frame) -> FloatArray:
    """Less the mean of each recording: the level from which a recording starts is free."""
    size = np.maximum(np.bincount(frame.recording), 1)
    return np.asarray(residual - (np.bincount(frame.recording, residual) / size)[frame.recording])


def _residuals(model: TransmissionModel, less: Harmonics) -> tuple[Rows, Rows]:
    """Steady rows of the transmission error less the offset and the harmonics: those of ``less``, and all."""
    assert model.harmonics is not None
    angle = model.angle
    rows = model.inside & (angle.frame.steady > 0.5) & (angle.number > 0)
    frame = angle.frame.take(rows)
    bare = angle.y[rows] - predict(model.offset, angle.frame)[rows]
    own = angle.take(rows)
    return replace(own, y=bare - less.evaluate(frame)), replace(own, y=bare - model.harmonics.evaluate(frame))


def _law(law: Law, model: TransmissionModel, harmonics: Harmonics) -> Pair | None:
    """What the series misses of the orders the law touches, without and with it, a point a revolution and order."""
    seen = [turns(rows, law.orders) for rows in _residuals(model, harmonics.without_law())]
    if not seen[0] or not law.orders:
        return None
    x = states(seen[0])
    speed = np.abs(x[:, 1])[:, None]
    axes: dict[str, tuple[str, FloatArray]] = {
        "order_frequency": ("frequency of the order, f·speed / (rad/s)", speed * np.asarray(law.orders)[None, :]),
        "speed": ("speed / (deg/s)", np.degrees(speed)),
        "temperature": ("lubricant temperature / °C", x[:, 2][:, None]),
        "torque": ("load torque / N·m", x[:, 0][:, None]),
        "time": ("time since the campaign began / h", np.array([t.time for t in seen[0]])[:, None] / 3600.0),
    }
    label, values = axes[law.variables[0] if law.variables else "order_frequency"]
    shape = (len(seen[0]), len(law.orders))
    sizes = [1e6 * np.abs([t.amplitude for t in turn_list]).ravel() for turn_list in seen]
    direction = np.broadcast_to(np.array([t.direction for t in seen[0]])[:, None], shape)
    return Pair(
        np.broadcast_to(values, shape).ravel(),
        sizes[0],
        sizes[1],
        direction.ravel(),
        label,
        "µrad, amplitude of an order",
    )


def _orders(peaks: list[Peak], model: TransmissionModel, harmonics: Harmonics) -> Pair | None:
    """Order spectrum of what the series leaves, without and with the orders found (root mean square of revolutions)."""
    seen = [turns(rows, (1.0,)) for rows in _residuals(model, harmonics.without(peaks))]
    if not seen[0]:
        return None
    orders = sorted({f for p in peaks for f in p.orders})
    low, high = max(2, min(orders) - 25), min(seen[0][0].spectrum.size - 1, max(orders) + 25)
    shown = np.array([f for f in range(low, high + 1) if f not in RIPPLE_ORDERS])
    size = [1e6 * np.sqrt(np.mean([np.abs(t.spectrum[shown]) ** 2 for t in part], axis=0)) for part in seen]
    ones = np.ones(shown.size)
    return Pair(shown.astype(np.float64), size[0], size[1], ones, "order per output revolution", "µrad", True)


def _pulse(peaks: list[Peak], model: TransmissionModel, harmonics: Harmonics) -> Pair:
    """Mean course over the output angle, without and with the pulses."""
    parts = _residuals(model, harmonics.without(peaks))
    number = np.floor(np.degrees(np.mod(parts[0].frame.theta, 2.0 * np.pi)) / PULSE_BIN_DEG).astype(int)
    count = np.bincount(number)
    means = [1e6 * np.bincount(number, rows.y) / np.maximum(count, 1) for rows in parts]
    angle = np.asarray((np.arange(count.size) + 0.5) * PULSE_BIN_DEG, dtype=np.float64)
    wide = 12.0 * max(np.degrees(p.width) for p in peaks)
    near = np.any([np.abs(np.mod(angle - np.degrees(p.angle) + 180.0, 360.0) - 180.0) < wide for p in peaks], axis=0)
    near &= count > 0
    label = "output angle / deg"
    return Pair(
        angle[near], means[0][near], means[1][near], np.ones(int(near.sum())), label, "µrad, mean of revolutions"
    )


def _ripple(ripples: list[Ripple], data: Dataset) -> Pair:
    """Spectrum of the motor torque over the motor's angle, mean of the recordings' amplitudes."""
    amplitude = np.array([s.amplitude for s in data.shaft])
    shown = np.flatnonzero(np.isfinite(amplitude).any(axis=0))
    before = np.nanmean(amplitude[:, shown], axis=0)
    after = before.copy()
    for ripple in ripples:
        after[shown == ripple.order] -= ripple.amplitude
    first, second = (np.asarray(np.abs(v), dtype=np.float64) for v in (before, after))
    ones = np.ones(shown.size)
    return Pair(shown.astype(np.float64), first, second, ones, "order per revolution of the motor", "N·m", True)
