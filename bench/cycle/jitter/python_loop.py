"""Run the bus process with a rig behind it and note its cycles."""

from __future__ import annotations

import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.configuration import BenchConfiguration, load_bench, on_interface
from bench.cycle.ahead import AheadLink
from bench.cycle.assembly import assemble, device_errors
from bench.cycle.jitter.figures import Notes
from bench.cycle.link import Link
from bench.recording import Gearbox, RecordingHeader, RecordingWriter

_SETTLING_CYCLES = 2000
# Columns of the words a bus process notes beside each image; the same order as in Notes, the counter apart.
_TIMES, _WKC = slice(0, 5), 6


def run(
    interface: str,
    rate: float,
    seconds: float,
    priority: int | None,
    cpu: int | None,
    recording: Path | None = None,
    make_up_s: float = 0.0,
) -> tuple[Notes, tuple[str, ...]]:
    """Cycle with the drives off, images decoded by the rig as in a campaign; return notes, and what was not granted.

    ``make_up_s`` is the bench's ``bus.make_up``, s. ``recording`` has every row written into that HDF5 file meanwhile.
    """
    bench = _configuration(interface, rate, priority, cpu, make_up_s)
    assembly = assemble(bench, seed=0, real_time=True)
    link, bus = AheadLink(bench, assembly), assembly.process_bus
    assert bus is not None, "the link has refused a bus without a process"
    noted: list[NDArray[np.int64]] = []
    with device_errors():
        link.open()
        try:
            writer = None if recording is None else _writer(recording, link, bench)
            link.hold(_SETTLING_CYCLES / rate)
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                link.keep_ahead(at_rest=True)
                decoded = link.collect(assembly.block)
                noted.append(bus.meta)
                if writer is not None:
                    writer.append({**decoded.raw, "time": decoded.raw["cycle"]})
            if writer is not None:
                writer.close(complete=True)
        finally:
            link.close()
    meta = np.concatenate(noted)[: round(seconds * rate)]
    slot, due, woke, back, done = meta[:, _TIMES].T
    return Notes(slot, due, woke, back, done, meta[:, _WKC]), bus.notes


def _configuration(
    interface: str, rate: float, priority: int | None, cpu: int | None, make_up_s: float
) -> BenchConfiguration:
    bench = on_interface(load_bench("rh380n"), interface).configuration
    changes: dict[str, Any] = {"cycle_time": 1.0 / rate, "processor": cpu, "make_up": make_up_s}
    if priority is not None:
        changes["priority"] = priority
    return bench.model_copy(update={"bus": bench.bus.model_copy(update=changes)})


def _writer(path: Path, link: Link, bench: BenchConfiguration) -> RecordingWriter:
    header = RecordingHeader(
        path.stem,
        "benchmark",
        "free",
        datetime.now(UTC),
        1.0 / bench.bus.cycle_time,
        "emulator",
        gearbox=Gearbox(ratio=bench.gearbox.ratio),
    )
    return RecordingWriter(path, header, list(link.scaling.specs.values()))
