"""What pages are shown of the run that has the bench: its status, plan, points, live values, the last spectrum."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bench.service.files.book import Book
from bench.service.runs.history import History
from bench.service.runs.stream import Stream

Message = dict[str, Any]
FREE: Message = {"type": "status", "phase": "free", "label": ""}
_OPENING: Message = {"type": "status", "phase": "opening", "label": "the bench is being opened"}


class Shown:
    """Keeps what a page that is opened later needs, and sends it to those that look on."""

    def __init__(self, stream: Stream, book: Book) -> None:
        self._stream, self._book = stream, book
        self.history = History()
        self.plan: Message | None = None
        self.points: dict[str, Message] = {}
        self.status: Message = FREE
        self.spectrum: Message | None = None
        self.condition: Message | None = None
        """How the bench was when it was read last, with or without a run; or why nobody reads it."""
        self.on_spectrum: Callable[[Message], None] = stream.publish
        """Where spectra go; the service draws its model over them first."""
        self.on_phase: Callable[[], None] = lambda: None
        """Is called when the phase has changed: other things may be done now."""

    def plan_message(self) -> Message | None:
        """The plan of the run with its points as they stand."""
        return None if self.plan is None else {**self.plan, "points": list(self.points.values())}

    def point_that_ran(self) -> str:
        """The point that runs, as an alarm names it; empty if none does."""
        point = self.points.get(str(self.status.get("identity")))
        return "" if point is None else f"point {point['number']} of {len(self.points)}, {point['label']}"

    def begin(self, clear: bool) -> None:
        """A run begins; ``clear`` forgets the one before."""
        if clear:
            self.plan, self.points, self.spectrum = None, {}, None
            self.history.clear()
            self._stream.publish({"type": "clear"})
        self.status = _OPENING
        self._stream.publish(self.status)

    def end(self, text: str) -> None:
        """The run has ended."""
        self.status = {**FREE, "label": text}
        self._stream.publish(self.status)

    def take(self, message: Message) -> None:
        """Take what the run says.

        Raises
        ------
        KeyError
            If a message lacks what it should hold.
        """
        kind = message["type"]
        if kind == "plan":
            self.points = {point["identity"]: point for point in message["points"]}
            self.plan = {key: value for key, value in message.items() if key != "points"}
        elif kind == "point":
            self.points[message["identity"]] = {key: value for key, value in message.items() if key != "type"}
        elif kind == "status":
            before, self.status = self.status, message
            if any(before.get(key) != message.get(key) for key in ("phase", "pausing")):
                self.on_phase()
        elif kind == "live":
            self.history.add(message)
        elif kind in ("condition", "unread"):
            self.condition = message
        elif kind == "notice":
            self._book.write("notice", "bench", message["text"])
        elif kind == "spectrum":
            self.spectrum = message
            self.on_spectrum(message)
            return
        self._stream.publish(message)
