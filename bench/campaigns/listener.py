"""Interfaces for whatever follows a campaign (a terminal, a page, a script, or nothing), and for what sees its rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, Protocol

from numpy.typing import NDArray

from bench.campaigns.planning.plan import Plan
from bench.campaigns.planning.schedule import Task
from bench.campaigns.taken import Taken
from bench.cycle.channels import Scaling
from bench.cycle.sink import Sink
from bench.cycle.view import View
from bench.errors import one_sentence
from bench.protocols import Point, Segment


@dataclass(frozen=True, slots=True)
class Expected:
    """A point as the run knows it: its number from 1, its identity, and whether an earlier run has done it."""

    number: int
    identity: str
    point: Point
    done: bool


class Listener(Protocol):
    """Receives the progress of a campaign."""

    def planned(self, campaign_id: str, plan: Plan, points: Sequence[Expected]) -> None:
        """The bench is open and this is what will be done."""
        ...

    def started(self, task: Task, recording_id: str) -> None:
        """A recording begins."""
        ...

    def advanced(self, bench_time_s: float, temperature: float) -> None:
        """Bench time went on."""
        ...

    def finished(self, taken: Taken) -> None:
        """A recording is in its file."""
        ...

    def paused(self, now: bool, why: str = "") -> None:
        """Points wait for the operator, or no longer; called again now and then while they wait.

        ``why`` is the sentence where it was not the operator who paused.
        """
        ...

    def noticed(self, text: str) -> None:
        """The bench is open, and ``text`` says what about it is not as it should be."""
        ...


class Silent:
    """A listener that ignores everything."""

    def planned(self, campaign_id: str, plan: Plan, points: Sequence[Expected]) -> None:
        """Do nothing."""

    def started(self, task: Task, recording_id: str) -> None:
        """Do nothing."""

    def advanced(self, bench_time_s: float, temperature: float) -> None:
        """Do nothing."""

    def finished(self, taken: Taken) -> None:
        """Do nothing."""

    def paused(self, now: bool, why: str = "") -> None:
        """Do nothing."""

    def noticed(self, text: str) -> None:
        """Do nothing."""


class Tap(Protocol):
    """Looks at the rows of every motion on their way to the recording; must not wait for anything."""

    def opened(self, view: View) -> None:
        """The bench is open; it may be looked at from another thread from now on, also where nothing moves."""
        ...

    def begin(self, scaling: Scaling, bench_time: datetime, what: str) -> None:
        """A motion begins: scale of its channels, the bench's time of day (UTC) at its first row, its kind."""
        ...

    def segment(self, segment: Segment | None) -> None:
        """From the next row on the motion is in this segment."""
        ...

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Raw rows by channel, not to be changed."""
        ...


class Tapped:
    """A sink that passes everything on and shows it to a tap as well.

    A tap that fails is dropped and reported; the motion goes on.

    Parameters
    ----------
    sink : receives everything.
    tap : receives rows and segments.
    report_failure : called once with a sentence if the tap fails.
    """

    def __init__(self, sink: Sink, tap: Tap, report_failure: Callable[[str], None]) -> None:
        self._sink, self._report_failure = sink, report_failure
        self._tap: Tap | None = tap

    def segment(self, segment: Segment | None) -> None:
        """Hand on and show."""
        self._sink.segment(segment)
        self._show(lambda tap: tap.segment(segment))

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Hand on and show."""
        self._sink.rows(raw)
        self._show(lambda tap: tap.rows(raw))

    def event(self, level: str, text: str) -> None:
        """Hand on; a tap is no record."""
        self._sink.event(level, text)

    def _show(self, look: Callable[[Tap], None]) -> None:
        if self._tap is None:
            return
        try:
            look(self._tap)
        except Exception as error:  # noqa: BLE001 - who only looks never ends a motion
            self._tap = None
            self._report_failure(f"live values have stopped, the recording goes on: {one_sentence(error)}")
