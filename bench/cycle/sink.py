"""What a rig hands its cycles to."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray

from bench.protocols import Segment


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
