"""The keeper of the bench: takes runs from the queue one by one, follows each, stops it when told."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bench.service.alarms import Alarms
from bench.service.book import Book
from bench.service.history import History
from bench.service.jobs import outcome, write_job
from bench.service.launcher import Launcher
from bench.service.process_link import ProcessLink
from bench.service.registry import runtime_folder
from bench.service.runs import Run, Runs, now
from bench.service.stream import Stream

Message = dict[str, Any]
FREE: Message = {"type": "status", "phase": "free", "label": ""}
_SILENT_S = 10.0
"""A run that says nothing for so long, other than while it opens the bench, is an alarm."""
_OPENING_S = 180.0
_POLL_S = 0.2
_SHOWN = 30
_GOOD_ENDS = frozenset({"finished", "failed_points"})


class Keeper:
    """Owns the one run there can be.

    Parameters
    ----------
    state : folder of the service's own files.
    stop_deadline_s : how long a stop may take before the process is killed and the drives' watchdogs act.
    """

    def __init__(
        self,
        state: Path,
        runs: Runs,
        launcher: Launcher,
        stream: Stream,
        book: Book,
        alarms: Alarms,
        stop_deadline_s: float,
    ) -> None:
        self._state, self._launcher, self._stream, self._book = state, launcher, stream, book
        self._alarms, self._stop_deadline_s, self.runs = alarms, stop_deadline_s, runs
        self.history = History()
        self.plan: Message | None = None
        self.points: dict[str, Message] = {}
        self.status: Message = FREE
        self.spectrum: Message | None = None
        self.heard = time.monotonic()
        self.on_spectrum: Callable[[Message], None] = stream.publish
        """Where spectra go; the service draws its model over them first."""
        self.on_phase: Callable[[], None] = lambda: None
        """Is called when the phase has changed: other things may be done now."""
        self._link: ProcessLink | None = None
        self._wake = asyncio.Event()
        self._task: asyncio.Task[None] | None = None
        self._killer: asyncio.Task[None] | None = None

    # -- life ----------------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Begin to work; a run that an earlier service left behind is followed further."""
        self._task = asyncio.get_running_loop().create_task(self._work())

    async def close(self) -> None:
        """Stop working; a run goes on."""
        for task in (self._task, self._killer):
            if task is not None:
                task.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await task

    def is_alive(self) -> bool:
        """Whether the run that has the bench is to be trusted: it has spoken lately. True without a run."""
        if self.runs.running() is None:
            return True
        limit = _OPENING_S if self.status["phase"] == "opening" else _SILENT_S
        return time.monotonic() - self.heard < limit

    @property
    def held(self) -> bool:
        """After a stop or an alarm nothing begins by itself until the operator says so; a new service knows it too."""
        return (self._state / "held").exists()

    @held.setter
    def held(self, value: bool) -> None:
        if value:
            (self._state / "held").touch()
        else:
            (self._state / "held").unlink(missing_ok=True)

    # -- wishes --------------------------------------------------------------------------------------------------------

    def add(self, run: Run) -> Run:
        """Put a run into the queue."""
        self.runs.put(run)
        self.changed()
        return run

    def changed(self) -> None:
        """Look again whether something can begin, and tell the pages."""
        self._wake.set()
        self._stream.publish(self.runs_message())
        self.on_phase()

    def go_on_with_queue(self) -> None:
        """Let the queue go on after a stop."""
        self.held = False
        self.changed()

    def stop(self) -> bool:
        """Bring the bench to rest, by every way there is; False if nothing runs."""
        run = self.runs.running()
        self.held = True
        if run is None:
            return False
        if self._link is not None:
            self._link.send("stop")
        if run.pid is not None and self._runs(run):
            with contextlib.suppress(ProcessLookupError):
                # the socket may be stuck; the signal is not
                os.kill(run.pid, signal.SIGTERM)
            if self._killer is None or self._killer.done():
                self._killer = asyncio.get_running_loop().create_task(self._kill_late(run))
        return True

    def tell_run(self, wish: str, **more: str) -> bool:
        """Pass a wish on to the run; False if there is none to hear it."""
        return self._link is not None and self._link.send(wish, **more)

    # -- what pages are told -------------------------------------------------------------------------------------------

    def runs_message(self) -> Message:
        """All runs that are not ended and the last that are, oldest first."""
        runs = self.runs.all()
        shown = [
            run.as_dict() for left, run in enumerate(runs, _SHOWN - len(runs)) if left >= 0 or run.state != "ended"
        ]
        return {"type": "runs", "runs": shown, "held": self.held}

    def plan_message(self) -> Message | None:
        """The plan of the run with its points as they stand."""
        return None if self.plan is None else {**self.plan, "points": list(self.points.values())}

    # -- work ----------------------------------------------------------------------------------------------------------

    async def _work(self) -> None:
        while True:
            run = self.runs.running()
            if run is None:
                run = None if self.held else self.runs.next()
                if run is not None:
                    run = await self._start(run)
            if run is not None:
                await self._follow(run)
                continue
            self._wake.clear()
            await self._wake.wait()

    async def _start(self, run: Run) -> Run | None:
        folder = self._folder(run)
        path = write_job(run, folder, self._socket(run))
        try:
            pid = await self._launcher.start(path, folder / "log.txt")
        except OSError as error:
            self._end(run, {"kind": "internal", "cause": "LAUNCHER", "text": str(error)})
            return None
        opening = {"type": "status", "phase": "opening", "label": "the bench is being opened"}
        if run.resets:
            # what was measured until the stop stays in sight
            self.status = opening
            self._stream.publish(opening)
        else:
            self._clear(opening)
        run = self.runs.change(run.id, state="running", pid=pid, started_at=now())
        self._book.write("run", run.by, f"{run.title} begins", run=run.id, folder=run.folder)
        self.changed()
        if self.held:
            # STOP was pressed while the process was being started
            self.stop()
        return run

    async def _follow(self, run: Run) -> None:
        self.heard = time.monotonic()
        self._link = ProcessLink(self._socket(run))
        watch = asyncio.get_running_loop().create_task(self._watch(run))
        end: Message | None = None
        try:
            async for message in self._link.messages(lambda: self._runs(run)):
                self.heard = time.monotonic()
                if message["type"] == "end":
                    end = message
                else:
                    self._take(message)
            while self._runs(run):
                await asyncio.sleep(_POLL_S)
            if end is None:
                # the launcher hears of the exit a moment later than the process is gone
                await asyncio.sleep(_POLL_S)
        finally:
            watch.cancel()
            self._link = None
        code = None if run.pid is None else self._launcher.exit_code(run.pid)
        self._end(run, end or outcome(self._folder(run), code))

    def _take(self, message: Message) -> None:
        kind = message["type"]
        if kind == "plan":
            self.plan = {key: value for key, value in message.items() if key != "points"}
            self.points = {point["identity"]: point for point in message["points"]}
        elif kind == "point":
            self.points[message["identity"]] = {key: value for key, value in message.items() if key != "type"}
        elif kind == "status":
            before, self.status = self.status, message
            if any(before.get(key) != message.get(key) for key in ("phase", "pausing")):
                self.on_phase()
        elif kind == "live":
            self.history.add(message)
        elif kind == "notice":
            self._book.write("notice", "bench", message["text"])
        elif kind == "spectrum":
            self.spectrum = message
            self.on_spectrum(message)
            return
        self._stream.publish(message)

    async def _watch(self, run: Run) -> None:
        while True:
            await asyncio.sleep(1.0)
            if not self.is_alive():
                self._alarms.raise_("SILENT", f"the run {run.title} has not been heard of for {_SILENT_S:.0f} s")

    async def _kill_late(self, run: Run) -> None:
        await asyncio.sleep(self._stop_deadline_s)
        if self._runs(run) and run.pid is not None:
            self._alarms.raise_(
                "KILLED", f"{run.title} did not come to rest in {self._stop_deadline_s:.0f} s; ended hard"
            )
            with contextlib.suppress(ProcessLookupError):
                os.kill(run.pid, signal.SIGKILL)

    def _end(self, run: Run, end: Message) -> None:
        end = {key: value for key, value in end.items() if key != "type"}
        self.runs.change(run.id, state="ended", ended_at=now(), end=end, pid=None)
        self._book.write("run", run.by, f"{run.title} ended: {end.get('text') or end['kind']}", run=run.id)
        if end["kind"] not in _GOOD_ENDS:
            self.held = True
            if end["kind"] != "interrupted":
                self._alarms.raise_(str(end.get("cause", end["kind"])), str(end["text"]))
        self.status = {**FREE, "label": end.get("text", "")}
        self._stream.publish(self.status)
        self.changed()

    def _clear(self, status: Message) -> None:
        self.plan, self.points, self.spectrum = None, {}, None
        self.history.clear()
        self.status = status
        self._stream.publish({"type": "clear"})
        self._stream.publish(status)

    def _runs(self, run: Run) -> bool:
        """Whether the process of a run still lives (and is the very one: process ids are used again)."""
        if run.pid is None or self._launcher.exit_code(run.pid) is not None:
            return False
        if self._launcher.has_started(run.pid):
            # its end will be heard of; right after its start the command line may still be empty
            return True
        try:
            command = Path(f"/proc/{run.pid}/cmdline").read_bytes()
        except OSError:
            return False
        return str(self._folder(run) / "job.json").encode() in command

    def _folder(self, run: Run) -> Path:
        return self._state.absolute() / "runs" / run.id

    def _socket(self, run: Run) -> Path:
        # Unix socket paths hold 107 bytes, and folders of recordings may have long names
        return runtime_folder() / f"{run.id}.sock"
