"""Live values of a run: every row is looked at, few numbers leave. The bus side only appends a reference to a list."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from datetime import datetime, timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.cycle.channels import Scaling
from bench.cycle.view import View
from bench.protocols import Segment
from bench.service.process.condition import SHOWN, condition
from bench.service.process.covered import Covered
from bench.service.process.revolution import Revolution

Message = dict[str, Any]

_MOST_WAITING = 20_000
"""Blocks that may wait; at 2 kHz in blocks of one that is ten seconds. Then blocks are dropped, and counted."""
_EVERY_S = 0.2
_TORQUES = ("motor_torque", "load_motor_torque")
_SPECTRUM_EVERY_S = 0.5
_CONDITION_EVERY_S = 0.5


class LiveTap:
    """Turns rows into buckets of minimum, maximum, mean and last value, one about every 0.2 s of the clock.

    Parameters
    ----------
    emit : is called from the tap's own thread with ``live``, ``spectrum`` and ``condition`` messages.
    ratio : of the gearbox.
    on_begin : is called with the bench's time of day when a motion begins.
    on_open : is called once the bench is open.
    """

    def __init__(
        self,
        emit: Callable[[Message], None],
        ratio: float,
        on_begin: Callable[[datetime], None] = lambda _: None,
        on_open: Callable[[], None] = lambda: None,
    ) -> None:
        self._emit, self._ratio, self._on_begin, self._on_open = emit, ratio, on_begin, on_open
        self._view: View | None = None
        self._condition_sent = 0.0
        self._waiting: deque[tuple[Any, ...]] = deque()
        self._ended = threading.Event()
        self.dropped = 0
        self._scaling: Scaling | None = None
        self._began = datetime.min
        self._cycle: int | None = None
        self._what = ""
        self._steady = False
        self._revolution = Revolution()
        self._spectrum_sent = 0.0
        self._whole = False
        self._conditions: dict[str, Any] = {}
        self._covered = Covered()
        self._at = 0.0
        self._thread = threading.Thread(target=self._work, name="live-tap", daemon=True)
        self._thread.start()

    # -- called by the runner: no work here ----------------------------------------------------------------------------

    def opened(self, view: View) -> None:
        """Look at a bench that is open, in motion or not: its condition is sent from now on."""
        self._view = view
        self._on_open()

    def begin(self, scaling: Scaling, bench_time: datetime, what: str) -> None:
        """Note a new motion."""
        self._on_begin(bench_time)
        self._waiting.append(("begin", scaling, bench_time, what))

    def segment(self, segment: Segment | None) -> None:
        """Note a new segment."""
        self._waiting.append(("segment", segment))

    def rows(self, raw: Mapping[str, NDArray[Any]]) -> None:
        """Keep a reference to the rows; nothing is copied or computed on this thread."""
        if len(self._waiting) >= _MOST_WAITING:
            self.dropped += 1
            return
        self._waiting.append(("rows", raw))

    def close(self) -> None:
        """Hand over what is left and end the thread."""
        self._ended.set()
        self._thread.join()

    # -- the tap's own thread ------------------------------------------------------------------------------------------

    def _work(self) -> None:
        while not self._ended.wait(_EVERY_S):
            self._drain()
            self._tell_condition()
        self._drain()

    def _tell_condition(self) -> None:
        """Tell how the bench is: between motions and while it is paused no row comes, yet it has values."""
        if self._view is None or time.monotonic() - self._condition_sent < _CONDITION_EVERY_S:
            return
        self._condition_sent = time.monotonic()
        seen = condition(self._view, "run")
        if seen is not None:
            self._emit(seen)

    def _drain(self) -> None:
        blocks: list[Mapping[str, NDArray[Any]]] = []
        for _ in range(len(self._waiting)):
            item = self._waiting.popleft()
            if item[0] == "rows":
                blocks.append(item[1])
                continue
            self._reduce(blocks)
            blocks = []
            if self._whole:
                # the last word of a motion that ends here
                self._tell_spectrum()
            self._whole = False
            if item[0] == "begin":
                _, self._scaling, self._began, self._what = item
                self._cycle, self._steady = None, False
                self._revolution.clear()
                self._covered.begin(self._began.timestamp())
            else:
                self._steady = item[1] is Segment.STEADY
        self._reduce(blocks)

    def _reduce(self, blocks: list[Mapping[str, NDArray[Any]]]) -> None:
        scaling = self._scaling
        blocks = [block for block in blocks if block["cycle"].size]
        if not blocks or scaling is None:
            return
        cycle = np.concatenate([block["cycle"] for block in blocks])
        if self._cycle is None:
            self._cycle = int(cycle[0])
        dt = scaling.scale("time")
        values: dict[str, list[float]] = {}
        angles: dict[str, NDArray[np.float64]] = {}
        for name in SHOWN:
            if name not in scaling.specs or name not in blocks[0]:
                continue
            raw = np.concatenate([block[name] for block in blocks])
            scale, offset = scaling.scale(name), scaling.offset(name)
            ends = sorted((float(raw.min()) * scale + offset, float(raw.max()) * scale + offset))
            shown = (*ends, float(raw.mean()) * scale + offset, float(raw[-1]) * scale + offset)
            values[name] = [float(f"{value:.9g}") for value in shown]
            if name in ("motor_angle", "load_angle"):
                angles[name] = raw * scale + offset
        start = self._began + timedelta(seconds=(int(cycle[0]) - self._cycle) * dt)
        end = self._began + timedelta(seconds=(int(cycle[-1]) - self._cycle + 1) * dt)
        self._emit(
            {
                "type": "live",
                "start": start.timestamp(),
                "end": end.timestamp(),
                "what": self._what,
                "dropped": self.dropped,
                "values": values,
            }
        )
        if len(angles) == 2:
            covered = self._covered.add(angles["motor_angle"] / self._ratio, end.timestamp())
            if self._steady:
                self._turn(angles, values, end.timestamp(), covered)

    def _turn(
        self,
        angles: dict[str, NDArray[np.float64]],
        values: dict[str, list[float]],
        end_s: float,
        covered: dict[str, float],
    ) -> None:
        theta = angles["motor_angle"] / self._ratio
        self._revolution.add(theta, angles["load_angle"] - theta)
        self._conditions = {
            "torque": values["load_torque"][2],
            "velocity": values["motor_velocity"][2] / self._ratio,
            "temperature": values["temperature"][2],
            "also": covered | {name: values[name][2] for name in _TORQUES if name in values},
        }
        self._at = end_s
        whole, self._whole = self._whole, self._revolution.is_whole
        first = self._whole and not whole
        if first or time.monotonic() - self._spectrum_sent > _SPECTRUM_EVERY_S:
            self._tell_spectrum()

    def _tell_spectrum(self) -> None:
        self._spectrum_sent = time.monotonic()
        spectrum = self._revolution.spectrum()
        message: Message = {"type": "spectrum", "share": self._revolution.share}
        if spectrum is not None:
            message |= {
                "amplitude": [round(float(value) * 1e9) / 1e9 for value in spectrum.amplitude],
                "curve": [round(float(value) * 1e8) / 1e8 for value in spectrum.curve],
                "rms": spectrum.rms,
                **self._conditions,
                "what": self._what,
                "at": self._at,
            }
        self._emit(message)
