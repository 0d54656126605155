"""After a stop by a limit or a fault torque comes back by three acts of the operator: acknowledge, reset, go on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from bench.campaigns.acts import acknowledge, latch_of
from bench.configuration import BenchFile
from bench.safety.latch import NEXT, Act
from bench.service.book import Book
from bench.service.keeper import Keeper
from bench.service.refusals import NotNow
from bench.service.runs import Run, following


class AfterStop:
    """What is due on the bench whose last run ended; opens no bus itself.

    Parameters
    ----------
    folder : of all recordings; a bench behind a network interface keeps its latch elsewhere anyway.
    """

    def __init__(self, bench: BenchFile, folder: Path, keeper: Keeper, book: Book) -> None:
        self._bench, self._folder, self._keeper, self._book = bench, folder, keeper, book

    def latch(self) -> dict[str, Any]:
        """What stopped the bench, and which act is due before it may give torque again; empty texts for nothing."""
        run = self._last_ended()
        latch = latch_of(self._bench, self._folder if run is None else Path(run.folder)).read()
        due = NEXT[latch.standing]
        return {"standing": latch.standing.value, "text": latch.text, "due": "" if due is None else due.value}

    def acknowledge(self, by: str) -> None:
        """Say for the bench's record that somebody has read why it stopped, if that is what is due."""
        run = self._last_ended()
        if run is not None and self.latch()["due"] == Act.ACKNOWLEDGE.value:
            acknowledge(self._bench, Path(run.folder), by)

    def reset(self, by: str) -> Run:
        """Take the drives' faults away; a process of its own opens the bus for it.

        Raises
        ------
        NotNow
            If nothing was run yet: there is nothing to be reset.
        """
        run = self._last_ended()
        if run is None:
            raise NotNow("nothing was run yet, there is nothing to reset")
        self._keeper.held = False
        self._book.write("reset", by, f"reset after: {self.latch()['text'] or 'no stop on record'}")
        return self._keeper.add(following(run, by, resets=True, title="Reset of the bench"))

    def _last_ended(self) -> Run | None:
        runs = self._keeper.runs.all()
        ended = [run for run in runs if run.state == "ended" and run.end.get("kind") != "withdrawn"]
        return ended[-1] if ended else None
