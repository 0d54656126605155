"""The paper's figures, drawn from the reduced recordings; each becomes a PNG in a data URI."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bench.identification.identify import Identification
from bench.identification.samples.reduction import Reduction
from bench.identification.samples.steady import ANGLE_STEPS, SteadySums
from bench.identification.series.harmonics import single_recording
from bench.identification.validation import mean_inputs, model_harmonics, revolution
from bench.simulation.parts import part_of

FloatArray = NDArray[np.float64]

BINS = 1440
PART_COLOURS = {
    "output shaft": "#00519e",
    "planetary stage": "#2a9d8f",
    "cycloid stage": "#e4af35",
    "cycloid disc": "#c1440e",
    "input gear": "#7b2d8b",
    "motor shaft": "#5b8c2a",
    "load motor": "#888888",
    "none": "#000000",
}


def to_uri(figure: Figure) -> str:
    """Return the figure as a data URI (PNG)."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110, bbox_inches="tight")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def curve(steady: SteadySums) -> tuple[FloatArray, FloatArray]:
    """Angle (1440,) in rad and transmission error less its mean in rad, averaged over angle bins (NaN where empty)."""
    index = (steady.angle.astype(np.float64) / ANGLE_STEPS * BINS).astype(np.int64)
    count = np.bincount(index, minlength=BINS)[:BINS]
    total = np.bincount(index, weights=steady.sample, minlength=BINS)[:BINS]
    with np.errstate(invalid="ignore", divide="ignore"):
        value = total / count
    return (np.arange(BINS) + 0.5) * 2.0 * np.pi / BINS, value - np.nanmean(value)


def nearest(reductions: Sequence[Reduction], torque: float, velocity: float, temperature: float) -> Reduction | None:
    """Return the recording nearest to an operating point (N·m, rad/s, °C), each input in units of the paper's range."""
    usable = [r for r in reductions if r.steady is not None]

    def distance(r: Reduction) -> float:
        assert r.steady is not None
        tau, rate, temp = np.nan_to_num(mean_inputs(r.steady))
        return float(((tau - torque) / 2000) ** 2 + ((rate - velocity) / 0.35) ** 2 + ((temp - temperature) / 30) ** 2)

    return min(usable, key=distance) if usable else None


def _axes(title_left: str, title_right: str) -> tuple[Figure, Any, Any]:
    figure = Figure(figsize=(11.0, 3.6))
    left, right = figure.subplots(1, 2)
    left.set(title=title_left, xlabel="θ in degrees", ylabel="transmission error in µrad", xlim=(0, 360))
    right.set(title=title_right, xlabel="order per output revolution", ylabel="amplitude in µrad", xlim=(0, 300))
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure, left, right


def _comparison(members: Sequence[tuple[Reduction, str]]) -> str | None:
    """Curves less their means, one above the other, and their spectra; means, in the legend, are far larger."""
    if not members:
        return None
    figure, left, right = _axes("Position domain, curves apart", "Order spectrum")
    curves = [(*curve(r.steady), r.steady.reference) for r, _ in members if r.steady is not None]
    apart = 1.05 * max(float(np.nanmax(value) - np.nanmin(value)) for _, value, _ in curves)
    left.set(ylabel=f"without mean, each {1e6 * apart:.0f} µrad higher")
    for number, (r, label) in enumerate(members):
        assert r.steady is not None
        angle, value, level = curves[number]
        label = f"{label}, mean {1e6 * level:.0f} µrad"
        colour = f"C{number}"
        left.plot(np.degrees(angle), 1e6 * (value + number * apart), lw=0.7, color=colour, label=label)
        shown = min(r.steady.spectrum.size, 301)
        right.plot(np.arange(1, shown), 1e6 * np.sqrt(r.steady.spectrum[1:shown]), lw=0.8, color=colour, label=label)
    right.legend(fontsize=7)
    return to_uri(figure)


def _levels(found: Identification, fixed: dict[int, float], varied: int) -> list[tuple[Reduction, str]]:
    """Pick recordings near ``fixed`` inputs (index: value), one a level of the varied input, at most eight."""
    units = ("{:.0f} N·m", "{:.1f} deg/s", "{:.0f} °C")
    tolerance = (120.0, 0.012, 4.0)
    picked: dict[float, tuple[float, Reduction]] = {}
    for r in found.reductions:
        if r.steady is None or r.validation:
            continue
        inputs = np.nan_to_num(mean_inputs(r.steady))
        off = sum(((inputs[i] - value) / tolerance[i]) ** 2 for i, value in fixed.items())
        if any(abs(inputs[i] - value) > tolerance[i] for i, value in fixed.items()):
            continue
        step = (100.0, 0.02, 5.0)[varied]
        level = float(np.round(inputs[varied] / step) * step)
        if level not in picked or off < picked[level][0]:
            picked[level] = (off, r)
    rows = sorted(picked.items())[:8]
    scale = np.degrees(1.0) if varied == 1 else 1.0
    return [
        (r, units[varied].format(mean_inputs(r.steady)[varied] * scale)) for _, (_, r) in rows if r.steady is not None
    ]


def polar(found: Identification) -> tuple[str, str] | None:
    """Figure 1 of the paper: error against angle in polar form; (data URI, caption)."""
    r = nearest(found.reductions, 1000.0, -np.deg2rad(2.5), 27.0)
    if r is None or r.steady is None:
        return None
    angle, value = curve(r.steady)
    figure = Figure(figsize=(4.6, 4.6))
    axes = figure.add_subplot(projection="polar")
    axes.plot(angle, 1e6 * value, lw=0.7, color="#00519e")
    low, high = np.nanmin(1e6 * value), np.nanmax(1e6 * value)
    axes.set_ylim(low - 0.8 * (high - low), high)
    return to_uri(figure), f"Transmission error in µrad without mean, {_point(r.steady)}, {r.recording_id}."


