"""Identification and mismatch reports started from the page: one at a time, each in a process of its own, at low
priority.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from bench.service.catalog import next_name
from bench.service.kept import Broken
from bench.service.refusals import Unknown
from bench.service.runs import new_id, now
from bench.service.since import Report
from bench.service.work import Kind, Work

Message = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Analysis:
    """One analysis; ``share`` is its progress, 0 … 1."""

    id: str
    kind: Kind
    folder: str
    asked_at: str
    by: str
    state: str = "waiting"
    """``waiting``, ``running``, ``done``, ``failed`` or ``cancelled``."""
    what: str = "waits for its turn"
    share: float = 0.0
    model: str | None = None


class Analyses:
    """All analyses since ever; their results lie in a folder each.

    Parameters
    ----------
    state : folder of the results.
    publish : tells the pages.
    """

    def __init__(self, state: Path, publish: Callable[[Message], None], broken: Broken) -> None:
        self._state, self._publish = state.absolute() / "analyses", publish
        self._state.mkdir(parents=True, exist_ok=True)
        self._all: dict[str, Analysis] = {}
        for path in sorted(self._state.glob("*/analysis.json")):
            analysis = broken.load(path, lambda entry: Analysis(**entry))
            if analysis is None:
                continue
            if analysis.state in ("waiting", "running"):
                analysis = replace(analysis, state="failed", what="the service ended meanwhile; start it again")
            self._all[analysis.id] = analysis
        self._one = asyncio.Semaphore(1)
        self._tasks: dict[str, asyncio.Task[None]] = {}

    def start(self, kind: Kind, recordings: Path, by: str, model: Path | None) -> Analysis:
        """Put an analysis into the queue."""
        chosen = None if model is None else str(model)
        analysis = Analysis(new_id(), kind, recordings.name, now(), by, model=chosen)
        self._put(analysis)
        work = Work(kind, str(recordings.absolute()), str(self.folder(analysis.id)), chosen)
        task = asyncio.get_running_loop().create_task(self._run(analysis.id, work))
        self._tasks[analysis.id] = task
        task.add_done_callback(lambda _: self._tasks.pop(analysis.id, None))
        return analysis

    def cancel(self, id_: str) -> bool:
        """End an analysis; False if it does not run."""
        task = self._tasks.get(id_)
        return task is not None and task.cancel()

    def get(self, id_: str) -> Analysis | None:
        """Return an analysis by its id."""
        return self._all.get(id_)

    def folder(self, id_: str) -> Path:
        """Folder of the results."""
        return self._state / id_

    def reports(self, id_: str, root: Path) -> tuple[Report, list[Report]]:
        """Return a mismatch report and all of them; ``root`` is the folder of recordings.

        Raises
        ------
        Unknown
            If there is none of this id.
        """
        made = {
            one.id: Report(self.folder(one.id), root / one.folder, one.asked_at)
            for one in self._all.values()
            if one.kind == "mismatch" and one.state == "done"
        }
        if id_ not in made:
            raise Unknown(f'there is no mismatch report "{id_}"')
        return made[id_], list(made.values())

    def message(self) -> Message:
        """All analyses, newest first."""
        return {"type": "analyses", "analyses": [self._as_dict(analysis) for analysis in reversed(self._all.values())]}

    async def close(self) -> None:
        """End what runs."""
        for task in list(self._tasks.values()):
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task

    def _as_dict(self, analysis: Analysis) -> Message:
        folder = self.folder(analysis.id)
        return {
            **asdict(analysis),
            "has_report": (folder / "report.html").exists(),
            "has_model": (folder / "model.json").exists(),
            "next": [next_name(path) for path in sorted(folder.glob("next-*.toml"))],
        }

    def _put(self, analysis: Analysis) -> None:
        self._all[analysis.id] = analysis
        folder = self.folder(analysis.id)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "analysis.json").write_text(json.dumps(asdict(analysis), ensure_ascii=False), encoding="utf-8")
        self._publish(self.message())

    async def _run(self, id_: str, work: Work) -> None:
        try:
            async with self._one:
                self._put(replace(self._all[id_], state="running", what="starting"))
                await self._process(id_, work)
        except asyncio.CancelledError:
            self._put(replace(self._all[id_], state="cancelled", what="cancelled by the operator"))
            raise

    async def _process(self, id_: str, work: Work) -> None:
        job = self.folder(id_) / "work.json"
        job.write_text(json.dumps(asdict(work)), encoding="utf-8")
        with (self.folder(id_) / "log.txt").open("wb") as log:
            process = await asyncio.create_subprocess_exec(
                sys.executable,
                "-m",
                "bench.service.work",
                str(job),
                stdout=asyncio.subprocess.PIPE,
                stderr=log,
                env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            )
        assert process.stdout is not None
        try:
            while line := await process.stdout.readline():
                told = json.loads(line)
                state = told.get("ended", "running")
                self._put(replace(self._all[id_], state=state, what=told["what"], share=told["share"]))
            code = await process.wait()
        except asyncio.CancelledError:
            process.kill()
            await process.wait()
            raise
        if self._all[id_].state == "running":
            log_path = self.folder(id_) / "log.txt"
            self._put(replace(self._all[id_], state="failed", what=f"ended with exit code {code}; see {log_path}"))
