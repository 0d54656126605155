"""Figures of cycles: how late they began, how long the frame took, when everything was done."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.cycle.host import StealLog

EDGES_US = (0, 10, 20, 30, 50, 75, 100, 150, 200, 300, 500, 1000, 2000, 5000, 10_000, 100_000)
"""Lower edges of the histograms, µs; the last bin has no end."""


@dataclass(frozen=True, slots=True)
class Distribution:
    """Times in µs, with counts (len(EDGES_US),) by :data:`EDGES_US`."""

    median: float
    p99: float
    p999: float
    maximum: float
    histogram: tuple[int, ...]

    @staticmethod
    def of(times_ns: NDArray[np.int64]) -> Distribution:
        """Return the distribution of times (n,), ns."""
        times = times_ns / 1000.0
        counts = np.histogram(times, [*EDGES_US, np.inf])[0]
        median, p99, p999, maximum = np.percentile(times, (50.0, 99.0, 99.9, 100.0)).tolist()
        return Distribution(median, p99, p999, maximum, tuple(counts.tolist()))


@dataclass(frozen=True, slots=True)
class Notes:
    """What a loop noted of its cycles, each of shape (n,): slot number; due, awake, frame back, done in ns; counter."""

    slot: NDArray[np.int64]
    due: NDArray[np.int64]
    woke: NDArray[np.int64]
    back: NDArray[np.int64]
    done: NDArray[np.int64]
    wkc: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class LoopFigures:
    """One loop in one run.

    Attributes
    ----------
    late : cycles that began a period late or more.
    missed : slots that had passed before their cycle could begin.
    lost : cycles without an answer in time; wrong : with another working counter than the others.
    beside_stolen : of the slots missed and the cycles lost or wrong, those within 50 ms of time the host took away.
    wake : from due to awake; trip : from there to the frame back; cycle : from due to everything done.
    steal_s : time the host took away meanwhile.
    """

    cycles: int
    late: int
    missed: int
    lost: int
    wrong: int
    beside_stolen: int
    steal_s: float
    wake: Distribution
    trip: Distribution
    cycle: Distribution


def figures(notes: Notes, log: StealLog, period_ns: int) -> LoopFigures:
    """Return the figures of a run whose slots are ``period_ns`` apart."""
    expected = int(np.bincount(notes.wkc[notes.wkc >= 0]).argmax()) if (notes.wkc >= 0).any() else 0
    gaps = np.diff(notes.slot) - 1
    lost, wrong = notes.wkc < 0, (notes.wkc >= 0) & (notes.wkc != expected)
    beside = int(gaps[log.near(notes.due[1:])].sum()) + int(np.count_nonzero(log.near(notes.due[lost | wrong])))
    answered = ~lost
    return LoopFigures(
        cycles=notes.slot.size,
        late=int(np.count_nonzero(notes.woke - notes.due >= period_ns)),
        missed=int(gaps.sum()),
        lost=int(np.count_nonzero(lost)),
        wrong=int(np.count_nonzero(wrong)),
        beside_stolen=beside,
        steal_s=log.total_s,
        wake=Distribution.of(notes.woke - notes.due),
        trip=Distribution.of((notes.back - notes.woke)[answered]),
        cycle=Distribution.of(notes.done - notes.due),
    )


@dataclass(frozen=True, slots=True)
class RateFigures:
    """Both loops at one rate, Hz; ``c`` is None where there is no compiler or no source."""

    rate: float
    python: LoopFigures
    c: LoopFigures | None

    @property
    def ratio(self) -> tuple[float, float] | None:
        """Median and 99.9 % of the whole cycle, bus process by C loop."""
        if self.c is None:
            return None
        mine, theirs = self.python.cycle, self.c.cycle
        return mine.median / theirs.median, mine.p999 / theirs.p999

    def as_dict(self) -> dict[str, Any]:
        """For a script."""
        return {**asdict(self), "ratio": self.ratio, "histogram_edges_us": EDGES_US}
