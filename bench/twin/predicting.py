"""What the model in force leaves of each recording, one after the other, as a campaign makes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.errors import ConfigurationError
from bench.foreign.opening import base_of
from bench.mismatch.given import Given, says_waves
from bench.mismatch.prediction import Predictor
from bench.mismatch.recordings.beginning import at_start
from bench.mismatch.recordings.collected import Collected
from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder, Prepared, prepare
from bench.mismatch.recordings.rows import Rows, angle_rows, heat_rows, slow_rows
from bench.mismatch.regression.problem import CHANNELS
from bench.recording import Recording
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.model import Simulation
from bench.simulation.terms import TEMPERATURE, TRANSMISSION_ERROR
from bench.twin.streams import Stream, looked_at_orders, measure

SKETCH = 40
"""rows of a sketch, about"""


@dataclass(frozen=True, slots=True)
class Sketch:
    """Residual of one channel of a recording, coarsely: ``left`` (k,) means of blocks of rows in steady
    motion, ``frame`` a row in the middle of each.
    """

    left: FloatArray
    frame: Frame


@dataclass(frozen=True, slots=True)
class Look:
    """One recording: its numbers by stream, its channels in sketches."""

    values: Mapping[Stream, float]
    left: Mapping[str, Sketch]


class Predicting:
    """The model in force on the recordings of one campaign, in the order in which they were made.

    Parameters
    ----------
    model : simulation file.
    first : the first recordings; they say how the bench moves and at which orders the load motor ripples.

    Raises
    ------
    ConfigurationError
        The file is wrong.
    """

    def __init__(self, model: Path, first: Sequence[Recording]) -> None:
        if not first:
            raise ConfigurationError("the twin needs a recording to begin with")
        simulation = Simulation.load(model)
        base = base_of(simulation.extra, model.resolve().parent)
        given = Given.of(simulation)
        self._predictor = Predictor(given)
        self._folder = Folder.of(first, base).following(says_waves(simulation))
        self._rows, self._travelled, self._number = Collected(), 0.0, 0
        waves = [wave.order for channel_waves in given.waves.values() for wave in channel_waves]
        self.orders = looked_at_orders([*given.orders, *waves])
        self.without: dict[str, str] = {}
        """channels that cannot be watched, and why"""

    def look(self, recording: Recording) -> Look:
        """The numbers of all streams of the next recording. Raises RecordingError where it cannot be read."""
        values: dict[Stream, float] = {}
        sketches = {}
        for channel, (left, rows) in self.left(recording).items():
            values |= measure(channel, left, rows, self.orders)
            sketches[channel] = _sketch(left, rows)
        return Look(values, sketches)

    def left(self, recording: Recording) -> dict[str, tuple[FloatArray, Rows]]:
        """By channel the rows (n) of the next recording and their residuals (n,), in SI units."""
        ready = prepare(recording, self._number, self._folder, self._travelled)
        self._number += 1
        self._travelled = float(ready.frame.travel[-1])
        own = {
            channel: _rows(ready, channel, self._folder.manner)
            for channel, spec in CHANNELS.items()
            if channel in ready.measured and all(name in recording.specs for name in spec.made_of)
        }
        known = own
        if self._predictor.remembers:
            self._rows.add(ready, frozenset(CHANNELS), self._folder.manner)
            known = {channel: self._rows.joined(channel) for channel in self._rows.rows}
        # what is no heat is taken off the loss, as where the model was calibrated
        zeros = self._predictor.zeros(known)
        campaign = zeros.of_campaign({channel: rows.frame for channel, rows in known.items()})
        out = {}
        for channel, rows in own.items():
            lacking = self._predictor.missing(channel, rows.frame)
            if lacking:
                self.without[channel] = f"the model has no numbers for {', '.join(lacking)}"
                continue
            frame, start = rows.frame, None
            frame = self._predictor.moved(channel, frame, self._folder.manner.smoothing)
            if channel == TEMPERATURE:
                frame, start = zeros.less(frame), at_start(frame, rows.y)
            predicted = self._predictor.channel(channel, frame, start, campaign)
            out[channel] = (rows.y - predicted, rows)
        return out


def _sketch(left: FloatArray, rows: Rows) -> Sketch:
    use = np.flatnonzero((rows.number > 0) & np.isfinite(left) & (rows.frame.steady > 0.5))
    if use.size == 0:
        use = np.flatnonzero(np.isfinite(left))
    parts = np.array_split(use, min(SKETCH, use.size)) if use.size else []
    means = np.array([float(left[part].mean()) for part in parts])
    return Sketch(means, rows.frame.take(np.array([part[part.size // 2] for part in parts], dtype=np.int64)))


def _rows(ready: Prepared, channel: str, manner: Manner) -> Rows:
    """A channel in the rows in which everything is compared; the angle in parts far finer than any order."""
    if channel == TEMPERATURE:
        return heat_rows(ready)
    return angle_rows(ready) if channel == TRANSMISSION_ERROR else slow_rows(ready, channel, manner)
