"""What a rig hands its cycles to."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from numpy.typing import NDArray

from bench.cycle.end import NOT_WRITTEN, End, EndKind
from bench.errors import one_sentence
from bench.protocols import Segment
from bench.safety import Cause


class Sink(Protocol):
    """Takes rows in order; segments and events refer to the rows taken so far."""

    def segment(self, segment: Segment | None) -> None:
        """From the next row on the recording is in this segment (None: in none)."""
        ...

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Take raw values (n,) by channel."""
        ...

    def event(self, level: str, text: str) -> None:
        """Note what happened at the next row."""
        ...


class NoSink:
    """Drops everything: for motion that is not recorded."""

    def segment(self, segment: Segment | None) -> None:
        """Ignore."""

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Ignore."""

    def event(self, level: str, text: str) -> None:
        """Ignore."""


class SafeSink:
    """Passes everything on until the sink fails: a recorder that cannot write must never keep the bench from stopping.

    Attributes
    ----------
    failure : the end that a failed recorder makes of a run; None as long as it works.
    """

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self.failure: End | None = None

    def segment(self, segment: Segment | None) -> None:
        """Pass on."""
        self._pass_on(lambda: self._sink.segment(segment))

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        """Pass on."""
        self._pass_on(lambda: self._sink.rows(raw))

    def event(self, level: str, text: str) -> None:
        """Pass on."""
        self._pass_on(lambda: self._sink.event(level, text))

    def _pass_on(self, pass_on: Callable[[], None]) -> None:
        if self.failure is not None:
            return
        try:
            pass_on()
        except Exception as error:  # noqa: BLE001 - whatever a recorder raises, the bench is stopped in order
            self.failure = End(EndKind.TRIPPED, f"{NOT_WRITTEN}: {one_sentence(error)}", Cause.RECORDER)
