"""Residuals per sample, from simulation files alone: load them, predict the recordings, subtract."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from bench.mismatch.analysis import Analysis
from bench.mismatch.given import Given
from bench.mismatch.orders.bounds import Bounds
from bench.mismatch.prediction import Predictor, compared, silent
from bench.mismatch.recordings.dataset import Dataset, Member
from bench.mismatch.recordings.prepared import Prepared, prepare
from bench.mismatch.recordings.rows import settled_rows
from bench.simulation.frame import FloatArray
from bench.simulation.model import Simulation
from bench.simulation.terms import TEMPERATURE, TRANSMISSION_ERROR

STEADY = "_steady"
"""ends the name of what is scored in steady motion alone"""
INSIDE = "_inside"
"""ends the name of what is scored in steady motion alone, about the mean of each recording"""
ALTOGETHER = "_altogether"
"""ends the name of what is scored in steady motion alone, over all samples: a few recordings far off count"""


@dataclass(slots=True)
class _Sum:
    squares: float = 0.0
    samples: float = 0.0

    each: list[float] = field(default_factory=list)
    """mean square of each recording"""
    inside: list[float] = field(default_factory=list)
    """mean square of each recording about its own mean"""

    def add(self, left: FloatArray) -> None:
        if left.size:
            squares = float(np.sum(left**2))
            self.squares += squares
            self.samples += float(left.size)
            self.each.append(squares / left.size)
            self.inside.append(float(np.var(left)))

    def rmse(self) -> float | None:
        return float(np.sqrt(self.squares / self.samples)) if self.samples > 0 else None

    def usual(self) -> float | None:
        return float(np.sqrt(np.median(self.each))) if self.each else None

    def usual_inside(self) -> float | None:
        return float(np.sqrt(np.median(self.inside))) if self.inside else None


def rmse(
    data: Dataset, analysis: Analysis, models: Mapping[str, Simulation], members: Sequence[Member]
) -> dict[str, dict[str, float | None]]:
    """Root mean square per sample that each of ``models`` leaves of some recordings, by channel and model's name.

    None where a model does not say a term that matters, or where no sample can be compared. ``NAME + STEADY`` is of the
    samples in steady motion alone, the median over the recordings, as the noise floor is; ``NAME + INSIDE`` the same
    about the mean of each recording.
    """
    predictors = {name: Predictor(Given.of(model)) for name, model in models.items()}
    names = [*models, *(name + STEADY for name in models)]
    sums = {channel: {name: _Sum() for name in names} for channel in analysis.outcomes}
    unknown: set[tuple[str, str]] = set()
    speeds = [] if analysis.transmission is None else [t.velocity for t in analysis.transmission.revolutions]
    bounds = Bounds.of(speeds)
    pieces, span = {m.index: m for m in members}, data.folder.manner.smoothing
    campaign = {channel: rows.frame for channel, rows in data.rows.items()}
    zeros = {name: predictor.zeros(data.rows) for name, predictor in predictors.items()}
    heated = {name: zero.of_campaign(campaign) for name, zero in zeros.items()}
    for part in prepared_members(data, pieces):
        for channel, channel_sums in sums.items():
            if channel not in part.measured or not _may(channel, part, data):
                continue
            side = compared(part, channel)
            counts = side.counts
            if channel == TRANSMISSION_ERROR and bounds is not None:
                counts = counts & bounds.inside(side.frame)
            if not counts.any():
                continue
            settled = counts & settled_rows(side.frame)
            for name, predictor in predictors.items():
                if (channel, name) in unknown:
                    continue
                if predictor.missing(channel, side.frame):
                    unknown.add((channel, name))
                    continue
                frame, whole = predictor.moved(channel, side.frame, span), campaign
                if channel == TEMPERATURE:
                    frame, whole = zeros[name].less(frame), heated[name]
                values = predictor.channel(channel, frame, side.start, whole)
                if channel == TRANSMISSION_ERROR:
                    values = values + silent(side, values, data.folder.notch)
                left = side.measured - values
                channel_sums[name].add(left[counts])
                channel_sums[name + STEADY].add(left[settled])
    out: dict[str, dict[str, float | None]] = {}
    for channel, channel_sums in sums.items():
        out[channel] = {}
        for name in models:
            steady = channel_sums[name + STEADY]
            scores = {
                name: channel_sums[name].rmse(),
                name + STEADY: steady.usual(),
                name + INSIDE: steady.usual_inside(),
                name + ALTOGETHER: steady.rmse(),
            }
            out[channel] |= dict.fromkeys(scores) if (channel, name) in unknown else scores
    return out


def _may(channel: str, part: Prepared, data: Dataset) -> bool:
    if channel == TRANSMISSION_ERROR and part.kind == "heating":
        return False
    recordings = data.rows[channel].frame.recording
    return bool(np.any(recordings == part.frame.recording[0]))


def prepared_members(data: Dataset, members: Mapping[int, Member]) -> Iterator[Prepared]:
    """Recordings (or pieces of some) at their own rate, one after another, by their numbers."""
    ready: tuple[object, Prepared] | None = None
    for number in sorted(members):
        piece = data.parts[number]
        if ready is None or ready[0] is not piece.recording:
            whole = prepare(piece.recording, number, data.folder, data.travelled[str(piece.recording.path)], group=1)
            ready = (piece.recording, whole)
        yield piece.cut(ready[1], number)
