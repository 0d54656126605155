"""The process that is killed: a rig on real frames that records a motion. ``python -m bench.matrix.worker JSON``.

Says in lines of JSON on its standard output where it is: ``earlier``, ``moving`` (with the bus process), ``end``.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from bench.campaigns.records.recorder import Recorder
from bench.configuration import BenchFile, load_bench, on_interface
from bench.cycle.end import EndKind
from bench.cycle.rig import Rig
from bench.matrix.plant import header, motion
from bench.protocols import Phase, Segment
from bench.safety import LatchFile

CYCLE_S = 0.001
"""Of the bus on a machine that does other things as well."""


_BUS = {"cycle_time": CYCLE_S, "ahead": 0.3, "hold": 0.2, "watchdog": 0.3}
_LIMITS: dict[str, float | None] = {
    "lost_cycles": 400,
    "lost_share": 1.0,
    "velocity_error": 60.0,
    "following_error": None,
    "motor_acceleration": None,
    "load_torque_rate": None,
    "torque_error": None,
}
LOOSENED = ", ".join(
    f"{name} {'off' if value is None else f'{value:g}'}" for name, value in {**_BUS, **_LIMITS}.items()
)
"""What these rows have otherwise than the bench file, for people; SI."""


def patient_bench(file: BenchFile) -> BenchFile:
    """Return the bench with a slower bus that forgives a host taking processor time away: kills are what is tried."""
    config = file.configuration
    bus = config.bus.model_copy(update=_BUS)
    limits = config.limits.model_copy(update=_LIMITS)
    return BenchFile(config.model_copy(update={"bus": bus, "limits": limits}), file.text, file.origin)


def main() -> None:
    """Run until the motion ends, or somebody ends it."""
    options = json.loads(sys.argv[1])
    file, folder = (
        patient_bench(on_interface(load_bench(options["bench"]), options["interface"])),
        Path(options["folder"]),
    )
    with Rig(file, latch=LatchFile(folder / "latch.json")) as rig:
        rig.enable()
        _record(rig, file, folder, "earlier", (Phase(Segment.DWELL, 0.3, 0.0, 0.0),))
        bus = rig.link.assembly.process_bus
        assert bus is not None, "on real frames the bus has a process of its own"
        _say(at="moving", bus=bus.pid)
        end = _record(rig, file, folder, "struck", motion(file.configuration, options["last_s"]))
        rungs = [rung.rung for stop in rig.stops for rung in stop.rungs]
        standing = rig.latch.read().standing.value
        _say(at="end", kind=end.kind.name, cause=end.cause.name, text=end.text, rungs=rungs, latch=standing)


def _record(rig: Rig, file: BenchFile, folder: Path, name: str, phases: tuple[Phase, ...]) -> Any:
    ratio = file.configuration.gearbox.ratio
    recorder = Recorder(folder / f"{name}.h5", header(file, rig, name), rig.scaling, fast=False, ratio=ratio)
    end = rig.run(phases, recorder, lambda: False)
    recorder.close(complete=end.kind is EndKind.FINISHED, accepted=None, quality=None)
    return end


def _say(**content: Any) -> None:
    print(json.dumps(content), flush=True)


if __name__ == "__main__":
    main()
