"""The service: everything it is made of, put together; the routes only translate between it and HTTP."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Awaitable, Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench.campaigns import load_campaign, make_plan
from bench.campaigns.journal import require_same
from bench.configuration import BenchFile, load_bench, on_interface
from bench.service import recordings
from bench.service.after_stop import AfterStop
from bench.service.alarms import Alarm, Alarms
from bench.service.allowed import DONE, Situation, allowed, why_not
from bench.service.analyses import Analyses
from bench.service.book import Book
from bench.service.catalog import Catalog
from bench.service.keeper import Keeper
from bench.service.launcher import Launcher
from bench.service.lease import Lease
from bench.service.models import NewAnalysis, NewRun
from bench.service.notify import Notifier
from bench.service.once import Once
from bench.service.overlay import Overlay
from bench.service.refusals import NotNow, Unknown
from bench.service.runs import Run, Runs, following, new_id, now
from bench.service.settings import Settings
from bench.service.storage import storage
from bench.service.stream import Stream

Message = dict[str, Any]
_STOP_MARGIN_S = 10.0
_DISK_EVERY_S = 60.0
_ENDED = "the service ended"


class Service:
    """One bench, its runs, its operators, its pages."""

    def __init__(self, settings: Settings, launcher: Launcher) -> None:
        self.settings = settings
        file = load_bench(settings.bench)
        self.bench: BenchFile = file if settings.interface is None else on_interface(file, settings.interface)
        settings.state.mkdir(parents=True, exist_ok=True)
        self.book = Book(settings.state / "log.jsonl")
        self.lease = Lease(self.book)
        self.stream = Stream()
        self.once = Once()
        self.notifier = Notifier(settings.notify)
        self.alarms = Alarms(self.book, self._tell_alarm, settings.state / "alarms.json")
        self.overlay = Overlay(self.stream.publish)
        self.analyses = Analyses(settings.state, self.stream.publish)
        stopping = self.bench.configuration.stopping
        deadline = stopping.controlled_ramp + stopping.quick_stop + stopping.disable_voltage + _STOP_MARGIN_S
        runs = Runs(settings.state / "runs.json")
        self.keeper = Keeper(settings.state, runs, launcher, self.stream, self.book, self.alarms, deadline)
        self.after_stop = AfterStop(self.bench, settings, self.keeper, self.book)
        self.keeper.on_spectrum = self.overlay.take
        self.keeper.on_phase = self.tell_state
        if settings.model is not None:
            self.overlay.choose(settings.model)
        self._launcher = launcher
        self.catalog = Catalog(settings, self.bench.configuration)

    # -- life ----------------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Begin to work."""
        before = self.book.last_of("service")
        if before is not None and before["text"] != _ENDED:
            running = self.keeper.runs.running()
            what = "" if running is None else f"; {running.title} went on without it"
            self.book.write("service", "service", f"it ended without a word since {before['at'][:19]} UTC{what}")
        self.book.write("service", "service", f"the service begins, process {os.getpid()}")
        stopped = self.after_stop.latch()
        if stopped["due"] == "acknowledge" and not self.alarms.standing():
            # stopped by a run this service knows nothing of; the alarm is what it is acknowledged with
            self.alarms.raise_(stopped["cause"], stopped["text"])
        self.keeper.open()
        self._disk = asyncio.get_running_loop().create_task(self._watch_disk())

    async def close(self) -> None:
        """End; a run goes on in its own process."""
        self.stream.close()
        self._disk.cancel()
        await self.keeper.close()
        await self.analyses.close()
        await asyncio.to_thread(self._launcher.close)
        self.book.write("service", "service", _ENDED)

    # -- what is shown -------------------------------------------------------------------------------------------------

    def situation(self) -> Situation:
        """What decides what may be done now."""
        runs = self.keeper.runs.all()
        phase = "free" if self.keeper.runs.running() is None else self.keeper.status["phase"]
        return Situation(
            phase,
            pausing=bool(self.keeper.status.get("pausing")),
            held=self.keeper.held,
            waiting=any(run.state == "queued" for run in runs),
            proposed=any(run.state == "proposed" for run in runs),
            ended=any(run.state == "ended" for run in runs),
            due=self.after_stop.latch()["due"],
            alarms=bool(self.alarms.standing()),
        )

    def state(self) -> Message:
        """What stands beside the runs: who holds the controls, what may be done, alarms."""
        return {
            "type": "state",
            "holder": self.lease.as_dict(time.monotonic()),
            "allowed": sorted(allowed(self.situation())),
            "alarms": self.alarms.standing(),
            "pages": self.stream.pages,
            "alive": self.keeper.is_alive(),
            "latch": self.after_stop.latch(),
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
        }
        maybe = (self.keeper.plan_message(), self.overlay.last if self.keeper.spectrum is not None else None)
        return [
            about,
            self.state(),
            self.keeper.runs_message(),
            *(message for message in maybe if message is not None),
            self.keeper.status,
            self.analyses.message(),
        ]

    def tell_state(self) -> None:
        """Tell the pages that something beside the runs has changed."""
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
        self.tell_state()
        return result

    def check_possible(self, what: str) -> None:
        """Refuse what is not possible now."""
        situation = self.situation()
        if what not in allowed(situation):
            raise NotNow(why_not(what, situation))

    def stop(self, by: str) -> bool:
        """Bring the bench to rest, whoever asks; False if nothing ran."""
        ran = self.keeper.stop()
        self.book.write("stop", by, f"{by} pressed STOP" + ("" if ran else ", nothing ran"))
        self.keeper.changed()
        self.tell_state()
        return ran

    def wish(self, by: str, wish: str, **more: str) -> str:
        """Pass an operator's wish on to the run, with an entry in the book."""
        if not self.keeper.tell_run(wish, **more):
            raise NotNow("the run cannot be reached at the moment; STOP works all the same")
        text = DONE[wish].format(*more.values())
        self.book.write(wish, by, text, **({"point": more["identity"]} if "identity" in more else {}))
        return text

    async def new_run(self, new: NewRun) -> Run:
        """Put a campaign into the queue; proposed only, if the caller does not hold the controls.

        Raises
        ------
        BenchError
            If the campaign is wrong or would break a limit; nothing is queued then.
        """
        now_s = time.monotonic()
        by = new.name if new.secret is None else self.lease.check(new.secret, now_s).name
        if new.secret is not None:
            self.check_possible("start")
        run_id = new_id()
        source = await asyncio.to_thread(self.catalog.source, new.campaign, new.text, run_id)
        campaign = await asyncio.to_thread(load_campaign, source)
        # refused here and now if it would break a limit; the run plans again from the temperature it finds
        await asyncio.to_thread(make_plan, campaign, self.bench.configuration)
        folder = self.settings.folder.absolute() / (new.folder or f"{campaign.name}-{run_id[:15]}")
        await asyncio.to_thread(require_same, folder, campaign, self.bench)
        run = Run(
            id=run_id,
            campaign=source,
            title=campaign.title,
            bench=self.settings.bench,
            folder=str(folder),
            by=by,
            asked_at=now(),
            state="proposed" if new.secret is None else "queued",
            interface=self.settings.interface,
            real_time=new.real_time,
            seed=new.seed,
            resumes=new.secret is not None,
        )
        if new.secret is not None and self.keeper.runs.running() is None:
            # whoever holds the controls and starts a run lets the queue go on
            self.keeper.held = False
        self.book.write("ask", by, f"{campaign.title} {run.state}", run=run.id)
        return self.keeper.add(run)

    def again(self, run_id: str, by: str) -> Run:
        """Let a run that ended go on where it stopped."""
        run = self.run(run_id, "ended")
        self.keeper.held = False
        self.book.write("again", by, f"{run.title} goes on in {Path(run.folder).name}", run=run.id)
        return self.keeper.add(following(run, by, resumes=True))

    def run(self, run_id: str, state: str) -> Run:
        """Return a run in the state it has to be in.

        Raises
        ------
        Unknown
            If there is none of this id and state.
        """
        run = self.keeper.runs.get(run_id)
        if run is None or run.state != state:
            raise Unknown(f'there is no {state} run "{run_id}"')
        return run

    def change_run(self, run: Run, **changes: Any) -> Run:
        """Change a run that waits."""
        changed = self.keeper.runs.put(replace(run, **changes))
        self.keeper.changed()
        return changed

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
        return self.analyses.start(new.kind, folder, new.name, model)

    async def _watch_disk(self) -> None:
        """Say that room becomes scarce before a run has to stop for it."""
        while True:
            said = await asyncio.to_thread(self.storage)
            if not said["enough"]:
                # without the figure: the same alarm is raised once
                self.alarms.raise_("DISK", f"the disk of {said['folder']} is nearly full")
            await asyncio.sleep(_DISK_EVERY_S)

    def _tell_alarm(self, alarm: Alarm) -> None:
        self.notifier.tell(alarm, self.bench.configuration.name)
        self.tell_state()
