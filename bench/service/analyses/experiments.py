"""Experiments of investigations become runs: proposed, until whoever holds the controls lets them begin.

The first one always waits for that yes. Later ones do not where it was asked for and the bench is emulated, or
``unattended.may`` of its file names ``experiment``.
"""

from __future__ import annotations

import asyncio
from typing import Any

from bench.configuration import BenchConfiguration
from bench.errors import ConfigurationError
from bench.service.analyses.analyses import Analysis
from bench.service.files.book import Book
from bench.service.models import NewAnalysis, NewInvestigation
from bench.service.runs.keeper import Keeper
from bench.service.runs.runs import Run, new_id, now
from bench.service.settings import Settings

Message = dict[str, Any]
_POLL_S = 0.25
_WAITS = ("proposed", "queued")
_WITHOUT_MODEL = {
    "investigate": "an investigation compares with the nominal simulation",
    "compare": "a comparison before and since identifies both parts anew",
}
_GOOD_ENDS = ("finished", "failed_points")


def may_go_alone(bench: BenchConfiguration) -> bool:
    """Whether experiments may begin without a yes each."""
    return bench.bus.in_process or "experiment" in bench.unattended.may


def asked_of(new: NewAnalysis, settings: Settings, plant: str | None) -> Message:
    """What an analysis is given beside its folder and its model.

    Raises
    ------
    ConfigurationError
        What was asked for does not go together.
    """
    if new.kind != "investigate" and new.investigation is not None:
        raise ConfigurationError(f"investigation goes with the kind investigate, not with {new.kind}")
    if new.kind != "compare" and new.since is not None:
        raise ConfigurationError(f"since goes with the kind compare, not with {new.kind}")
    if new.kind in ("investigate", "compare") and new.model is not None:
        raise ConfigurationError(f"{_WITHOUT_MODEL[new.kind]}; leave model out")
    if new.kind == "compare":
        return {"since": new.since or ""}
    if new.kind != "investigate":
        return {}
    asked = (new.investigation or NewInvestigation()).model_dump()
    return {**asked, "bench": settings.bench, "interface": settings.interface, "plant": plant}


class Experiments:
    """Puts what investigations ask for into the queue, and says how it ended."""

    def __init__(self, bench: BenchConfiguration, settings: Settings, keeper: Keeper, book: Book) -> None:
        self._bench, self._settings, self._keeper, self._book = bench, settings, keeper, book
        self._runs: dict[str, str] = {}
        """run of each investigation that waits for one"""

    def put(self, analysis: Analysis, asks: Message) -> str:
        """Put an experiment into the queue, or propose it; the id of its run."""
        asked = analysis.asked
        alone = int(asks["number"]) > 1 and bool(asked.get("alone")) and may_go_alone(self._bench)
        run = Run(
            id=new_id(),
            campaign=asks["campaign"],
            title=f"experiment {asks['number']} on {analysis.folder}",
            bench=self._settings.bench,
            folder=asks["folder"],
            by=analysis.by,
            asked_at=now(),
            state="queued" if alone else "proposed",
            interface=self._settings.interface,
            real_time=bool(asked.get("real_time")),
            # another noise in each experiment
            seed=int(asks["number"]),
            not_before=asks["after"],
        )
        self._book.write("ask", analysis.by, f"{run.title} {run.state}", run=run.id)
        self._runs[analysis.id] = run.id
        self._keeper.add(run)
        return run.id

    async def ended(self, analysis: Analysis, run_id: str) -> Message:
        """Wait for the end of a run: ``bench_time_s`` of one that came to its end, else ``problem``."""
        try:
            while (run := self._keeper.runs.get(run_id)) is not None and run.state != "ended":
                await asyncio.sleep(_POLL_S)
        finally:
            self._runs.pop(analysis.id, None)
        if run is None:
            return {"problem": "its run is not known any more"}
        if run.end.get("kind") in _GOOD_ENDS and run.end.get("bench_time_s") is not None:
            return {"bench_time_s": run.end["bench_time_s"]}
        return {"problem": f"it was not run to its end: {run.end.get('text') or run.end.get('kind')}"}

    def stop(self, analysis: Analysis, by: str) -> None:
        """The investigation is ended: what waits is taken out of the queue, what runs is brought to rest."""
        run = self._keeper.runs.get(self._runs.get(analysis.id, ""))
        if run is None:
            return
        if run.state in _WAITS:
            end = {"kind": "withdrawn", "text": f"the investigation was ended by {by}"}
            self._keeper.runs.change(run.id, state="ended", end=end)
            self._keeper.changed()
        elif run.state == "running":
            self._keeper.stop(by)
        self._book.write("abort", by, f"{run.title}: the investigation was ended", run=run.id)
