"""How long the operator waits for an emulated bench: until a run begins, until a reset is done; asked of a service."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from bench.errors import BenchError
from bench.matrix.processes import own_places, post, running_service, state, until

WAITS_S = 180.0
FIRST = "the first run is requested as soon as the service answers; it begins"
RUN = "a run is requested, a process stands ready; it begins"
RESET = "a reset is requested, a process stands ready; it is done and the bench free"
RESET_AT_ONCE = "a reset is requested as soon as a run has ended; it is done and the bench free"
WAITED_FOR = (FIRST, RUN, RESET, RESET_AT_ONCE)
"""What is waited for, in words for a table."""


@dataclass(frozen=True, slots=True)
class Wait:
    """One kind of wait: the times of each round, and the processor time of the service and all its processes, s."""

    name: str
    wall_s: list[float] = field(default_factory=list)
    cpu_s: list[float] = field(default_factory=list)

    @property
    def median_s(self) -> float:
        """Median of the times."""
        return float(np.median(self.wall_s))

    @property
    def median_cpu_s(self) -> float:
        """Median of the processor times."""
        return float(np.median(self.cpu_s))


@dataclass(frozen=True, slots=True)
class OpeningTimes:
    """All waits, with the load average while they were measured."""

    waits: tuple[Wait, ...]
    load: float
    processors: int

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def measure_opening(
    rounds: int, folder: Path, report_progress: Callable[[str], None] = lambda _: None, real_time: bool = True
) -> OpeningTimes:
    """Serve an emulated bench ``rounds`` times; in each begin two runs, end each, reset after each. The bench keeps the
    clock's pace (``real_time``) or goes as fast as the computer does.

    Raises
    ------
    TimeoutError
        If something does not happen within :data:`WAITS_S`.
    BenchError
        If a run ends before it is seen to begin: a computer too busy for the bus cycle, say.
    """
    waits = {name: Wait(name) for name in WAITED_FOR}
    for number in range(rounds):
        report_progress(f"round {number + 1} of {rounds}")
        place = folder / str(number)
        with own_places(place), running_service(place / "recordings") as (process, address):
            _round(address, process.pid, waits, real_time)
    return OpeningTimes(tuple(waits.values()), os.getloadavg()[0], os.cpu_count() or 1)


def _round(address: str, service: int, waits: dict[str, Wait], real_time: bool) -> None:
    """Two runs, each ended and reset: the first of each cold, the second with a process that stands ready."""
    who = {"secret": post(address, "controls/take", name="benchmark")["secret"]}

    def measure_wait(wait: Wait, ask: Callable[[], Any], true: Callable[[], bool]) -> Any:
        before, begun = _processor_s(service), time.monotonic()
        answer = ask()
        until(true, WAITS_S, f"not within {WAITS_S:.0f} s: {wait.name}")
        wait.wall_s.append(time.monotonic() - begun)
        wait.cpu_s.append(_processor_s(service) - before)
        return answer

    def start() -> str:
        body = {**who, "name": "benchmark", "campaign": "quick", "real_time": real_time}
        return str(post(address, "runs", **body)["id"])

    for run_wait, reset_wait in ((FIRST, RESET_AT_ONCE), (RUN, RESET)):
        run = measure_wait(waits[run_wait], start, lambda: _phase(address) not in ("free", "opening") or _free(address))
        if _free(address):
            ends = [entry.get("end") for entry in state(address, "runs")["runs"] if entry["id"] == run]
            raise BenchError(f"the run ended before it was seen to begin: {ends}")
        post(address, "run/abort", **who, run=run)
        until(lambda: _free(address), WAITS_S, "the run does not end")
        if reset_wait == RESET:
            _until_ready(address)
        measure_wait(waits[reset_wait], partial(post, address, "reset", **who, run=run), lambda: _free(address))
        _until_ready(address)


def _until_ready(address: str) -> None:
    """Wait until a process stands ready: it reads the bench, and says so."""
    since = time.time()

    def reads() -> bool:
        seen = state(address, "condition")
        return seen.get("source") == "idle" and float(seen["at"]) > since

    until(reads, WAITS_S, "no process stands ready")


def _phase(address: str) -> str:
    return str(state(address, "status").get("phase", "opening"))


def _free(address: str) -> bool:
    """Whether every run that was asked for has ended and the bench is free."""
    return _phase(address) == "free" and all(run["state"] == "ended" for run in state(address, "runs")["runs"])


def _processor_s(root: int) -> float:
    """Processor time so far of a process and of all it has started, s."""
    children: dict[int, list[int]] = {}
    spent: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text("utf-8").rpartition(")")[2].split()
            except OSError:
                # it has ended meanwhile; its parent has its time
                continue
            children.setdefault(int(fields[1]), []).append(int(entry.name))
            spent[int(entry.name)] = sum(map(int, fields[11:15]))
    total, todo = 0, [root]
    while todo:
        one = todo.pop()
        total += spent.get(one, 0)
        todo += children.get(one, ())
    return total / os.sysconf("SC_CLK_TCK")
