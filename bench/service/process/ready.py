"""A process that stands ready for the next run: ``python -m bench.service.process.ready LINK SPEC``.

Opening a bench took a run process most of its time before it touched the bus: loading the program, and the compiled
loops. One that stands ready has done both. While it waits it reads the bench without torque, where it may, and reports
its values. A line on its input, ``{"job": path, "log": path}``, makes it the process of that run; ``LINK`` then leads
to the job, so that whoever looks for the process of a job finds it by its command line. The end of its input ends it.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

Message = dict[str, Any]
_HOLD_S = 0.25
_TELL_S = 1.0


@dataclass(frozen=True, slots=True)
class Spec:
    """What a process that stands ready is given when it begins.

    ``reads`` says whether it may read the bench while it waits; a bench that is emulated in the process itself is
    nobody else's, any other bus is locked meanwhile.
    """

    socket: str
    bench: str
    interface: str | None = None
    plant: str | None = None
    reads: bool = True

    def as_dict(self) -> dict[str, Any]:
        """For its command line."""
        return asdict(self)


class Order:
    """What comes on the input: nothing yet, a job, or the end."""

    def __init__(self) -> None:
        self._came = threading.Event()
        self.line = ""
        threading.Thread(target=self._read, name="order", daemon=True).start()

    def wait(self, seconds: float) -> bool:
        """Whether something has come, after so long at most."""
        return self._came.wait(seconds)

    def _read(self) -> None:
        self.line = sys.stdin.readline()
        self._came.set()


def main() -> None:
    """Stand ready, then do the job; without one end in silence."""
    link, spec = Path(sys.argv[1]), Spec(**json.loads(sys.argv[2]))
    order = Order()
    _stand(spec, order)
    if not order.line:
        return
    job = json.loads(order.line)
    _write_to(Path(job["log"]))
    from bench.service.process.job import Job
    from bench.service.process.main import Process, leave

    try:
        end = Process(Job.load(Path(job["job"]))).run()
    finally:
        link.unlink(missing_ok=True)
    leave(end)


def _stand(spec: Spec, order: Order) -> None:
    """Load what a run needs, then read the bench until a job comes; what fails is reported, the job starts cold."""
    from bench.errors import BenchError, one_sentence
    from bench.service.process.lines import LineServer

    last_message: list[Message] = []
    server = LineServer(Path(spec.socket), lambda: last_message[-1:], lambda message: None)

    def send(message: Message) -> None:
        last_message[:] = [message]
        server.send(message)

    try:
        _watch(spec, order, send)
    except (BenchError, OSError) as error:
        send({"type": "unread", "text": one_sentence(error)})
    except Exception as error:  # noqa: BLE001 - other people's drivers: the job itself will say what is wrong with them
        send({"type": "unread", "text": f"{type(error).__name__}: {one_sentence(error)}"})
    while not order.wait(_TELL_S):
        pass
    server.close(0.2)


def _watch(spec: Spec, order: Order, send: Callable[[Message], None]) -> None:
    """Open the bench without torque and report how it is; one that may not be read is only got ready for.

    A job that has come already waits for nothing of this: it loads what it needs, and opens the bench itself.
    """
    from bench.campaigns import load_campaign, shipped_campaigns
    from bench.configuration import load_bench, on_interface, playing
    from bench.cycle.decode import warm_up
    from bench.cycle.rig import Rig
    from bench.locks import bus_in_use
    from bench.safety import settings
    from bench.service.process.condition import condition

    import_module("bench.service.process.main")
    for name in shipped_campaigns():
        if order.wait(0.0):
            return
        # with every sequence, and what draws points at random, which is the slowest to load
        load_campaign(name)
    file = load_bench(spec.bench)
    file = file if spec.interface is None else on_interface(file, spec.interface)
    file = file if spec.plant is None else playing(file, spec.plant)
    configuration = file.configuration
    if order.wait(0.0):
        return
    if not spec.reads:
        warm_up(
            settings(
                configuration.limits,
                configuration.gearbox.ratio,
                configuration.bus.cycle_time,
                configuration.motion.standstill,
            )
        )
        send({"type": "unread", "text": "between runs this bench is not read (bench serve --watch reads it)"})
        return
    with nullcontext() if configuration.bus.in_process else bus_in_use(file), Rig(file, real_time=True) as rig:
        while not order.wait(0.0):
            rig.link.hold(_HOLD_S)
            seen = condition(rig, "idle")
            if seen is not None:
                send(seen)


def _write_to(log: Path) -> None:
    """Let go of the launcher's pipe and write into the log of the run from now on."""
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    out = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    for descriptor in (1, 2):
        os.dup2(out, descriptor)
    os.close(nothing)
    os.close(out)


if __name__ == "__main__":
    main()
