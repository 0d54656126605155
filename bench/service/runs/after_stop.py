"""After a stop by a limit or a fault torque comes back by three acts of the operator: acknowledge, reset, go on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bench.configuration import BenchFile
from bench.safety.acts import acknowledge, latch_of
from bench.safety.latch import NEXT, Act
from bench.service.files.book import Book
from bench.service.refusals import NotNow
from bench.service.runs.keeper import Keeper
from bench.service.runs.runs import Run, following, new_id, now
from bench.service.settings import Settings


class AfterStop:
    """What is due on the bench whose last run ended; opens no bus itself.

    Without any run yet there may be a stop all the same: a bench behind a network interface keeps its latch, whoever
    ran it.
    """

    def __init__(self, bench: BenchFile, settings: Settings, keeper: Keeper, book: Book) -> None:
        self._bench, self._settings, self._keeper, self._book = bench, settings, keeper, book

    def latch(self) -> dict[str, Any]:
        """What stopped the bench, and which act is due before it may give torque again; empty texts for nothing."""
        latch = latch_of(self._bench, self._place()).read()
        due = NEXT[latch.standing]
        return {
            "standing": latch.standing.value,
            "cause": latch.cause,
            "text": latch.text,
            "due": "" if due is None else due.value,
        }

    def acknowledge(self, by: str) -> None:
        """Say for the bench's record that somebody has read why it stopped, if that is what is due."""
        if self.latch()["due"] == Act.ACKNOWLEDGE.value:
            acknowledge(self._bench, self._place(), by)

    def reset(self, by: str, after: str | None) -> Run:
        """Take the drives' faults away after the run of this id; a process of its own opens the bus for it.

        Raises
        ------
        NotNow
            If another run has ended since, or nothing was run yet and no stop is on record.
        """
        run, stopped = self._last_ended(), self.latch()
        if after != (None if run is None else run.id):
            last = "no run has ended yet" if run is None else f"{run.title} has ended since, look at it first"
            raise NotNow(f"this reset was meant for another run: {last}")
        if run is None and not stopped["due"]:
            raise NotNow("nothing was run yet, there is nothing to reset")
        self._book.write("reset", by, f"reset after: {stopped['text'] or 'no stop on record'}")
        following_run = following(run or self._settings_run(), by, resets=True, title="Reset of the bench")
        return self._keeper.begin(following_run, by)

    def _place(self) -> Path:
        run = self._last_ended()
        return self._settings.folder if run is None else Path(run.folder)

    def _settings_run(self) -> Run:
        """What a reset follows where this service has run nothing."""
        settings = self._settings
        folder = str(settings.folder.absolute())
        return Run(new_id(), "", "", settings.bench, folder, "", now(), interface=settings.interface)

    def _last_ended(self) -> Run | None:
        runs = self._keeper.runs.all()
        ended = [run for run in runs if run.state == "ended" and run.end.get("kind") != "withdrawn"]
        return ended[-1] if ended else None
