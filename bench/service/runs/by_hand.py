"""What is done by hand, as the service sees it: a motion begun, held, let go; the torque sensor tared."""

from __future__ import annotations

from math import degrees
from typing import Any

from bench.campaigns.operator.gentle import greatest_speed
from bench.configuration import BenchFile
from bench.service.files.book import Book
from bench.service.refusals import NotNow
from bench.service.runs.keeper import Keeper
from bench.service.runs.runs import Run, new_id, now
from bench.service.settings import Settings

FOLDER = "by-hand"
"""Of the service's own: an emulated bench keeps its latch there; nothing is recorded."""


class ByHand:
    """Begins motions by hand and passes on that their button is held; begins tarings."""

    def __init__(self, bench: BenchFile, settings: Settings, keeper: Keeper, book: Book) -> None:
        self._bench, self._settings, self._keeper, self._book = bench, settings, keeper, book

    def begin(self, velocity: float, by: str) -> Run:
        """Let the load side be turned at a velocity (rad/s) in the name of ``by``.

        Raises
        ------
        NotNow
            If it is too fast, or none.
        """
        most = greatest_speed(self._bench.configuration)
        if velocity == 0.0 or abs(velocity) > most:
            raise NotNow(f"by hand the load side turns at {degrees(most):.3g} °/s at most, either way, and not at none")
        return self._add(f"Motion by hand, {degrees(velocity):+.3g} °/s", by, "by_hand", by_hand=velocity)

    def tare(self, by: str) -> Run:
        """Let the torque sensor's zero be taken at rest, without torque, in the name of ``by``."""
        return self._add("Taring of the torque sensor", by, "tare", tares=True)

    def _add(self, title: str, by: str, act: str, **what: Any) -> Run:
        run = Run(
            id=new_id(),
            campaign="",
            title=title,
            bench=self._settings.bench,
            folder=str(self._settings.state.absolute() / FOLDER),
            by=by,
            asked_at=now(),
            interface=self._settings.interface,
            real_time=True,
            **what,
        )
        self._book.write(act, by, title, run=run.id)
        return self._keeper.begin(run, by)

    def hold(self, run_id: str, held: bool) -> str:
        """Pass on that the button is held, or no longer; return which.

        Raises
        ------
        NotNow
            If that motion is over: the page lets go of its button.
        """
        run = self._keeper.runs.get(run_id)
        if run is None or run.by_hand is None or run.state == "ended":
            raise NotNow("this motion by hand is over; let go, and press again")
        # before its socket is there nobody hears it, and nothing moves before the first word
        self._keeper.send_to_run("hold" if held else "let_go", run=run_id)
        return "held" if held else "let go"
