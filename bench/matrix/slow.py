"""Rows of a thermometer beside the bus: its line and its wires, struck in motion under load, in real time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.metadata import entry_points
from pathlib import Path
from threading import Event, Thread
from typing import Any

from bench.configuration import BenchConfiguration, BenchFile
from bench.configuration.bus import SlowSensor
from bench.cycle.assembly import assemble
from bench.cycle.rig import Rig
from bench.errors import ConfigurationError
from bench.matrix.outcome import Outcome
from bench.matrix.plant import judge_end, judge_shafts, judge_stop, motion, read_back, record, strike_cycle
from bench.matrix.rows import Row
from bench.protocols import Phase, Segment
from bench.safety import Act, LatchFile, Standing

_AGE_S, _PERIOD_S = 1.0, 0.2
_REST = (Phase(Segment.DWELL, 0.3, 0.0, 0.0),)
_LAST_S, _POLL_S = 8.0, 0.002


def run_slow_rows(rows: Sequence[Row], file: BenchFile, folder: Path, seed: int = 0) -> Iterator[Outcome]:
    """Yield what became of each row; those on one line share a bench, which after each is reset and resumed."""
    for line, driver in (("modbus_rtu", "pt100_modbus_rtu"), ("serial", "pt100_serial")):
        chosen = [row for row in rows if (row.name.startswith("serial")) == (line == "serial")]
        if chosen:
            (folder / line).mkdir()
            with _transmitter(**{line: "pty"}) as device:
                bench = _with_slow_sensor(file, driver, str(device.places[line]))
                yield from _rows_on(chosen, bench, device, folder / line, seed)


def _rows_on(rows: Sequence[Row], file: BenchFile, device: Any, folder: Path, seed: int) -> Iterator[Outcome]:
    assembly = assemble(file.configuration, seed=seed, real_time=True)
    master: Any = assembly.master
    latch = LatchFile(folder / "latch.json")
    with Rig(file, assembly=assembly, latch=latch, real_time=True) as rig:
        for number, row in enumerate(rows):
            outcome = Outcome(row.name, row.text, row.kind)
            _until_well(rig)
            rig.enable()
            _, earlier = record(rig, file, folder, f"earlier-{number}", _REST)
            stops, offset = len(rig.stops), master.bench.cycle - rig.link.cycle
            with _struck_at(master, strike_cycle(rig), partial(device.switch, row.name, True)) as struck:
                end, shafts = record(rig, file, folder, f"struck-{number}", motion(file.configuration, _LAST_S))
            shafts.look()
            outcome.require(bool(struck), f"the bench ended before it was struck: {end.text}")
            judge_end(row, outcome, rig, end, shafts, stops)
            if struck:
                outcome.struck = shafts.at(struck[0])
                judge_stop(row, outcome, rig, shafts, struck[0], offset)
            judge_shafts(outcome, file.configuration, shafts)
            if latch.read().standing is Standing.STOPPED:
                for act in Act:
                    latch.act(act, "matrix")
            device.switch(row.name, False)
            read_back(outcome, folder, {f"earlier-{number}": earlier, f"struck-{number}": shafts})
            yield outcome


@contextmanager
def _struck_at(master: Any, cycle: int, strike: Callable[[], None]) -> Iterator[list[int]]:
    """Strike from another thread once the bench is at a cycle; yields the cycle in which that was, empty until then."""
    struck: list[int] = []
    over = Event()

    def wait() -> None:
        while master.bench.cycle < cycle:
            if over.wait(_POLL_S):
                return
        struck.append(int(master.bench.cycle))
        strike()

    thread = Thread(target=wait, name="strike", daemon=True)
    thread.start()
    try:
        yield struck
    finally:
        over.set()
        thread.join()


def _until_well(rig: Rig) -> None:
    """Wait until the thermometer is read again."""
    deadline = time.monotonic() + 10.0
    while rig.look().tripped and time.monotonic() < deadline:
        time.sleep(0.05)


def _with_slow_sensor(file: BenchFile, driver: str, port: str) -> BenchFile:
    """Return the bench with its thermometer on a line beside the bus, and an age limit that does not take long."""
    config = file.configuration
    kept = [slave for slave in config.bus.slaves if slave.role != "temperature_terminal"]
    slaves = tuple(slave.model_copy(update={"position": i}) for i, slave in enumerate(kept, 1))
    sensor = SlowSensor.model_validate(
        {"role": "temperature", "driver": driver, "period": f"{_PERIOD_S} s", "options": {"port": port}}
    )
    bus = config.bus.model_copy(update={"slaves": slaves, "slow_sensors": (sensor,), "block": 100})
    limits = config.limits.model_copy(update={"slow_reading_age": _AGE_S, "frozen_temperature": None})
    changed: BenchConfiguration = config.model_copy(update={"bus": bus, "limits": limits})
    return BenchFile(changed, file.text, file.origin)


@contextmanager
def _transmitter(**options: str) -> Iterator[Any]:
    found = entry_points(group="bench.emulators", name="transmitters")
    if not found:
        raise ConfigurationError("no transmitters are installed: entry point 'transmitters' of 'bench.emulators'")
    with next(iter(found)).load()(**options) as device:
        yield device
