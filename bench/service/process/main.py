"""The process of one run: ``python -m bench.service.process.main JOB.json``.

It is its own session and opens the bus alone. Whoever connects to its socket is told everything from the beginning; if
nobody does, or the web process dies, the run goes on. SIGTERM and SIGINT bring the bench to rest.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import traceback
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bench.errors import BenchError, DeviceError
from bench.service.process.lines import LineServer, Message


@dataclass(frozen=True, slots=True)
class Job:
    """What a run is: all a process needs to know, written as JSON."""

    run: str
    campaign: str
    """Path of a TOML or Python file, or the name of a shipped one."""
    bench: str
    folder: str
    socket: str
    outcome: str
    """File for the end of the run, so that it is known even if nobody listened."""
    interface: str | None = None
    real_time: bool = False
    reset_faults: bool = False
    seed: int = 0

    @classmethod
    def load(cls, path: Path) -> Job:
        """Read a job file."""
        return cls(**json.loads(path.read_text("utf-8")))

    def as_dict(self) -> dict[str, Any]:
        """For the job file."""
        return {name: getattr(self, name) for name in self.__slots__}


def run(job: Job) -> Message:
    """Run the campaign and return its end as a message."""
    from bench.campaigns import load_campaign
    from bench.campaigns.directions import Directions
    from bench.campaigns.session import run_campaign
    from bench.configuration import load_bench, on_interface
    from bench.cycle.rig import EndKind
    from bench.service.process.reporter import Reporter
    from bench.service.process.tap import LiveTap

    file = load_bench(job.bench)
    if job.interface is not None:
        file = on_interface(file, job.interface)
    directions = Directions()
    server: LineServer | None = None

    def emit(message: Message) -> None:
        if server is not None:
            server.send(message)

    reporter = Reporter(file.configuration, emit)

    def receive(message: Message) -> None:
        _obey(directions, reporter, message)

    server = LineServer(Path(job.socket), reporter.greeting, receive)
    tap = LiveTap(emit, file.configuration.gearbox.ratio)
    try:
        summary = run_campaign(
            file,
            load_campaign(job.campaign),
            Path(job.folder),
            reporter,
            seed=job.seed,
            real_time=job.real_time,
            reset_faults=job.reset_faults,
            directions=directions,
            tap=tap,
        )
        kind = "failed_points" if summary.end.kind is EndKind.FINISHED and summary.failed else summary.end.kind.name
        end = {
            "kind": kind.lower(),
            "cause": summary.end.cause.name,
            "text": summary.end.text,
            "recordings": len(summary.taken),
            "earlier": summary.earlier,
            "failed": [f"{taken.recording_id}: {taken.note}" for taken in summary.failed],
            "bench_time_s": summary.bench_time_s,
        }
    except BenchError as error:
        kind = "device" if isinstance(error, DeviceError) else "refused"
        end = {"kind": kind, "cause": type(error).__name__, "text": str(error)}
    except Exception as error:  # noqa: BLE001 - the last floor: what it was goes to the page and to the journal of the system
        traceback.print_exc()
        end = {"kind": "internal", "cause": type(error).__name__, "text": f"{type(error).__name__}: {error}"}
    tap.close()
    message = {"type": "end", **end}
    _write(Path(job.outcome), message)
    reporter.tell("ended", str(end["text"]), remaining_s=0.0, way=None)
    emit(message)
    server.close()
    return message


def _obey(directions: Any, reporter: Any, message: Message) -> None:
    wish, point = message.get("do"), str(message.get("identity", ""))
    if wish == "stop":
        directions.stop()
        reporter.tell("stopping", "the bench is brought to rest")
    elif wish in ("pause", "go_on"):
        getattr(directions, wish)()
    elif wish in ("skip", "repeat"):
        getattr(directions, wish)(point)
    elif wish == "note":
        directions.note(str(message.get("text", "")))


def _write(path: Path, message: Message) -> None:
    """Write the outcome whole or not at all."""
    part = path.with_suffix(".part")
    part.write_text(json.dumps(message), encoding="utf-8")
    os.replace(part, path)


def main() -> None:
    """Run the job of the file given."""
    if os.environ.get("BENCH_PARENT_IGNORES_SIGINT"):
        # Ctrl-C in the terminal of the service is for the service, which then stops the run in order
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    end = run(Job.load(Path(sys.argv[1])))
    sys.exit(0 if end["kind"] in ("finished", "failed_points") else 1)


if __name__ == "__main__":
    main()