def _point(steady: SteadySums) -> str:
    tau, rate, temp = mean_inputs(steady)
    return f"{tau:.0f} N·m, {np.degrees(rate):.2f} deg/s, {temp:.1f} °C"


def influences(found: Identification) -> list[tuple[str, str, str]]:
    """Figures 4 to 6: by torque, velocity and temperature; (heading, data URI, caption)."""
    steady = [r.steady for r in found.reductions if r.steady is not None]
    if not steady:
        return []
    rates = [float(s.velocity.mean()) for s in steady]
    negative = [rate for rate in rates if rate < 0]
    slow = max(negative) if negative else min(rates)
    cold = float(np.nan_to_num(np.nanmin([float(np.nan_to_num(s.temperature.mean())) for s in steady])))
    light = min((float(np.nan_to_num(s.torque.mean())) for s in steady), key=abs)
    load = "no load" if abs(light) < 20.0 else f"{light:.0f} N·m"
    out = []
    for heading, fixed, varied, words in (
        ("By load torque", {1: slow, 2: cold + 2.0}, 0, f"{np.degrees(slow):.1f} deg/s, about {cold:.0f} °C"),
        ("By velocity", {0: light, 2: cold + 2.0}, 1, f"{load}, about {cold:.0f} °C"),
        ("By temperature", {0: light, 1: slow}, 2, f"{load}, {np.degrees(slow):.1f} deg/s"),
    ):
        uri = _comparison(_levels(found, fixed, varied))
        if uri is not None:
            out.append((heading, uri, f"Transmission error at {words}."))
    return out


def validation_example(found: Identification) -> tuple[str, str] | None:
    """Figure 7: one validation recording, its own series and the models, orders marked by part; (data URI, caption)."""
    chosen = nearest([r for r in found.reductions if r.validation], -750.0, np.deg2rad(2.5), 26.0)
    if chosen is None or chosen.steady is None or not found.models:
        return None
    steady = chosen.steady
    z, _ = single_recording(steady, found.orders, found.notch_orders)
    figure, left, right = _axes("Position domain", "Order spectrum, selected orders by part")
    angle, value = curve(steady)
    left.plot(np.degrees(angle), 1e6 * value, lw=0.6, color="#999999", label="measured")
    grid = np.linspace(0.0, 360.0, 4097)
    left.plot(grid, 1e6 * revolution(found.orders, z, 12), lw=0.9, color="#00519e", label="series of this recording")
    for name, colour in (("refined", "#c1440e"), ("paper", "#e4af35")):
        fourier = found.models[name].direction(steady.window.direction)
        if fourier is not None:
            harmonics = model_harmonics(fourier, *mean_inputs(steady))
            left.plot(grid, 1e6 * revolution(found.orders, harmonics, 12), lw=0.9, color=colour, label=name)
    left.legend(fontsize=7)
    shown = min(steady.spectrum.size, 301)
    amplitude = 1e6 * np.sqrt(steady.spectrum[:shown])
    right.plot(np.arange(1, shown), amplitude[1:], lw=0.7, color="#999999")
    seen = set()
    for order in [*found.orders, *found.notch_orders]:
        part = part_of(float(order), found.gearbox, found.notch_orders)
        if round(order) < shown:
            label = None if part in seen else part
            right.plot(order, amplitude[round(order)], "o", ms=4, color=PART_COLOURS.get(part, "k"), label=label)
            seen.add(part)
    right.legend(fontsize=7)
    return to_uri(figure), f"Validation recording {chosen.recording_id}: {_point(steady)}."


def leakage(found: Identification) -> tuple[str, str] | None:
    """Amplitudes of the two closest orders by both methods, one point a recording; (data URI, caption)."""
    orders = np.asarray(found.orders)
    rows = [r for r in found.reductions if r.paper is not None and r.steady is not None and not r.validation]
    close = np.flatnonzero(np.diff(orders) == 1)
    if not rows or close.size == 0:
        return None
    first = int(np.flatnonzero(orders == 13)[0]) if 13 in orders and 14 in orders else int(close[0])
    figure = Figure(figsize=(9.0, 3.4))
    joint = np.stack([single_recording(r.steady, found.orders, found.notch_orders)[0] for r in rows if r.steady])
    windowed = np.stack([r.paper.amplitude for r in rows if r.paper])
    for number, axes in enumerate(figure.subplots(1, 2)):
        k = first + number
        x, y = 1e6 * np.abs(joint[:, k]), 1e6 * windowed[:, k]
        axes.plot(x, y, ".", ms=4, color="#00519e")
        top = 1.05 * max(x.max(), y.max())
        axes.plot([0, top], [0, top], "k--", lw=0.7)
        axes.set(title=f"order {orders[k]:g}", xlabel="joint least squares, µrad", ylabel="windowed FFT (paper), µrad")
        axes.grid(alpha=0.3)
    caption = (
        f"Leakage between close orders: over one revolution the Hamming window's main lobe is four orders wide, so the "
        f"spectrum's amplitude at {orders[first]:g} holds part of {orders[first + 1]:g} and the other way round."
    )
    return to_uri(figure), caption
