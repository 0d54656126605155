"""The keeper of the bench: takes runs from the queue one by one, follows each, stops it when asked to."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bench.errors import ConfigurationError
from bench.proof.seal import seal
from bench.service.alarms.alarms import Alarms
from bench.service.files.book import Book, local_time_of
from bench.service.files.disk import Disk
from bench.service.files.kept import is_there
from bench.service.runs.jobs import outcome, write_job
from bench.service.runs.launcher import Launcher
from bench.service.runs.process_link import ProcessLink
from bench.service.runs.run_process import RunProcesses
from bench.service.runs.runs import Run, Runs, now
from bench.service.runs.shown import Shown
from bench.service.runs.stopper import Press, Stopper, Target
from bench.service.runs.stream import Stream
from bench.stop_button.rest import rest_text

Message = dict[str, Any]
_LOG = logging.getLogger(__name__)
_SILENT_S = {"opening": 180.0, "resetting": 180.0}
"""A run that says nothing for so long is an alarm; opening a bench and resetting its drives take their time."""
_SILENT_ELSE_S = 10.0
_POLL_S = 0.2
_SHOWN = 30
_HISTORY = "history.jsonl"
"""Live values of a run, in its folder: pages show the hours before a service that was started anew."""
_AGAIN_S = 1.0
"""After an error of its own the keeper takes so long a breath."""
_GOOD_ENDS = frozenset({"finished", "failed_points"})


class Keeper:
    """Owns the one run there can be.

    Parameters
    ----------
    state : folder of the service's own files.
    stop_deadline_s : how long a stop may take before the process is killed.
    stop_port : port of the runs' own stop listener, 0 for any.
    plant : plays an emulated bench in place of the plant its file names.
    sealed : hash of what that plant conceals; it stands beside the recordings of each run.
    """

    def __init__(
        self,
        state: Path,
        runs: Runs,
        launcher: Launcher,
        stream: Stream,
        book: Book,
        alarms: Alarms,
        disk: Disk,
        stop_deadline_s: float,
        stop_port: int,
        plant: str | None = None,
        sealed: str | None = None,
    ) -> None:
        self._state, self._launcher, self._stream, self._book = state, launcher, stream, book
        self._alarms, self._disk, self.runs, self._stop_port = alarms, disk, runs, stop_port
        self._plant, self._sealed = plant, sealed
        self._processes = RunProcesses(state, launcher)
        self.stopper = Stopper(stop_deadline_s, self._report_killed_run)
        self.shown = Shown(stream, book)
        self.on_end: Callable[[Run], None] = lambda run: None
        """Is called with a run that has ended; must not wait for anything."""
        self.heard = time.monotonic()
        self._held = runs.rebuilt or is_there(state / "held")
        self._past_hold: set[str] = set()
        """ids of runs that were started one by one while the queue was held"""
        self._link: ProcessLink | None = None
        self._starting: Run | None = None
        self._wake = asyncio.Event()
        self._task: asyncio.Task[None] | None = None
        self._failure: tuple[float, str] | None = None

    # -- life ----------------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Begin to work; a run that an earlier service left behind is followed further."""
        measured = [run for run in self.runs.all() if run.started_at and run.measures]
        if measured:
            self.shown.history.take_up(self._processes.folder(measured[-1]) / _HISTORY, self._disk)
        self._task = asyncio.get_running_loop().create_task(self._work())

    async def close(self) -> None:
        """Stop working; a run goes on."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
        await self.stopper.close()

    def is_alive(self) -> bool:
        """Whether what is shown of the run is to be trusted: the keeper works, and the run has spoken lately."""
        return self.trouble is None and self.silent is None

    @property
    def trouble(self) -> str | None:
        """Why nobody follows the runs, None if all is well."""
        if self._task is not None and self._task.done():
            return "the part of the service that follows runs has ended"
        if self._failure is not None and time.monotonic() - self._failure[0] < 3.0 * _AGAIN_S:
            return f"the part of the service that follows runs fails: {self._failure[1]}"
        return None

    @property
    def heard_s(self) -> float | None:
        """For how long the run has said nothing, s; None where nothing runs."""
        return None if self.runs.running() is None else time.monotonic() - self.heard

    @property
    def silent(self) -> str | None:
        """For how long the run has said nothing, where that is too long."""
        run = self.runs.running()
        limit = _SILENT_S.get(self.shown.status["phase"], _SILENT_ELSE_S)
        if run is None or time.monotonic() - self.heard < limit:
            return None
        return f"the run {run.title} has sent nothing for {limit:.0f} s"

    @property
    def is_busy(self) -> bool:
        """Whether a run has the bench, or is being started on it."""
        return self._starting is not None or self.runs.running() is not None

    @property
    def held(self) -> bool:
        """After a stop or an alarm no run that waits begins until the operator says so; a new service knows it too."""
        return self._held

    @held.setter
    def held(self, value: bool) -> None:
        self._held = value
        self._past_hold.clear()
        if value:
            self._disk.replace(self._state / "held", "")
        else:
            self._disk.remove(self._state / "held")

    # -- wishes --------------------------------------------------------------------------------------------------------

    def add(self, run: Run) -> Run:
        """Put a run into the queue."""
        self.runs.put(run)
        self.changed()
        return run

    def begin(self, run: Run, by: str) -> Run:
        """Put a run into the queue that ``by`` starts now. Behind a hold it begins alone: what waits there stays held.

        A hold behind which nothing waits ends with it, and the book says so; one under a run that still goes on stays.
        """
        if self.held and self.runs.running() is None:
            if any(other.state == "queued" and other.id != run.id for other in self.runs.all()):
                self._past_hold.add(run.id)
                self._book.write("queue", by, f"{run.title} begins alone; the queue stays held", run=run.id)
            else:
                self.held = False
                self._book.write("queue", by, "the queue was held with nothing waiting; it is held no longer")
        return self.add(run)

    def changed(self) -> None:
        """Look again whether something can begin, and inform the pages."""
        self._wake.set()
        self._stream.publish(self.runs_message())
        self.shown.on_phase()

    def go_on_with_queue(self) -> None:
        """Let the queue go on after a stop."""
        self.held = False
        self.changed()

    def stop(self, by: str, pressed_at_ns: int | None = None) -> tuple[Press, bool]:
        """Bring the bench to rest, by every way there is; return the press that counts, and whether it is this one.

        Its ``run`` is None if nothing runs. No file is touched before the run has received it.
        """
        run = self.runs.running() or self._starting
        press, first = self.stopper.pressed(by, pressed_at_ns, None if run is None else run.id)
        if run is not None and run.pid is not None:
            self.stopper.stop(
                Target(run.id, run.pid, self._processes.socket(run)), self._link, lambda: self._processes.live(run)
            )
        self.held = True
        return press, first

    def send_to_run(self, wish: str, **more: Any) -> bool:
        """Send an order to a run, by default the one that is running; False if it cannot be reached."""
        run = self.runs.running()
        return self._link is not None and self._link.send(wish, **{"run": None if run is None else run.id, **more})

    # -- what pages are told -------------------------------------------------------------------------------------------

    def runs_message(self) -> Message:
        """All runs that are not ended and the last that are, oldest first."""
        runs = self.runs.all()
        shown = [
            run.as_dict() for left, run in enumerate(runs, _SHOWN - len(runs)) if left >= 0 or run.state != "ended"
        ]
        return {"type": "runs", "runs": shown, "held": self.held}

    # -- work ----------------------------------------------------------------------------------------------------------

    async def _work(self) -> None:
        """Work for ever; an error of one step is said, and the next is done all the same."""
        while True:
            try:
                await self._step()
            except Exception as error:  # noqa: BLE001 - whatever it is: the next run has to be followed, and it is an alarm
                _LOG.exception("a step of the keeper")
                self._failure = (time.monotonic(), f"{type(error).__name__}: {error}")
                await asyncio.sleep(_AGAIN_S)

    async def _step(self) -> None:
        run = self.runs.running()
        if run is None and not self._alarms.to_acknowledge():
            run = next((run for run in self.runs.all() if run.state == "queued" and self._may_begin(run)), None)
            if run is not None:
                run = await self._start(run)
        if run is not None:
            await self._follow(run)
            return
        self._wake.clear()
        await self._wake.wait()

    def _may_begin(self, run: Run) -> bool:
        """Whether nothing holds a run; a stop since it was started does."""
        return not self.held or run.id in self._past_hold

    def _seal(self, run: Run) -> None:
        """Write the hash of what is concealed beside the recordings; refuse a folder of another plant."""
        if not (run.resets or run.tares):
            seal(Path(run.folder), self._sealed)

    async def _start(self, run: Run) -> Run | None:
        folder = self._processes.folder(run)
        self._starting = run
        try:
            await asyncio.to_thread(self._seal, run)
            path = await asyncio.to_thread(
                write_job, run, folder, self._processes.socket(run), self._stop_port, self._plant
            )
            if not self._may_begin(run):
                self._end(run, {"kind": "interrupted", "cause": "OPERATOR", "text": "stopped before it began"})
                return None
            pid = await self._launcher.start(path, folder / "log.txt")
        except ConfigurationError as error:
            self._end(run, {"kind": "refused", "cause": "ConfigurationError", "text": str(error)})
            return None
        except OSError as error:
            self._end(run, {"kind": "internal", "cause": "LAUNCHER", "text": f"{run.title} was not started: {error}"})
            return None
        finally:
            self._starting = None
        if self._may_begin(run):
            self.stopper.forget()
        # what was measured until a stop stays in sight while the bench is reset
        keeps = run.resets or run.tares
        self.shown.begin(clear=not keeps)
        if not keeps:
            self.shown.history.keep_in(folder / _HISTORY, self._disk)
        run = self.runs.change(run.id, state="running", pid=pid, started_at=now())
        self._book.write("run", run.by, f"{run.title} begins", run=run.id, folder=run.folder)
        self.changed()
        if not self._may_begin(run):
            # STOP was pressed while the process was being started
            self.stop("somebody")
        return run

    async def _follow(self, run: Run) -> None:
        self.heard = time.monotonic()
        self._link = ProcessLink(self._processes.socket(run))
        end: Message | None = None
        try:
            async for message in self._link.messages(lambda: self._processes.live(run)):
                self.heard = time.monotonic()
                if message["type"] == "end":
                    end = message
                else:
                    self.shown.take(message)
            while self._processes.live(run):
                await asyncio.sleep(_POLL_S)
            if end is None:
                # the launcher hears of the exit a moment later than the process is gone
                await asyncio.sleep(_POLL_S)
        finally:
            self._link = None
        if end is None:
            code = self._processes.exit_code(run)
            end = await asyncio.to_thread(outcome, self._processes.folder(run), code)
        self.on_end(run)
        self._end(run, end)

    def _report_killed_run(self) -> None:
        run = self.runs.running()
        title = "the run" if run is None else run.title
        self._alarms.raise_("KILLED", f"{title} had not ended {self.stopper.deadline_s:.0f} s after STOP; killed")

    def _end(self, run: Run, end: Message) -> None:
        end = {"text": "", **{key: value for key, value in end.items() if key != "type"}}
        at = self.shown.point_that_ran()
        self._past_hold.discard(run.id)
        self.runs.change(run.id, state="ended", ended_at=now(), end=end, pid=None)
        self._book.write("run", run.by, f"{run.title} ended: {end['text'] or end['kind']}", run=run.id)
        self._say_rest(run, end)
        if end["kind"] not in _GOOD_ENDS:
            self.held = True
            if end["kind"] != "interrupted":
                self._alarms.raise_(str(end.get("cause", end["kind"])), str(end["text"]), at)
        self.shown.end(end["text"])
        self.changed()

    def _say_rest(self, run: Run, end: Message) -> None:
        """Write into the book what was seen of the shafts after STOP, if the run was stopped by it."""
        press = self.stopper.press
        if (press is None or press.run != run.id) and end.get("pressed_by") and end.get("pressed_at_ns"):
            # past this service, by the run's own listener or by a signal
            press, _ = self.stopper.pressed(str(end["pressed_by"]), int(end["pressed_at_ns"]), run.id)
        if press is None or press.run != run.id or press.over:
            return
        self.stopper.seen(run.id, bool(end.get("at_rest")), end.get("rest_seen_at_ns"), end.get("bench_to_rest_s"))
        seen = self.stopper.press or press
        when = local_time_of(seen.pressed_at_ns)
        rest = rest_text(seen.at_rest, seen.at_rest_after_s, seen.bench_to_rest_s)
        text = f"STOP pressed at {when}: {rest}"
        self._book.write("stop", seen.by, text, run=run.id, at_rest_after_s=seen.at_rest_after_s)
