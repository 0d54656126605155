"""Requests for runs: a new one, once more, a wish for the one that goes on; each for the run it was meant for."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench.configuration import BenchFile
from bench.service.campaigns.catalog import Catalog
from bench.service.campaigns.planning import require_possible
from bench.service.files.book import Book
from bench.service.models import NewRun
from bench.service.readers import Readers
from bench.service.refusals import NotNow, Unknown
from bench.service.runs.allowed import DONE
from bench.service.runs.keeper import Keeper
from bench.service.runs.lease import Lease
from bench.service.runs.runs import Run, following, new_id, now
from bench.service.settings import Settings

_IS = {"proposed": "is proposed", "queued": "waits", "running": "runs", "ended": "has ended"}


class Requests:
    """Puts runs into the queue and passes wishes on.

    Parameters
    ----------
    bench : of this service.
    plans : plans campaigns in processes of their own.
    check_possible : refuses an act that is not possible now.
    model_path : the model an analysis made.
    """

    def __init__(
        self,
        bench: BenchFile,
        settings: Settings,
        keeper: Keeper,
        book: Book,
        lease: Lease,
        catalog: Catalog,
        plans: Readers,
        check_possible: Callable[[str], None],
        model_path: Callable[[str], Path],
    ) -> None:
        self._bench, self._settings, self._keeper, self._book = bench, settings, keeper, book
        self._lease, self._catalog, self._plans = lease, catalog, plans
        self._check_possible, self._model_path = check_possible, model_path

    def require_running(self, run_id: str) -> Run:
        """Return the run an act was meant for.

        Raises
        ------
        NotNow
            If it does not run (any more): what was meant for one run is not done to the next.
        """
        run = self._keeper.runs.running()
        if run is None or run.id != run_id:
            meant = self._keeper.runs.get(run_id)
            was = f'run "{run_id}"' if meant is None else f"{meant.title}, which {_IS[meant.state]}"
            now_runs = "nothing runs" if run is None else f"{run.title} runs now"
            raise NotNow(f"this was meant for {was}; {now_runs}, and nothing was done to it")
        return run

    def wish(self, by: str, wish: str, run_id: str, **more: str) -> str:
        """Pass an operator's wish on to the run it is meant for, with an entry in the book."""
        self.require_running(run_id)
        if not self._keeper.send_to_run(wish, run=run_id, **more):
            raise NotNow("the run cannot be reached at the moment; STOP works all the same")
        text = DONE[wish].format(*more.values())
        point = {"point": more["identity"]} if "identity" in more else {}
        self._book.write(wish, by, text, run=run_id, **point)
        return text

    async def new(self, new: NewRun) -> Run:
        """Put a campaign into the queue; proposed only, if the caller does not hold the controls.

        Raises
        ------
        BenchError
            If the campaign is wrong or would break a limit; nothing is queued then.
        """
        now_s = time.monotonic()
        by = new.name if new.secret is None else self._lease.check(new.secret, now_s).name
        if new.secret is not None:
            self._check_possible("start")
        run_id = new_id()
        source = await self._plans(self._catalog.source, new.campaign, new.text, run_id)
        root = self._settings.folder.absolute()
        planned = await self._plans(require_possible, source, self._bench, new.folder, run_id[:15], root)
        run = Run(
            id=run_id,
            campaign=source,
            title=planned.title,
            bench=self._settings.bench,
            folder=planned.folder,
            by=by,
            asked_at=now(),
            state="proposed" if new.secret is None else "queued",
            interface=self._settings.interface,
            real_time=new.real_time,
            seed=new.seed,
            twin=None if new.twin is None else str(self._model_path(new.twin)),
            twin_pause=new.twin_pause,
            resumes=new.secret is not None,
        )
        self._book.write("ask", by, f"{planned.title} {run.state}", run=run.id)
        return self._keeper.add(run) if new.secret is None else self._keeper.begin(run, by)

    def again(self, run_id: str, by: str) -> Run:
        """Let a run that ended go on where it stopped."""
        run = self.run(run_id, "ended")
        if run.by_hand is not None or run.tares:
            raise NotNow("a motion by hand or a taring does not go on; press its button again")
        self._book.write("again", by, f"{run.title} goes on in {Path(run.folder).name}", run=run.id)
        return self._keeper.begin(following(run, by, resumes=True), by)

    def run(self, run_id: str, state: str) -> Run:
        """Return a run in the state it has to be in.

        Raises
        ------
        Unknown
            If there is none of this id and state.
        """
        run = self._keeper.runs.get(run_id)
        if run is None or run.state != state:
            raise Unknown(f'there is no {state} run "{run_id}"')
        return run

    def approve(self, run_id: str, by: str) -> Run:
        """Let a run begin that somebody without the controls proposed."""
        run = self.run(run_id, "proposed")
        self._book.write("approve", by, f"{run.title}, asked for by {run.by}", run=run.id)
        return self._keeper.begin(replace(run, state="queued"), by)

    def change(self, run: Run, **changes: Any) -> Run:
        """Change a run that waits."""
        changed = self._keeper.runs.put(replace(run, **changes))
        self._keeper.changed()
        return changed
