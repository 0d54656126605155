"""All checks of one machine for one bench."""

from __future__ import annotations

from pathlib import Path

from bench.configuration import BenchConfiguration
from bench.cycle.doctor import disk, interface, machine, packages, rights
from bench.cycle.doctor.finding import Finding


def examine(bench: BenchConfiguration, name: str | None, folder: Path) -> list[Finding]:
    """Look at everything a bench in real time needs.

    Parameters
    ----------
    bench : whose priority, disk space and interface are meant.
    name : network interface; None: that of the bench file, none where it is emulated in the process.
    folder : where recordings will go.
    """
    chosen = name or (bench.bus.interface if bench.bus.master != "emulated" else None)
    return [
        *packages.python(),
        *packages.packages(),
        *([] if chosen is None else interface.interface(chosen)),
        *rights.capabilities(),
        *rights.scheduling(bench.bus.priority),
        *rights.locked_memory(),
        *machine.processors(),
        *machine.kernel(),
        *machine.clock(),
        *machine.wake_up(bench.bus.priority),
        *disk.disk(folder, bench.storage.minimum_free),
    ]
