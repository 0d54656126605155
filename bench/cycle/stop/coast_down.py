"""What is seen of both shafts from the beginning of a stop on: when each came to rest, how far the motor turned."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bench.cycle.decode import Decoded
from bench.safety.stop_record import Sample

SHAFTS = ("input", "load")
_WINDOW_S = 0.02
"""Speeds are means over so long: one cycle is noise."""
_REST_S = 0.04
"""A shaft is at rest when it was seen slow for so long."""
_MOST_SAMPLES = 200


class CoastDown:
    """Looks at the cycles of a stop; times are the bus's own, by the numbers of its cycles.

    Parameters
    ----------
    standstill : motor speed below which the input shaft counts as standing, rad/s.
    ratio : of the gearbox; the load shaft stands below ``standstill / ratio``.
    cycle_time_s : of the bus.

    Attributes
    ----------
    first_cycle : bus cycle in which the stop began, None before anything came.
    silent_s : time since the last cycle with a right working counter.
    travel_rad : what the motor turned, either way; None where no cycle was seen.
    """

    def __init__(self, standstill: float, ratio: float, cycle_time_s: float) -> None:
        self._limits = (standstill, standstill / ratio)
        self._cycle_time = cycle_time_s
        self._window = max(1, round(_WINDOW_S / cycle_time_s))
        self._sums, self._count = np.zeros(3), 0
        self._slow_since: list[float | None] = [None, None]
        self._slow = [False, False]
        self._last_good = self._last = 0
        self._samples: list[Sample] = []
        self.first_cycle: int | None = None
        self.travel_rad: float | None = None

    def keep(self, seen: Decoded) -> None:
        """Take the cycles that came."""
        if not seen.size:
            return
        cycle, inputs, good = seen.raw["cycle"], seen.inputs, seen.inputs.good
        if self.first_cycle is None:
            self.first_cycle = int(cycle[0])
            self._last_good = self.first_cycle - 1
        self._last = int(cycle[-1])
        if not good.any():
            return
        self._last_good = int(cycle[good][-1])
        values = np.array([inputs.motor_velocity[good], inputs.load_velocity[good], inputs.load_torque[good]])
        self.travel_rad = (self.travel_rad or 0.0) + float(np.abs(values[0]).sum()) * self._cycle_time
        moments = (cycle[good] - self.first_cycle + 1) * self._cycle_time
        begin = 0
        while begin < moments.size:
            end = min(moments.size, begin + self._window - self._count)
            self._sums += values[:, begin:end].sum(axis=1)
            self._count += end - begin
            begin = end
            if self._count == self._window:
                self._look(float(moments[end - 1]), self._sums / self._count)
                self._sums, self._count = np.zeros(3), 0

    @property
    def silent_s(self) -> float:
        """Time since the last cycle with a right working counter, s."""
        return (self._last - self._last_good) * self._cycle_time

    @property
    def input_is_slow(self) -> bool:
        """Whether the input shaft was slow when it was last looked at."""
        return self._slow[0]

    def at_rest(self, seen: bool = True) -> dict[str, bool | None]:
        """Whether each shaft has been slow for the rest time; None where nothing is ``seen`` of it any more."""
        if not seen or self.travel_rad is None:
            return dict.fromkeys(SHAFTS)
        now = self._samples[-1].time_s if self._samples else -math.inf
        return {
            shaft: since is not None and now - since >= _REST_S - 0.5 * self._cycle_time
            for shaft, since in zip(SHAFTS, self._slow_since, strict=True)
        }

    def to_rest_s(self, seen: bool = True) -> float | None:
        """When both shafts had come to rest, s after the stop began; None where that was not seen."""
        first, second = self._slow_since
        if first is None or second is None or not all(self.at_rest(seen).values()):
            return None
        return max(first, second)

    @property
    def samples(self) -> tuple[Sample, ...]:
        """The coast-down, thinned."""
        return tuple(self._samples[:: max(1, len(self._samples) // _MOST_SAMPLES)])

    def _look(self, at: float, means: NDArray[np.float64]) -> None:
        motor, load, torque = (float(mean) for mean in means)
        self._samples.append(Sample(round(at, 6), motor, load, torque))
        for shaft, (speed, limit) in enumerate(zip((motor, load), self._limits, strict=True)):
            self._slow[shaft] = abs(speed) < limit
            if not self._slow[shaft]:
                self._slow_since[shaft] = None
            elif self._slow_since[shaft] is None:
                self._slow_since[shaft] = at
