"""The process of one run: ``python -m bench.service.process.main JOB.json``.

It is its own session and opens the bus alone. Whoever connects to its socket receives everything from the beginning; if
nobody does, or the web process dies, the run goes on. SIGTERM, SIGINT, SIGHUP and SIGQUIT bring the bench to rest.
"""

from __future__ import annotations

import gc
import json
import os
import sys
import traceback
from datetime import datetime
from pathlib import Path
from typing import NoReturn

from bench.campaigns import load_campaign
from bench.campaigns.execution.session import run_campaign
from bench.campaigns.operator.directions import Directions
from bench.campaigns.operator.jog import jog
from bench.campaigns.operator.reset import reset
from bench.campaigns.taken import Summary
from bench.configuration import BenchFile, load_bench, on_interface, playing
from bench.cycle.end import EndKind
from bench.errors import BenchError, DeviceError
from bench.locks import bus_in_use
from bench.service.process.hold import Hold
from bench.service.process.job import Job
from bench.service.process.lines import LineServer, Message
from bench.service.process.obey import Obedience
from bench.service.process.reporter import Reporter
from bench.service.process.tap import LiveTap
from bench.service.process.tare import tare
from bench.stop_button import StopButton, listening

_OF_THE_PRESS = ("pressed_by", "pressed_at_ns", "at_rest_after_s", "rest_seen_at_ns", "bench_to_rest_s")


class Process:
    """One job, its socket, and what it sends."""

    def __init__(self, job: Job) -> None:
        self._job = job
        file = load_bench(job.bench)
        self._file: BenchFile = file if job.interface is None else on_interface(file, job.interface)
        if job.plant is not None:
            self._file = playing(self._file, job.plant)
        self._directions = Directions()
        self._reporter = Reporter(self._file.configuration, self._emit)
        self._button = StopButton(job.run)
        self._hold = Hold()
        hold = None if job.by_hand is None else self._hold
        self._obey = Obedience(job.run, self._directions, self._reporter, hold)
        self._server = LineServer(Path(job.socket), self._reporter.greeting, self._take)

    def run(self) -> Message:
        """Do the job and return its end as a message; the file of the outcome is written before it is sent to anybody.

        A disk that takes no file keeps nobody from hearing of the end.
        """
        with listening(self._button, self._job.stop_port):
            end = {"type": "end", **self._end()}
        if self._button.is_pressed:
            pressed = self._button.state()
            end |= {key: pressed[key] for key in _OF_THE_PRESS} | {"at_rest": pressed["state"] == "at_rest"}
        path = Path(self._job.outcome)
        part = path.with_suffix(".part")
        try:
            part.write_text(json.dumps(end), encoding="utf-8")
            os.replace(part, path)
        except OSError as error:
            self._reporter.noticed(f"the end of this run is not on the disk: {error}")
        self._reporter.report_status("ended", str(end["text"]), remaining_s=0.0, way=None)
        self._emit(end)
        self._server.close()
        return end

    def _take(self, message: Message) -> None:
        """Take what the service says; a stop needs nobody else's word."""
        if message.get("do") == "stop":
            at_ns = message.get("pressed_at_ns")
            self._button.press(str(message.get("by") or "the service"), at_ns if isinstance(at_ns, int) else None)
        self._obey(message)

    def _emit(self, message: Message) -> None:
        self._server.send(message)

    def _end(self) -> Message:
        try:
            with bus_in_use(self._file):
                if self._job.by_hand is not None:
                    return self._by_hand(self._job.by_hand)
                if self._job.tares:
                    return self._tare()
                return self._reset() if self._job.reset_by is not None else self._campaign()
        except BenchError as error:
            kind = "device" if isinstance(error, DeviceError) else "refused"
            cause = str(getattr(error, "cause", type(error).__name__))
            refused_reset = self._job.reset_by is not None and kind == "refused"
            return {"kind": kind, "cause": "RESET" if refused_reset else cause, "text": str(error)}
        except Exception as error:  # noqa: BLE001 - the last floor: what it was goes to the page and to the log
            traceback.print_exc()
            return {"kind": "internal", "cause": type(error).__name__, "text": f"{type(error).__name__}: {error}"}

    def _reset(self) -> Message:
        job = self._job
        self._reporter.report_status("resetting", "the drives lose their faults, no torque is given")
        reset(self._file, Path(job.folder), str(job.reset_by), seed=job.seed)
        return {"kind": "finished", "cause": "NONE", "text": ""}

    def _tare(self) -> Message:
        folder = Path(self._job.folder)
        folder.mkdir(parents=True, exist_ok=True)
        self._reporter.report_status("taring", "the torque sensor is read at rest; the drives have no voltage")

        def stopped() -> bool:
            return self._button.is_pressed or self._directions.stop_requested

        return tare(self._file, folder, stopped, seed=self._job.seed)

    def _by_hand(self, velocity: float) -> Message:
        """Turn the bench while the button is held; to let go of it is the end that was meant."""
        folder = Path(self._job.folder)
        folder.mkdir(parents=True, exist_ok=True)
        report_status = self._reporter.report_status
        report_status("opening", "brings bus and drives up; keep holding")
        tap = LiveTap(self._emit, self._file.configuration.gearbox.ratio)
        try:
            end = jog(
                self._file,
                folder,
                velocity,
                lambda: self._hold.is_held() and not self._directions.stop_requested,
                self._button,
                noticed=self._reporter.noticed,
                tap=tap,
                moving=lambda: report_status("by_hand", "it stops as soon as the button is let go"),
                seed=self._job.seed,
            )
        finally:
            tap.close()
        let_go = end.kind is EndKind.INTERRUPTED and not self._button.is_pressed
        kind = "finished" if let_go else end.kind.name.lower()
        return {"kind": kind, "cause": end.cause.name, "text": "let go" if let_go else end.text}

    def _campaign(self) -> Message:
        job = self._job
        report_status = self._reporter.report_status
        report_status("opening", "1 of 3: reads the campaign")
        campaign = load_campaign(job.campaign)
        report_status("opening", "2 of 3: brings bus and drives up")
        tap = LiveTap(
            self._emit,
            self._file.configuration.gearbox.ratio,
            self._reporter.motion,
            lambda: report_status("opening", "3 of 3: plans every point against the limits"),
        )
        try:
            return _as_end(
                run_campaign(
                    self._file,
                    campaign,
                    Path(job.folder),
                    self._reporter,
                    seed=job.seed,
                    real_time=job.real_time,
                    resumed_by=job.resumed_by,
                    directions=self._directions,
                    tap=tap,
                    button=self._button,
                    not_before=None if job.not_before is None else datetime.fromisoformat(job.not_before),
                )
            )
        finally:
            tap.close()


def _as_end(summary: Summary) -> Message:
    finished = summary.end.kind is EndKind.FINISHED
    return {
        "kind": "failed_points" if finished and summary.failed else summary.end.kind.name.lower(),
        "cause": summary.end.cause.name,
        "text": summary.end.text,
        "recordings": len(summary.taken),
        "earlier": summary.earlier,
        "failed": [f"{taken.recording_id}: {taken.note}" for taken in summary.failed],
        "bench_time_s": summary.bench_time_s,
    }


def leave(end: Message) -> NoReturn:
    """End the process of a run with the exit code of its end."""
    # before it ends, Python looks through all objects for circles; until the process is gone nobody else gets the bench
    gc.freeze()
    sys.exit(0 if end["kind"] in ("finished", "failed_points") else 1)


def main() -> None:
    """Do the job of the file given."""
    leave(Process(Job.load(Path(sys.argv[1]))).run())


if __name__ == "__main__":
    main()
