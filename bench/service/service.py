"""The service: everything it is made of, put together; the routes only translate between it and HTTP."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from bench.campaigns.operator.gentle import greatest_speed
from bench.configuration import BenchFile, concealing, load_bench, on_interface
from bench.proof.seal import opened
from bench.service.alarms.alarms import Alarm, Alarms
from bench.service.alarms.notify import Notifier
from bench.service.analyses.analyses import Analyses
from bench.service.analyses.experiments import Experiments, asked_of, may_go_alone
from bench.service.analyses.overlay import Overlay
from bench.service.analyses.twin import Twins
from bench.service.campaigns.catalog import Catalog
from bench.service.data import recordings
from bench.service.data.archive import Archive
from bench.service.data.downloads import Exports
from bench.service.files.book import Book, local_time_of
from bench.service.files.disk import Disk
from bench.service.files.kept import Broken
from bench.service.files.once import Once
from bench.service.files.seen import last_seen
from bench.service.files.storage import storage
from bench.service.models import NewAnalysis
from bench.service.readers import Readers
from bench.service.refusals import NotNow, Unknown
from bench.service.runs.after_stop import AfterStop
from bench.service.runs.allowed import BEGINS, Situation, allowed_acts, why_not
from bench.service.runs.by_hand import ByHand
from bench.service.runs.idle import Idle
from bench.service.runs.keeper import Keeper
from bench.service.runs.launcher import Launcher
from bench.service.runs.lease import Lease
from bench.service.runs.requests import Requests
from bench.service.runs.runs import Runs
from bench.service.runs.stopper import Press
from bench.service.runs.stream import Stream
from bench.service.runs.watches import DISK_EVERY_S, LOOK_EVERY_S, SelfWatch, look_at_disk, watch
from bench.service.settings import Settings

Message = dict[str, Any]
_STOP_MARGIN_S = 10.0
_SETTLE_S = 1.0
_LAST_WRITES_S = 3.0
_TELL_AFTER_S = 0.02
"""Pages hear of a STOP this much later than its answer is on its way."""
_ENDED = "the service ended"


class Service:
    """One bench, its runs, its operators, its pages."""

    def __init__(self, settings: Settings, launcher: Launcher) -> None:
        self.settings = settings
        file = load_bench(settings.bench)
        self.bench: BenchFile = file if settings.interface is None else on_interface(file, settings.interface)
        hidden = None if settings.conceal is None else concealing(file, settings.conceal)
        self._plant = plant = None if hidden is None else hidden.configuration.bus.plant
        sealed = None if settings.conceal is None else opened(file, settings.conceal)[1]
        settings.state.mkdir(parents=True, exist_ok=True)
        self.disk = Disk()
        self._broken = Broken()
        self.book = Book(settings.state / "log.jsonl", self.disk)
        self.seen = settings.state / "seen"
        self.lease = Lease(self.book)
        self.stream = Stream()
        self.once = Once(self._settle, settings.state / "requests.json", self.disk, self._broken)
        self.notifier = Notifier(settings.notify)
        alarms = settings.state / "alarms.json"
        self.alarms = Alarms(self.book, self._notify_alarm, self.publish_state, alarms, self.disk, self._broken)
        self.overlay = Overlay(self.stream.publish)
        self.analyses = Analyses(settings.state, self.stream.publish, self._broken)
        stopping = self.bench.configuration.stopping
        deadline = stopping.controlled_ramp + stopping.quick_stop + stopping.disable_voltage + _STOP_MARGIN_S
        port = settings.stop_port
        runs = Runs(settings.state / "runs.json", self.disk, self._broken)
        self.keeper = Keeper(
            settings.state,
            runs,
            launcher,
            self.stream,
            self.book,
            self.alarms,
            self.disk,
            deadline,
            port,
            plant,
            sealed,
        )
        self._myself = SelfWatch(self.alarms, self.disk, self.keeper, self.seen, self.publish_state)
        self.idle = Idle(settings, self.bench, plant, launcher, lambda: self.keeper.is_busy, self.keeper.shown.take)
        self.by_hand = ByHand(self.bench, settings, self.keeper, self.book)
        self.experiments = Experiments(self.bench.configuration, settings, self.keeper, self.book)
        self.analyses.experiments = self.experiments
        self.twins = Twins(settings.state, self.keeper, self.alarms, self.book, self.overlay)
        self.after_stop = AfterStop(self.bench, settings, self.keeper, self.book)
        self.keeper.shown.on_spectrum = self.overlay.take
        self.keeper.shown.on_phase = self.publish_state
        if settings.model is not None:
            self.overlay.choose(settings.model)
        self._launcher = launcher
        self.catalog = Catalog(settings, self.bench)
        self.plans = Readers("plans", at_once=2, most_waiting=6)
        self.requests = Requests(
            self.bench,
            settings,
            self.keeper,
            self.book,
            self.lease,
            self.catalog,
            self.plans,
            self.check_possible,
            self.model_path,
        )
        self.archive = Archive(settings, self.book)
        self.keeper.on_end = self.archive.run_ended
        self.searching = Readers("searches", at_once=2, most_waiting=20)
        self.exports = Exports()
        self.reading = Readers("recordings", at_once=2, most_waiting=30)

    # -- life ----------------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Begin to work."""
        before = self.book.last_of("service")
        if before is not None and before["text"] != _ENDED:
            running = self.keeper.runs.running()
            what = "" if running is None else f"; {running.title} went on without it"
            self.book.write("service", "service", f"it ended without a word, {last_seen(self.seen)}{what}")
        self.book.write("service", "service", f"the service begins, process {os.getpid()}")
        for sentence in self._broken.sentences:
            self.alarms.raise_("STATE_FILE", sentence)
        stopped = self.after_stop.latch()
        if stopped["due"] == "acknowledge" and not self.alarms.current():
            # stopped by a run this service knows nothing of; the alarm is what it is acknowledged with
            self.alarms.raise_(stopped["cause"], stopped["text"])
        self.keeper.open()
        self.idle.open()
        loop = asyncio.get_running_loop()
        self._watching = [
            loop.create_task(watch(lambda: look_at_disk(self.alarms, self.storage), DISK_EVERY_S)),
            loop.create_task(watch(self._myself.look, LOOK_EVERY_S)),
            loop.create_task(watch(self.twins.look, LOOK_EVERY_S)),
        ]

    async def close(self) -> None:
        """End; a run goes on in its own process."""
        self.stream.close()
        for task in self._watching:
            task.cancel()
        await asyncio.to_thread(self.twins.close)
        await self.idle.close()
        await self.keeper.close()
        await self.analyses.close()
        await asyncio.to_thread(self._launcher.close)
        self.book.write("service", "service", _ENDED)
        await asyncio.to_thread(self.disk.close, _LAST_WRITES_S)

    # -- what is shown -------------------------------------------------------------------------------------------------

    def situation(self) -> Situation:
        """What decides what may be done now."""
        runs = self.keeper.runs.all()
        phase = "free" if self.keeper.runs.running() is None else self.keeper.shown.status["phase"]
        return Situation(
            phase,
            pausing=bool(self.keeper.shown.status.get("pausing")),
            held=self.keeper.held,
            waiting=any(run.state == "queued" for run in runs),
            proposed=any(run.state == "proposed" for run in runs),
            ended=any(run.state == "ended" for run in runs),
            due=self.after_stop.latch()["due"],
            alarms=self.alarms.to_acknowledge(),
        )

    def state(self) -> Message:
        """What stands beside the runs: who holds the controls, what may be done, alarms."""
        return {
            "type": "state",
            "holder": self.lease.as_dict(time.monotonic()),
            "allowed": sorted(allowed_acts(self.situation())),
            "alarms": self.alarms.current(),
            "pages": self.stream.pages,
            "alive": self.keeper.is_alive(),
            "latch": self.after_stop.latch(),
            "stop": None if self.keeper.stopper.press is None else self.keeper.stopper.press.as_dict(),
            "stop_port": self._myself.stop_port,
            "model": None if self.overlay.path is None else str(self.overlay.path),
        }

    def greeting(self) -> list[Message]:
        """What a page starts with."""
        configuration = self.bench.configuration
        about = {
            "type": "about",
            "bench": configuration.name,
            "title": configuration.title,
            "ratio": configuration.gearbox.ratio,
            "emulated": configuration.bus.in_process,
            "limits": {
                "motor_speed": configuration.limits.motor_speed,
                "load_torque": configuration.limits.load_torque,
                "temperature": configuration.limits.temperature,
            },
            "may_go_alone": may_go_alone(configuration),
            "jog_speed": greatest_speed(configuration),
        }
        shown = self.keeper.shown
        spectrum = self.overlay.last if shown.spectrum is not None else None
        maybe = (shown.plan_message(), spectrum, shown.condition)
        return [
            about,
            self.state(),
            self.keeper.runs_message(),
            *(message for message in maybe if message is not None),
            self.keeper.shown.status,
            self.analyses.message(),
        ]

    def publish_state(self) -> None:
        """Send the state to all pages, where something other than the runs has changed."""
        self.stream.publish(self.state())

    def storage(self) -> Message:
        """Where recordings lie and what room is left."""
        return storage(self.settings.folder, self.bench.configuration.storage.minimum_free)

    # -- acts ----------------------------------------------------------------------------------------------------------

    async def act(self, secret: str | None, what: str, do: Callable[[str], Awaitable[Any]]) -> Any:
        """Do something in the name of whoever holds the controls.

        Raises
        ------
        NotHeld
            If the caller does not hold them.
        NotNow
            If it is not possible now.
        """
        holder = self.lease.check(secret, time.monotonic())
        self.check_possible(what)
        result = await do(holder.name)
        self.publish_state()
        return result

    def check_possible(self, what: str) -> None:
        """Refuse what is not possible now."""
        situation = self.situation()
        if what not in allowed_acts(situation):
            raise NotNow(why_not(what, situation))
        if what in BEGINS and self.disk.trouble is not None:
            raise NotNow(f"nothing begins now: {self.disk.trouble}; make room or mend it first")

    def stop(self, by: str, pressed_at_ns: int | None = None) -> Press:
        """Bring the bench to rest, whoever asks; return the press that counts. Its ``run`` is None if nothing ran.

        The run is informed first. Nothing here waits for a file, and informing the pages comes after the answer.
        """
        press, first = self.keeper.stop(by, pressed_at_ns)
        at = local_time_of(press.pressed_at_ns)
        if press.run is None:
            self.book.write("stop", by, f"{by} pressed STOP, nothing ran")
        elif first:
            self.book.write("stop", by, f"{by} pressed STOP at {at}", run=press.run)
        else:
            self.book.write("stop", by, f"{by} pressed STOP too, after {press.by} at {at}", run=press.run)
        asyncio.get_running_loop().call_later(_TELL_AFTER_S, self.keeper.changed)
        return press

    def model_path(self, analysis_id: str) -> Path:
        """Return the model an analysis made.

        Raises
        ------
        Unknown
            If it made none.
        """
        path = self.analyses.folder(analysis_id) / "model.json"
        if self.analyses.get(analysis_id) is None or not path.exists():
            raise Unknown(f'there is no analysis "{analysis_id}" with a model')
        return path

    def analyse(self, new: NewAnalysis) -> Any:
        """Start an analysis of a folder of recordings."""
        folder = recordings.inside(self.settings.folder, new.folder)
        model = None if new.model is None else self.model_path(new.model)
        self.book.write("analyse", new.name, f"{new.kind} of {new.folder}")
        return self.analyses.start(new.kind, folder, new.name, model, asked_of(new, self.settings, self._plant))

    async def _settle(self) -> None:
        """Wait a moment for the disk, so that what is answered is kept; trouble with it is an alarm of its own."""
        await asyncio.to_thread(self.disk.settled, _SETTLE_S)

    def _notify_alarm(self, alarm: Alarm) -> None:
        self.notifier.send(alarm, self.bench.configuration.name)
        self.publish_state()
