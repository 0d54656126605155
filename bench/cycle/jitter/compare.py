"""Both loops, one after the other, at each rate, against the emulator on the other end of a wire."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bench.cycle.host import StealLog
from bench.cycle.jitter import c_loop, load, python_loop
from bench.cycle.jitter.figures import Notes, RateFigures, figures
from bench.cycle.round_trip import emulator


@dataclass(frozen=True, slots=True)
class Conditions:
    """What is measured, and how.

    Attributes
    ----------
    rates : Hz.
    seconds : of each loop at each rate.
    priority : SCHED_FIFO of the masters; the emulator has nine less; None: ordinary scheduling.
    cpu, emulator_cpu : processors they are pinned to; None: anywhere.
    make_up_s : how much later a cycle of the bus process may begin, and how long the emulator waits; 0: left out.
    loaded : HDF5 is written by the rig, and an identification runs on the emulator's processor.
    source : pysoem's source distribution; None: it is downloaded.
    """

    rates: Sequence[float] = (1000.0, 2000.0, 4000.0)
    seconds: float = 10.0
    priority: int | None = 80
    cpu: int | None = None
    emulator_cpu: int | None = None
    loaded: bool = False
    make_up_s: float = 0.0
    with_c: bool = True
    source: Path | None = None


@dataclass(frozen=True, slots=True)
class Comparison:
    """All figures; ``notes`` are sentences on what is missing."""

    rates: tuple[RateFigures, ...]
    notes: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """For a script."""
        return {"rates": [figures.as_dict() for figures in self.rates], "notes": list(self.notes)}


def compare(near: str, far: str, conditions: Conditions, report_progress: Callable[[str], None]) -> Comparison:
    """Measure on a pair of interfaces; ``report_progress`` is called before each step."""
    notes: list[str] = []
    with TemporaryDirectory(prefix="bench-cycle-") as name, ExitStack() as closing:
        folder = Path(name)
        program: Path | None = None
        if conditions.with_c:
            report_progress("building the C loop")
            built = c_loop.build(folder, conditions.source)
            if isinstance(built, c_loop.Unavailable):
                notes.append(f"no C loop: {built.reason}")
            else:
                program = built
        if conditions.loaded:
            report_progress("making a campaign for the load")
            other = {conditions.emulator_cpu} if conditions.emulator_cpu is not None else None
            closing.enter_context(load.identification(folder, other))
        rates = tuple(
            _at_rate(near, far, rate, conditions, program, folder, notes, report_progress) for rate in conditions.rates
        )
    return Comparison(rates, tuple(dict.fromkeys(notes)))


def _at_rate(
    near: str,
    far: str,
    rate: float,
    conditions: Conditions,
    program: Path | None,
    folder: Path,
    notes: list[str],
    report_progress: Callable[[str], None],
) -> RateFigures:
    seconds, priority, cpu = conditions.seconds, conditions.priority, conditions.cpu

    def python() -> Notes:
        file = folder / f"at-{rate:g}.h5" if conditions.loaded else None
        noted, missing = python_loop.run(near, rate, seconds, priority, cpu, file, conditions.make_up_s)
        notes.extend(missing)
        return noted

    loops: dict[str, Callable[[], Notes]] = {"the bus process": python}
    if program is not None:
        loops["the C loop"] = lambda: c_loop.run(program, near, rate, seconds, priority, cpu)
    found = []
    for name, loop in loops.items():
        report_progress(f"{name} at {rate:g} Hz")
        with emulator(far, 1.0 / rate, *_emulator_options(conditions)), StealLog() as log:
            noted = loop()
        found.append(figures(noted, log, round(1e9 / rate)))
    return RateFigures(rate, found[0], found[1] if len(found) > 1 else None)


def _emulator_options(conditions: Conditions) -> list[str]:
    options = []
    if conditions.priority is not None:
        options += ["--priority", str(max(1, conditions.priority - 9))]
    if conditions.make_up_s:
        options += ["--make-up-ms", str(1e3 * conditions.make_up_s)]
    if conditions.emulator_cpu is not None:
        options += ["--cpu", str(conditions.emulator_cpu)]
    return options


def default_processors() -> tuple[int | None, int | None]:
    """Return one processor for the master and another for the emulator, or nothing where there is only one."""
    allowed = sorted(os.sched_getaffinity(0))
    return (allowed[-1], allowed[-2]) if len(allowed) > 1 else (None, None)
