"""One recording being made: rows from the rig into the file, and the figures the quality gate needs, on the way."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.cycle.channels import Scaling
from bench.errors import BacklogError, RecordingError, one_sentence
from bench.protocols import Segment
from bench.recording import FAST_CHUNK_ROWS, RecordingHeader, RecordingWriter

_FULL_SCALE = 32767


@dataclass(slots=True)
class SteadyFigures:
    """Sums over the steady parts of a recording, SI; what the quality gate judges.

    ``rows``, ``lost_cycles`` and ``saturated`` are of the whole recording.
    """

    rows: int = 0
    samples: int = 0
    travel: float = 0.0
    """Greatest load-side travel within one steady segment, rad."""
    velocity_sum: float = 0.0
    torque_sum: float = 0.0
    temperature_low: float = math.inf
    temperature_high: float = -math.inf
    lost_cycles: int = 0
    saturated: int = 0

    @property
    def velocity(self) -> float:
        """Mean load-side velocity from the motor, rad/s."""
        return self.velocity_sum / self.samples if self.samples else math.nan

    @property
    def load_torque(self) -> float:
        """Mean of the torque sensor, N·m."""
        return self.torque_sum / self.samples if self.samples else math.nan


class Recorder:
    """A sink of the rig that writes one recording.

    ``time`` counts from the first row; ``cycle`` stays that of the bus. In real time nothing but :meth:`close` waits
    for the disk: one that is too far behind ends the recording, and the motion goes on without.

    Attributes
    ----------
    ended : why the recording has ended before its motion, None as long as it goes on.
    """

    def __init__(self, path: Path, header: RecordingHeader, scaling: Scaling, *, fast: bool, ratio: float) -> None:
        self._scaling, self._ratio = scaling, ratio
        self._writer = RecordingWriter(
            path, header, list(scaling.specs.values()), chunk_rows=FAST_CHUNK_ROWS if fast else None, wait=fast
        )
        self.ended: str | None = None
        self._cycle_time = scaling.scale("time")
        self._first: int | None = None
        self._last_cycle: int | None = None
        self._steady = False
        self._steady_start = math.nan
        self.figures = SteadyFigures()
        self.temperature = math.nan

    @property
    def rows_taken(self) -> int:
        """Rows so far."""
        return self._writer.rows

    def segment(self, segment: Segment | None) -> None:
        """Begin a segment at the next row, or end the one that is open."""
        self._steady, self._steady_start = segment is Segment.STEADY, math.nan
        if segment is None:
            self._record(self._writer.end_segment)
        else:
            self._record(lambda: self._writer.begin_segment(segment.value))

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Take raw rows of every channel."""
        cycle = raw["cycle"]
        if cycle.size == 0 or self.ended is not None:
            return
        if self._first is None:
            self._first = int(cycle[0])
        first = self._first
        self._look(raw)
        self._record(lambda: self._writer.append({**raw, "time": cycle - first}))

    def event(self, level: str, text: str) -> None:
        """Note an event at the time of the next row."""
        self._record(lambda: self._writer.event(self._writer.rows * self._cycle_time, level, text))

    def _record(self, record: Callable[[], None]) -> None:
        """Call ``record`` unless the recording has ended already."""
        if self.ended is not None:
            return
        try:
            record()
        except BacklogError as error:
            self.ended = str(error)

    def remark(self, text: str) -> str | None:
        """Store a remark of the operator; return why that was not possible. The recording goes on in either case."""
        try:
            self.event("note", text)
        except Exception as error:  # noqa: BLE001 - told to the operator; rows have a way of their own to fail
            return one_sentence(error)
        return None

    def close(self, *, complete: bool, accepted: bool | None, quality: dict[str, Any] | None) -> Path:
        """Finish the file; slow (compression, disk): call it where nobody waits.

        Raises
        ------
        RecordingError
            If the disk refuses; the ``.part`` file is let go with what it has.
        """
        try:
            return self._writer.close(complete=complete, accepted=accepted, quality=quality)
        except RecordingError:
            with suppress(RecordingError):
                self._writer.abandon()
            raise

    def _si(self, raw: dict[str, NDArray[Any]], name: str, index: int) -> float:
        return float(raw[name][index]) * self._scaling.scale(name) + self._scaling.offset(name)

    def _look(self, raw: dict[str, NDArray[Any]]) -> None:
        figures, cycle = self.figures, raw["cycle"]
        before = int(cycle[0]) - 1 if self._last_cycle is None else self._last_cycle
        self._last_cycle = int(cycle[-1])
        missing = self._last_cycle - before - cycle.size
        if missing:
            figures.lost_cycles += missing
            self.event("warning", f"{missing} cycles missing between cycle {before} and {self._last_cycle}")
        self.temperature = self._si(raw, "temperature", -1)
        figures.rows += cycle.size
        figures.saturated += int(np.count_nonzero(np.abs(raw["load_torque"].astype(np.int32)) >= _FULL_SCALE))
        if not self._steady:
            return
        angle = self._si(raw, "load_angle", -1)
        if math.isnan(self._steady_start):
            self._steady_start = self._si(raw, "load_angle", 0)
        figures.travel = max(figures.travel, abs(angle - self._steady_start))
        figures.samples += cycle.size
        velocity, torque = raw["motor_velocity"], raw["load_torque"]
        figures.velocity_sum += (
            float(velocity.sum(dtype=np.int64)) * self._scaling.scale("motor_velocity") / self._ratio
        )
        figures.torque_sum += (
            float(torque.sum(dtype=np.int64)) * self._scaling.scale("load_torque")
            + self._scaling.offset("load_torque") * cycle.size
        )
        scale = self._scaling.scale("temperature")
        figures.temperature_low = min(figures.temperature_low, float(raw["temperature"].min()) * scale)
        figures.temperature_high = max(figures.temperature_high, float(raw["temperature"].max()) * scale)
