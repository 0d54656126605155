"""Two plots side by side, without a finding and with it: SVG whose text takes the page's colour, light or dark."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bench.simulation.frame import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORWARD, BACKWARD = "#2f7ed8", "#e0702d"
_INK = "#010203"
"""stands for the page's own text colour, which an SVG takes up as ``currentColor``"""
_MOST_POINTS = 2500
_BINS = 28


@dataclass(frozen=True, slots=True)
class Pair:
    """What a plot shows: abscissa, ordinate before and after, direction of each point; axis labels.

    ``curve`` (n,): what the finding adds at each point, drawn over the first plot.
    """

    x: FloatArray
    before: FloatArray
    after: FloatArray
    direction: FloatArray
    label: str
    unit: str
    spectrum: bool = False
    logarithmic: bool = False
    titles: tuple[str, str] = ("without it", "with it")
    curve: FloatArray | None = None


def drawn(pair: Pair) -> str:
    """The pair as two plots side by side, SVG."""
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
        for axis, values, title in zip(axes, (pair.before, pair.after), pair.titles, strict=True):
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
        if pair.curve is not None and not pair.spectrum:
            _curve(axes[0], pair, pair.curve)
        _limit(axes[0], pair)
        axes[0].set_ylabel(f"measured − simulated / {pair.unit}" if not pair.spectrum else f"amplitude / {pair.unit}")
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None})
    text = out.getvalue()
    return text[text.index("<svg") :].replace(_INK, "currentColor")


def _curve(axis: Axes, pair: Pair, added: FloatArray) -> None:
    """What the finding adds: its mean over the abscissa, of each direction."""
    label = "the finding"
    for side in (1, -1):
        on_side = pair.direction * side > 0
        if on_side.any():
            x, mean = _means(pair.x[on_side], added[on_side], pair.logarithmic)
            axis.plot(x, mean, "--", color=_INK, lw=1.2, label=label)
            label = "_nolegend_"
    axis.legend(fontsize=8.0, frameon=False, loc="best")


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
        on_side = pair.direction * side > 0
        if not on_side.any():
            continue
        chosen = shown[on_side[shown]]
        axis.plot(pair.x[chosen], values[chosen], ".", ms=2.5, color=colour, alpha=0.35, rasterized=True)
        x, mean = _means(pair.x[on_side], values[on_side], pair.logarithmic)
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
    centre = np.bincount(number, scaled, _BINS)[good] / count[good]
    return (np.exp(centre) if logarithmic else centre), mean
