"""What a run does of what an operator wants: each act is meant for one run, and some for one of its points.

A sheet on a page may be older than what it shows: what was meant for one run is refused by the next. STOP is for
whatever runs, and is never refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from bench.campaigns.operator.directions import Directions
from bench.errors import BenchError
from bench.service.process.hold import Hold

Message = dict[str, Any]
_SKIPPABLE = frozenset({"waiting", "running", "heating"})
_REPEATABLE = frozenset({"done", "failed", "skipped", "running", "saving"})
ON_POINTS: dict[str, frozenset[str]] = {"skip": _SKIPPABLE, "repeat": _REPEATABLE}
"""Acts on a point, and in which states of it they make sense."""


class Refused(BenchError):
    """An act that was meant for something else."""


class Reports(Protocol):
    """Who reports how the run stands."""

    def report_status(self, phase: str, label: str = "", **more: Any) -> None:
        """Say where the run stands."""
        ...

    def pausing(self, asked: bool) -> None:
        """Report a pause that was asked for or taken back."""
        ...

    def asked(self, wish: str, identity: str) -> None:
        """Report what was asked for a point."""
        ...

    def noticed(self, text: str) -> None:
        """Report what is not as it should be."""
        ...

    def points(self) -> Mapping[str, Message]:
        """The points of the run by identity, each with number and state."""
        ...


class Obedience:
    """Does what is asked of one run.

    Parameters
    ----------
    run : id of the run.
    directions : where the wishes go.
    reporter : reports what was done, or why not.
    hold : hears that the button of a motion by hand is held, or no longer; None where there is none.
    """

    def __init__(self, run: str, directions: Directions, reporter: Reports, hold: Hold | None = None) -> None:
        self._run, self._directions, self._reporter = run, directions, reporter
        self._acts: dict[str, Callable[[Message], None]] = {
            "pause": self._pause,
            "go_on": self._go_on,
            "end": self._end,
            "skip": self._skip,
            "repeat": self._repeat,
            "note": self._note,
        }
        if hold is not None:
            self._acts |= {"hold": lambda _: hold.still(), "let_go": lambda _: hold.let_go()}

    def __call__(self, message: Message) -> None:
        """Do what is asked, or say in one sentence why not; what is not understood is no order."""
        act = str(message.get("do", ""))
        if act == "stop":
            self._end(message)
            return
        do = self._acts.get(act)
        if do is None:
            return
        try:
            self._require_meant(act, message)
            do(message)
        except BenchError as error:
            self._reporter.noticed(str(error))

    def _require_meant(self, act: str, message: Message) -> None:
        meant = message.get("run")
        name = act.replace("_", " ")
        if meant != self._run:
            whom = f"run {meant}" if meant else "no run by its name"
            raise Refused(f"{name} was meant for {whom}, and this is run {self._run}: nothing was done")
        if act not in ON_POINTS:
            return
        point = self._reporter.points().get(_point(message))
        if point is None:
            raise Refused(f"{name} was meant for a point that this run does not have: nothing was done")
        if point["state"] not in ON_POINTS[act]:
            raise Refused(f"{name} was meant for point {point['number']}, which is {point['state']}: nothing was done")

    def _end(self, message: Message) -> None:
        self._directions.stop()
        self._reporter.report_status("stopping", "the service asked for the bench to be brought to rest")

    def _pause(self, message: Message) -> None:
        self._directions.pause()
        self._reporter.pausing(True)

    def _go_on(self, message: Message) -> None:
        self._directions.go_on()
        self._reporter.pausing(False)

    def _skip(self, message: Message) -> None:
        self._directions.skip(_point(message))
        self._reporter.asked("skip", _point(message))

    def _repeat(self, message: Message) -> None:
        self._directions.repeat(_point(message))
        self._reporter.asked("repeat", _point(message))

    def _note(self, message: Message) -> None:
        self._directions.note(str(message.get("text", "")))


def _point(message: Message) -> str:
    """Return the identity of the point an act is for."""
    return str(message.get("point", message.get("identity", "")))
