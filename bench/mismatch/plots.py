"""Plots of a finding, before and after, at the place where it shows: SVG whose text takes the page's colour."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.columns import RIPPLE_ORDERS
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
    from matplotlib.axes import Axes

    from bench.mismatch.channels import Analysis
    from bench.mismatch.dataset import Dataset

FORWARD, BACKWARD = "#2f7ed8", "#e0702d"
_INK = "#010203"
"""stands for the page's own text colour, which an SVG takes up as ``currentColor``"""
_MOST_POINTS = 2500
_BINS = 28
PULSE_BIN_DEG = 0.1
_BEYOND = 2.5
"""how far beyond its place a finding over speed is drawn"""
UNITS: dict[str, tuple[str, float]] = {
    "transmission_error": ("µrad", 1e6),
    "motor_torque": ("N·m", 1.0),
    "load_torque": ("N·m", 1.0),
    "temperature": ("K", 1.0),
}


@dataclass(frozen=True, slots=True)
class Pair:
    """What a plot shows: abscissa, ordinate before and after, direction of each point; axis labels."""

    x: FloatArray
    before: FloatArray
    after: FloatArray
    direction: FloatArray
    label: str
    unit: str
    spectrum: bool = False
    logarithmic: bool = False


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


def plot(finding: Finding, analysis: Analysis, data: Dataset) -> str:
    """An SVG of the finding, empty where there is nothing to draw."""
    pair = _pair(finding, analysis, data)
    return "" if pair is None or pair.x.size == 0 else _drawn(pair)


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


def _regressed(model: ChannelModel, found: Found, finding: Finding, data: Dataset) -> Pair:
    """Residual without the finding, all else refitted, and with it; over the quantity it depends on."""
    frame = model.rows.frame
    unit, scale = UNITS[model.channel]
    before = model.rows.y - predict_named(model, frame, found.entry)
    after = model.rows.y - predict_named(model, frame)
    variables = found.unknown.variables if found.unknown is not None else found.entry.variables
    name = next((v for v in variables if v in _AXES), "speed")
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


def _drawn(pair: Pair) -> str:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    style: Any = {
        "svg.fonttype": "none",
        "svg.hashsalt": "bench",
        "font.family": "sans-serif",
        "font.size": 10.0,
        **{key: _INK for key in ("text.color", "axes.labelcolor", "xtick.color", "ytick.color", "axes.edgecolor")},
        "axes.facecolor": "none",
        "axes.spines.top": False,
        "axes.spines.right": False,
    }
    with mpl.rc_context(style):
        figure = Figure(figsize=(8.6, 3.0), layout="constrained", facecolor="none")
        axes = figure.subplots(1, 2, sharex=True, sharey=True)
        shown = np.random.default_rng(0).permutation(pair.x.size)[:_MOST_POINTS]
        for axis, values, title in ((axes[0], pair.before, "before: without it"), (axes[1], pair.after, "after")):
            if pair.spectrum:
                axis.vlines(pair.x, 0.0, values, color=FORWARD, lw=1.3)
                axis.set_ylim(bottom=0.0)
            else:
                _cloud(axis, pair, values, shown)
                axis.axhline(0.0, color="#888888", lw=0.7)
            if pair.logarithmic:
                axis.set_xscale("log")
            axis.set_title(title, fontsize=10.0, loc="left")
            axis.set_xlabel(pair.label)
        _limit(axes[0], pair)
        axes[0].set_ylabel(f"measured − simulated / {pair.unit}" if not pair.spectrum else f"amplitude / {pair.unit}")
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    return text[text.index("<svg") :].replace(_INK, "currentColor")


def _limit(axis: Axes, pair: Pair) -> None:
    """Keep single wild points from hiding the finding."""
    if not pair.spectrum and pair.before.size > 50:
        both = np.concatenate([pair.before, pair.after])
        low, high = np.percentile(both, [0.3, 99.7])
        margin = 0.12 * max(high - low, 1e-12)
        axis.set_ylim(float(low - margin), float(high + margin))


def _cloud(axis: Axes, pair: Pair, values: FloatArray, shown: NDArray[np.int64]) -> None:
    """Points of both directions, with the mean over the abscissa as a line each."""
    for side, colour, name in ((1, FORWARD, "positive direction"), (-1, BACKWARD, "negative direction")):
        own = pair.direction * side > 0
        if not own.any():
            continue
        chosen = shown[own[shown]]
        axis.plot(pair.x[chosen], values[chosen], ".", ms=2.5, color=colour, alpha=0.35, rasterized=True)
        x, mean = _means(pair.x[own], values[own], pair.logarithmic)
        axis.plot(x, mean, color=colour, lw=1.8, label=name)
    if (pair.direction > 0).any() and (pair.direction < 0).any():
        axis.legend(fontsize=8.0, frameon=False, loc="best")


def _means(x: FloatArray, values: FloatArray, logarithmic: bool) -> tuple[FloatArray, FloatArray]:
    """Means over bins of the abscissa that hold at least three points."""
    scaled = np.log(x) if logarithmic else x
    low, high = float(scaled.min()), float(scaled.max())
    if high <= low:
        return x[:1], np.array([values.mean()])
    number = np.minimum(((scaled - low) / (high - low) * _BINS).astype(int), _BINS - 1)
    count = np.bincount(number, minlength=_BINS)
    good = count >= 3
    mean = np.bincount(number, values, _BINS)[good] / count[good]
    place = np.bincount(number, scaled, _BINS)[good] / count[good]
    return (np.exp(place) if logarithmic else place), mean
