"""The twin of the run that has the bench: starts with it, and what it sees becomes an alarm, or a pause."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.service.alarms.alarms import Alarms
from bench.service.analyses.overlay import Overlay
from bench.service.files.book import Book
from bench.service.runs.keeper import Keeper
from bench.service.runs.runs import Run
from bench.twin.companion import Companion
from bench.twin.job import BESIDE_EMULATED, LOWEST

Message = dict[str, Any]


class Twins:
    """Keeps one twin beside the run that asked for one; its process ends with the run, or with this service.

    Parameters
    ----------
    state : folder of the service's own files.
    overlay : draws the model over each revolution of the run that it watches.
    """

    def __init__(self, state: Path, keeper: Keeper, alarms: Alarms, book: Book, overlay: Overlay) -> None:
        self._state, self._keeper, self._alarms, self._book = state.absolute(), keeper, alarms, book
        self._overlay = overlay
        self._run: Run | None = None
        self._companion: Companion | None = None
        self.last: Message | None = None
        """what the twin said last of the run it watches"""

    async def look(self) -> None:
        """Start a twin for the present run, if it asked for one; let the twin of a run that ended finish."""
        run = self._keeper.runs.running()
        if run is not None and self._run is not None and run.id == self._run.id:
            return
        if self._companion is not None and (run is None or run.twin is not None):
            self._companion.finish()
        if run is None or run.twin is None:
            if run is not None:
                # the last revolution of a run that is over keeps its model until another run begins
                self._overlay.watch(None)
            return
        self._run = run
        await self._start(run, run.twin)

    def close(self) -> None:
        """End it with the service; the run goes on."""
        if self._companion is not None:
            self._companion.kill()

    async def _start(self, run: Run, model: str) -> None:
        self._alarms.set("TWIN_ENDED", None)
        loop = asyncio.get_running_loop()

        def hear(message: Message) -> None:
            # from the thread that listens; a service that is ending has no loop any more, and nothing to tell
            if not loop.is_closed():
                loop.call_soon_threadsafe(self._take, run, message)

        nice = LOWEST if run.real_time or run.interface is not None else BESIDE_EMULATED
        job = self._state / "runs" / run.id / "twin.json"
        if self._companion is not None:
            await asyncio.to_thread(self._companion.kill)
        try:
            await asyncio.to_thread(self._overlay.watch, Path(model))
            self._companion = await asyncio.to_thread(Companion, Path(model), Path(run.folder), job, hear, nice)
        except (BenchError, OSError) as error:
            self._companion = None
            self._alarms.set("TWIN_ENDED", f"{run.title} is not watched: {error}")
            return
        self._keeper.shown.on_phase()
        self._book.write("twin", "service", f"{run.title} is watched by {model}", run=run.id)

    def _take(self, run: Run, message: Message) -> None:
        self.last = message
        if message["type"] == "no_longer_holds":
            since, folder = str(message["since"]), Path(run.folder).name
            self._alarms.raise_("TWIN", f"{run.title}: {message['text']}", since, folder)
            if run.twin_pause and self._keeper.send_to_run("pause", run=run.id):
                self._book.write("pause", "the twin", "no further point begins", run=run.id)
        elif message["type"] == "ended" and message["why"]:
            self._alarms.set("TWIN_ENDED", f"{run.title} is no longer watched: {message['why']}")
