"""Hours of bench time to a right name, the three ways side by side."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.investigate.proof.page import WORDS
from bench.investigate.proof.run import OPEN, RIGHT, UNSEEN, WAYS, WRONG

_SIGNS = {RIGHT: ("o", "full"), OPEN: ("o", "none"), WRONG: ("x", "full"), UNSEEN: ("s", "none")}


def draw(content: Mapping[str, Any], target: Path) -> Path:
    """Draw the plants that the first campaign left open into a PNG file: a point each, at the hours to its right name,
    or at all hours run where there was none. Raises BenchError where there is no such plant.
    """
    rows = [row for row in content["campaigns"] if row["first"] == OPEN]
    if not rows:
        raise BenchError("no plant was left open by its first campaign: there is nothing to draw.")
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 2.8), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    seen: set[str] = set()
    for place, way in enumerate(WAYS):
        rows_of_way = [row for row in rows if row["way"] == way]
        for number, row in enumerate(rows_of_way):
            hours = row["hours_to_name"] if row["hours_to_name"] is not None else row["hours"]
            marker, fill = _SIGNS[row["result"]]
            label = row["result"] if row["result"] not in seen else None
            seen.add(row["result"])
            height = place + 0.5 * ((number + 1) / (len(rows_of_way) + 1) - 0.5)
            axes.plot(hours, height, marker, color=f"C{list(_SIGNS).index(row['result'])}", fillstyle=fill, label=label)
    axes.set_yticks(range(len(WAYS)), [WORDS[way] for way in WAYS])
    axes.invert_yaxis()
    axes.set_xscale("symlog", linthresh=0.1)
    axes.margins(x=0.05, y=0.15)
    axes.set(xlabel="h of bench time: to the right name, or run in all without one", xlim=(0.0, None))
    axes.legend(fontsize=8)
    target.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(target, dpi=110)
    return target
