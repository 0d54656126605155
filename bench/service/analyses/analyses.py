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
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

from bench.service.analyses.since import Report
from bench.service.analyses.work import Kind, Work
from bench.service.campaigns.catalog import next_name
from bench.service.files.kept import Broken
from bench.service.refusals import Unknown
from bench.service.runs.runs import new_id, now

Message = dict[str, Any]
SURE = 0.7
"""Confidence below which a finding is worth an investigation, as ``bench investigate`` has it."""
_SAID = 200
WORKER = ("-m", "bench.service.analyses.work")
LONGEST_LINE = 1 << 22
"""Bytes of a line that an analysis says: a plan has a row a point."""


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
    what: str = "queued"
    share: float = 0.0
    model: str | None = None
    asked: Message = field(default_factory=dict)
    """Of an investigation."""
    asks: Message = field(default_factory=dict)
    """The experiment that an investigation waits for: its plan, its run."""


class Experimenter(Protocol):
    """Runs experiments that investigations ask for; see :class:`bench.service.analyses.experiments.Experiments`."""

    def put(self, analysis: Analysis, asks: Message) -> str:
        """Put one into the queue; the id of its run."""
        ...

    async def ended(self, analysis: Analysis, run_id: str) -> Message:
        """Wait for its end."""
        ...

    def stop(self, analysis: Analysis, by: str) -> None:
        """End it with the investigation."""
        ...


def open_findings(path: Path) -> int:
    """How many findings of a report are ambiguous, unknown, or named with less confidence than ``SURE``."""
    try:
        findings = json.loads(path.read_text("utf-8"))["findings"]
        return sum(one["status"] != "named" or (one.get("confidence") or 1.0) < SURE for one in findings)
    except (OSError, ValueError, KeyError, TypeError):
        # no report, or none of this version: nothing is known to be open
        return 0


def investigation_of(folder: Path) -> Message:
    """What an investigation has written so far: ``log`` (empty before its first look) and ``said``, the last lines."""
    try:
        log = json.loads((folder / "investigation.json").read_text("utf-8"))
    except (OSError, ValueError):
        # not written yet
        log = {}
    said = folder / "said.txt"
    lines = said.read_text("utf-8").splitlines() if said.exists() else []
    return {"log": log, "said": lines[-_SAID:]}


class Analyses:
    """All analyses that were ever started; each has a folder with its results.

    Parameters
    ----------
    state : folder of the results.
    publish : sends it to the pages.
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
                analysis = replace(analysis, state="failed", what="the service ended meanwhile; begin anew", asks={})
            self._all[analysis.id] = analysis
        # an investigation waits for hours of bench time: nobody else waits for it
        self._turns = {kind: asyncio.Semaphore(1) for kind in ("analysis", "investigate")}
        self.experiments: Experimenter | None = None
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._opens: dict[str, int] = {}

    def start(
        self, kind: Kind, recordings: Path, by: str, model: Path | None, asked: Message | None = None
    ) -> Analysis:
        """Put an analysis into the queue."""
        chosen = None if model is None else str(model)
        analysis = Analysis(new_id(), kind, recordings.name, now(), by, model=chosen, asked=asked or {})
        self._put(analysis)
        work = Work(kind, str(recordings.absolute()), str(self.folder(analysis.id)), chosen, analysis.asked)
        task = asyncio.get_running_loop().create_task(self._run(analysis.id, work))
        self._tasks[analysis.id] = task
        task.add_done_callback(lambda _: self._tasks.pop(analysis.id, None))
        return analysis

    def cancel(self, id_: str, by: str) -> bool:
        """End an analysis, and the experiment that it waits for; False if it does not run."""
        task = self._tasks.get(id_)
        if task is None:
            return False
        if self.experiments is not None:
            self.experiments.stop(self._all[id_], by)
        return task.cancel()

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

    def investigated(self, id_: str) -> Path:
        """Folder of an investigation. Raises Unknown where there is none of this id."""
        analysis = self._all.get(id_)
        if analysis is None or analysis.kind != "investigate":
            raise Unknown(f'there is no investigation "{id_}"')
        return self.folder(id_)

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
            "open": self._open(analysis),
            "next": [next_name(path) for path in sorted(folder.glob("next-*.toml"))],
        }

    def _open(self, analysis: Analysis) -> int:
        """How many findings of a finished report an investigation would ask about."""
        if analysis.kind != "mismatch" or analysis.state != "done" or analysis.model is not None:
            return 0
        if analysis.id not in self._opens:
            self._opens[analysis.id] = open_findings(self.folder(analysis.id) / "report.json")
        return self._opens[analysis.id]

    async def _experiment(self, id_: str, asks: Message) -> Message:
        """Have an experiment run, as soon as somebody lets it begin."""
        if self.experiments is None:
            return {"problem": "there is no bench here"}
        run = self.experiments.put(self._all[id_], asks)
        self._put(replace(self._all[id_], asks={**asks, "run": run}))
        answer = await self.experiments.ended(self._all[id_], run)
        self._put(replace(self._all[id_], asks={}, what=f"experiment {asks['number']} has ended"))
        return answer

    def _put(self, analysis: Analysis) -> None:
        self._all[analysis.id] = analysis
        folder = self.folder(analysis.id)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "analysis.json").write_text(json.dumps(asdict(analysis), ensure_ascii=False), encoding="utf-8")
        self._publish(self.message())

    async def _run(self, id_: str, work: Work) -> None:
        try:
            async with self._turns["investigate" if work.kind == "investigate" else "analysis"]:
                self._put(replace(self._all[id_], state="running", what="starting"))
                await self._process(id_, work)
        except asyncio.CancelledError:
            self._put(replace(self._all[id_], state="cancelled", what="cancelled by the operator", asks={}))
            raise

    async def _process(self, id_: str, work: Work) -> None:
        job = self.folder(id_) / "work.json"
        job.write_text(json.dumps(asdict(work)), encoding="utf-8")
        with (self.folder(id_) / "log.txt").open("wb") as log:
            process = await asyncio.create_subprocess_exec(
                sys.executable,
                *WORKER,
                str(job),
                stdout=asyncio.subprocess.PIPE,
                stderr=log,
                stdin=asyncio.subprocess.PIPE,
                limit=LONGEST_LINE,
                env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            )
        assert process.stdout is not None
        assert process.stdin is not None
        try:
            while line := await process.stdout.readline():
                message = json.loads(line)
                state = message.get("ended", "running")
                self._put(replace(self._all[id_], state=state, what=message["what"], share=message["share"]))
                if "asks" in message:
                    answer = await self._experiment(id_, message["asks"])
                    process.stdin.write(json.dumps(answer).encode() + b"\n")
                    await process.stdin.drain()
            code = await process.wait()
        except asyncio.CancelledError:
            process.kill()
            await process.wait()
            raise
        if self._all[id_].state == "running":
            log_path = self.folder(id_) / "log.txt"
            self._put(replace(self._all[id_], state="failed", what=f"ended with exit code {code}; see {log_path}"))
