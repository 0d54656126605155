"""A quick look at what a change may be: each term of the library alone, fitted to what is left since it began.

No alternative is refitted, and nothing is corrected for the number of terms tried: it says where to look first. The
full analysis is ``bench mismatch``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from bench.mismatch.regression.candidates import BY_GEOMETRY, PERIODIC
from bench.mismatch.regression.regressors import Named
from bench.simulation.frame import FloatArray, Frame, concatenate
from bench.simulation.terms import LIBRARY
from bench.twin.finding import Finding
from bench.twin.scale import measured_for
from bench.twin.streams import DIRECTION, MEAN, ORDER, WINDOW, Stream
from bench.twin.watch import Watch

MOST = 3
NAMES_OF = {ORDER: "te.harmonic", WINDOW: "te.local_defect"}
"""what one order, or one window of the angle, is called: they need no fit"""


@dataclass(frozen=True, slots=True)
class Likely:
    """A term of the library, and the share of the change's energy it takes alone; None where it was not fitted."""

    effect: str
    name: str
    share: float | None


def likely(watch: Watch, finding: Finding) -> tuple[Likely, ...]:
    """Names for the strongest stream, the likeliest first; none where nothing of the library takes a part of it."""
    strongest = finding.streams[0].stream
    if strongest.what in NAMES_OF:
        effect = NAMES_OF[strongest.what]
        return (Likely(effect, LIBRARY[effect].name, None),)
    rows = _residual_since(watch, finding.since, strongest.channel)
    if rows is None:
        return ()
    target, frame = rows
    energy = float(target @ target)
    best: dict[str, float] = {}
    for term in _candidates(strongest.channel, frame):
        columns = term.columns(frame)
        if not np.isfinite(columns).all() or not np.any(columns):
            continue
        scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
        fitted = scaled @ np.linalg.lstsq(scaled, target, rcond=1e-8)[0]
        share = 1.0 - float(np.sum((target - fitted) ** 2)) / max(energy, 1e-300)
        # each column takes its part of anything, noise included
        share -= (columns.shape[1] + len(term.point)) / target.size
        best[term.effect] = max(best.get(term.effect, 0.0), share)
    ranked = sorted((e for e in best if best[e] > 0.0), key=lambda e: -best[e])
    return tuple(Likely(e, LIBRARY[e].name, round(best[e], 3)) for e in ranked[:MOST])


def _candidates(channel: str, frame: Frame) -> Iterator[Named]:
    for term in LIBRARY.values():
        if channel not in term.forms or term.effect in (*PERIODIC, *BY_GEOMETRY):
            continue
        for form in term.forms[channel]:
            for point in form.grid(frame):
                yield Named(term, channel, form, point)


def _residual_since(watch: Watch, since: int, channel: str) -> tuple[FloatArray, Frame] | None:
    """Residual of a channel since the change (n,), less its mean in the first recordings; with its rows."""
    centres = watch.scales.get(Stream(channel, DIRECTION))
    parts, frames = [], []
    for seen in watch.seen[since:]:
        sketch = seen.left.get(channel)
        if sketch is None or sketch.left.size == 0:
            continue
        centre = 0.0
        if centres is not None:
            sides = [m for m in measured_for(Stream(channel, DIRECTION)) if m in seen.values and m in centres.centres]
            centre = centres.centres[sides[0]] if sides and sides[0].what == MEAN else 0.0
        parts.append(sketch.left - centre)
        frames.append(sketch.frame)
    return (np.concatenate(parts), concatenate(frames)) if parts else None
