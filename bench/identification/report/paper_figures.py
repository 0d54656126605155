"""Figures 4 to 7 of the paper as files of their own, from the recordings at hand."""

from __future__ import annotations

import base64
from pathlib import Path

from bench.identification.identify import Identification
from bench.identification.report import figures

NUMBERS = {"By load torque": 4, "By velocity": 5, "By temperature": 6}
VALIDATION = 7
MEANING = {
    4: "the error at several load torques",
    5: "the error at several velocities",
    6: "the error at several temperatures",
    VALIDATION: "a validation recording beside the models",
}
_PREFIX = "data:image/png;base64,"


def write_paper_figures(found: Identification, folder: Path) -> tuple[list[Path], list[str]]:
    """Write ``figure-4.png`` to ``figure-7.png`` into ``folder`` (made where it is missing).

    Each shows the position domain on its left and the order spectrum on its right, as the paper's pairs do, at the
    paper's operating point or the recordings nearest to it. Returns the paths and a sentence for each figure that the
    recordings cannot make.
    """
    drawn = {NUMBERS[heading]: uri for heading, uri, _ in figures.influences(found)}
    example = figures.validation_example(found)
    if example is not None:
        drawn[VALIDATION] = example[0]
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for number, uri in sorted(drawn.items()):
        path = folder / f"figure-{number}.png"
        path.write_bytes(base64.b64decode(uri.removeprefix(_PREFIX)))
        paths.append(path)
    missing = [f"Figure {n} ({MEANING[n]}) cannot be drawn: no recording shows it." for n in MEANING if n not in drawn]
    return paths, missing
