"""One campaign as the twin saw it: the evidence against the model, recording by recording."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.twin.scale import CALIBRATION
from bench.twin.watch import LIMIT


def draw(row: Mapping[str, Any], target: Path) -> Path:
    """Draw a row of the store into a PNG file.

    Raises BenchError where the row holds no course: it was stored by an earlier version.
    """
    course = row.get("evidence")
    if not course:
        raise BenchError(f"{row['key']}: its course was not stored; give another --store, it is then run anew.")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    points = range(1, len(course) + 1)
    axes.axvspan(0.5, CALIBRATION + 0.5, color="0.93", label="calibrates")
    axes.plot(points, course, "o-", color="C0", markersize=3.5, label="evidence against the model (log)")
    axes.axhline(LIMIT, color="C3", linestyle="--", label="alarm: at most 1 in 125 campaigns without a change")
    if row["began"] is not None:
        axes.axvline(row["began"] + 0.5, color="0.4", linestyle=":", label=f"{row['change']} ({row['level']})")
    if row["noticed"] is not None:
        axes.plot(row["noticed"] + 1, course[row["noticed"]], "o", color="C3", markersize=8, fillstyle="none")
    axes.set(xlabel="recording at one point", ylabel="natural logarithm", xlim=(0.5, len(course) + 0.5))
    axes.set_ylim(min(0.0, *course) - 1.0, min(max(course), 4.0 * LIMIT) * 1.1 + 1.0)
    axes.legend(loc="upper left", fontsize=8)
    target.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(target, dpi=110)
    return target
