"""How long STOP takes on real frames, however it is pressed and whatever is broken beside it: ``docs/stop-times.md``.

The emulator is a process of its own at the far end of a veth pair; it says when a drive has torque and how fast the
shafts are. The service, its run and the run's bus process are those of ``bench serve``. Times count from the press.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import threading
import time
import urllib.request
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Self

from bench.commissioning.record import Commissioned, Zero, digest, record_path
from bench.configuration import BenchFile, load_bench, on_interface
from bench.cycle.round_trip import emulator, veth_pair
from bench.errors import BenchError
from bench.matrix.disks import disk
from bench.matrix.processes import as_hardware, own_places, post, running_service, state, until
from bench.matrix.stop_scene import CONDITIONS, PRESSES, Scene
from bench.matrix.wire import orders
from bench.matrix.worker import CYCLE_S
from bench.stop_button.button import TAKES_TORQUE

WATCH_S = 25.0
_LOOK_S, _ASK_S = 0.01, 0.05
_TURNING, _LOADED = 20.0, 150.0
"""Motor speed in rad/s and load torque in N·m from which the bench counts as turning under load."""
_START_S = 240.0
_ATTEMPTS = 3
_LOAD_STANDSTILL = 0.02
_MARKER = 10
"""What the emulated drives hold where a zero leaves its number, from when they are switched on."""
_PATIENT = {
    "cycle_time": '"1 ms"\nahead = "300 ms"\nhold = "200 ms"',
    "watchdog": '"300 ms"',
    "lost_cycles": "400\nlost_share = 1.0",
    "velocity_error": '"60 rad/s"',
    "minimum_free": '"20 MB"',
}
_WITHOUT = ("following_error", "load_torque_rate", "torque_error")
_CAMPAIGN = """
format = "bench-campaign"
format_version = "1.0"
name = "stop-times"
title = "Turning under load"
[[stages]]
name = "one"
[[stages.points]]
sequence = "constant_velocity"
velocities = ["10 deg/s"]
load_torques = ["350 N*m"]
options = { revolutions = 3 }
"""


class _NotTurning(BenchError):
    """The bench did not get as far as turning under load; nothing was pressed."""


@dataclass(slots=True)
class Row:
    """What was seen of one press; times in s from the press, None for what was not seen."""

    condition: str
    press: str
    answer: str = ""
    """What whoever pressed was told; its key in files is ``told``."""
    torque_off_s: float | None = None
    at_rest_s: float | None = None
    rung: str = ""
    """The one that takes the torque away, as the run's listener or the record of the stop says it."""
    rung_to_off_s: float | None = None
    """From the begin of that rung until the drives had no torque."""
    apart_s: float | None = None
    """The longest time between two looks at the far end: no time is known better than that."""
    note: str = ""
    """Why it was not measured; empty if it was."""
    made: str = ""
    load: float | None = None
    """Day, commit and machine; its load over five minutes."""

    def as_dict(self) -> dict[str, Any]:
        """For a script."""
        return {"told" if name == "answer" else name: value for name, value in asdict(self).items()}

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Self:
        """Read what :meth:`as_dict` wrote; raises TypeError where a key is not known."""
        return cls(**{"answer" if name == "told" else name: value for name, value in content.items()})


def measure(condition: str, press: str, folder: Path) -> Row:
    """Make one row; ``folder`` is new. What kept it from being made stands in its note."""
    row = Row(condition, press)
    for attempt in range(_ATTEMPTS):
        try:
            _measure(row, folder / str(attempt))
        except _NotTurning as error:
            # a host that takes time away may keep a bus from starting; that is not what is tried here
            row.note = f"not measured, {attempt + 1} tries: {error}"
            continue
        except (BenchError, OSError, TimeoutError, subprocess.SubprocessError) as error:
            row.note = f"not measured: {error}"
            return row
        row.note = ""
        return row
    return row


def _measure(row: Row, folder: Path) -> None:
    kind, break_ = CONDITIONS[row.condition]
    folder.mkdir()
    with ExitStack() as closing:
        where = closing.enter_context(disk(kind, folder / "disk"))
        closing.enter_context(own_places(where.folder))
        near, far = closing.enter_context(veth_pair())
        control = folder / "control"
        closing.enter_context(emulator(far, CYCLE_S, "--control", str(control), *as_hardware()))
        order = closing.enter_context(orders(control))
        file = _bench(folder / "bench.toml", near)
        recordings = where.folder / "recordings"
        service, address = closing.enter_context(
            running_service(recordings, "--bench", str(folder / "bench.toml"), "--bus", near)
        )
        _write_commissioning_record(file)
        secret = post(address, "controls/take", name="Ann")["secret"]
        asked = post(address, "runs", secret=secret, name="Ann", text=_CAMPAIGN, folder="run")
        until(lambda: _turns(order, address, asked["id"]), _START_S, "the bench does not turn under load")
        run = next(one for one in state(address, "runs")["runs"] if one["state"] == "running")
        port = state(address, "state")["stop_port"]
        scene = Scene(service, address, run["pid"], recordings, where)
        closing.callback(lambda: [mend() for mend in reversed(scene.mend)])
        break_(scene)
        time.sleep(0.5)
        _press(row, scene, order, port)
        for mend in reversed(scene.mend):
            mend()
        scene.mend.clear()
        _kill(run["pid"])


def _press(row: Row, scene: Scene, order: Callable[[str], dict[str, Any]], port: int | None) -> None:
    began, wall = time.monotonic(), time.time()
    # whoever holds the controls, or somebody else: STOP asks for neither
    by = "Ann" if row.press == "page" else "Bob"
    said: dict[str, Any] = {}

    def press() -> None:
        row.answer = PRESSES[row.press](scene, by, port)

    threads = [threading.Thread(target=press, daemon=True)]
    if port is not None:
        threads.append(threading.Thread(target=_hear, args=(port, began + WATCH_S, said), daemon=True))
    for thread in threads:
        thread.start()
    looked, apart = [began], 0.0
    while time.monotonic() - began < WATCH_S and (row.torque_off_s is None or row.at_rest_s is None):
        status = order("status")
        looked.append(time.monotonic())
        apart = max(apart, looked[-1] - looked[-2])
        after = looked[-1] - began
        shafts = status["shafts"]
        still = abs(shafts["motor_velocity"]) < 0.5 and abs(shafts["load_velocity"]) < _LOAD_STANDSTILL
        row.at_rest_s = (row.at_rest_s or after) if still else None
        row.torque_off_s = None if status["powered"] else (row.torque_off_s or after)
        time.sleep(_LOOK_S)
    row.apart_s = apart
    for thread in threads:
        thread.join(90)
    _rung(row, said, scene.folder / "run", wall)


def _hear(port: int, until_s: float, said: dict[str, Any]) -> None:
    """Ask the run's listener which rung took the torque away until it says so, or is gone."""
    while time.monotonic() < until_s:
        try:
            with urllib.request.urlopen(f"http://127.0.0.1:{port}/state", timeout=1.0) as answer:
                state = json.loads(answer.read())
        except TimeoutError:
            continue
        except (OSError, ValueError) as error:
            if isinstance(getattr(error, "reason", error), ConnectionRefusedError):
                return  # the run has ended
            continue
        if state.get("rung") is not None:
            said.update(state)
            return
        time.sleep(_ASK_S)


def _rung(row: Row, said: dict[str, Any], folder: Path, pressed: float) -> None:
    """Take from the run's listener, else from the stop's record, which rung took the torque away, and when."""
    rung, at = said.get("rung"), said.get("rung_at_ns")
    began = None if at is None else at / 1e9
    if rung is None:
        rung, began = _last_record(folder)
    row.rung = rung or ""
    if began is not None and row.torque_off_s is not None:
        row.rung_to_off_s = row.torque_off_s - (began - pressed)


def _last_record(folder: Path) -> tuple[str | None, float | None]:
    """Return the rung of the last record and its Unix time in s; None where there is no record."""
    with suppress(OSError, ValueError, KeyError, TypeError, IndexError):
        record = json.loads(sorted(folder.glob("stop-*.json"))[-1].read_text("utf-8"))
        began = datetime.fromisoformat(record["at"]).timestamp()
        for rung in record["rungs"]:
            if rung["rung"] in TAKES_TORQUE:
                return rung["rung"], began + rung["began_s"]
    return None, None


def _turns(order: Callable[[str], dict[str, Any]], address: str, run: str) -> bool:
    ended = next((one for one in state(address, "runs")["runs"] if one["id"] == run and one["state"] == "ended"), None)
    if ended is not None:
        raise _NotTurning(f"the run ended before it was struck: {ended['end'].get('text')}")
    shafts = order("status")["shafts"]
    return bool(abs(shafts["motor_velocity"]) > _TURNING and abs(shafts["torque"]) > _LOADED)


def _bench(path: Path, interface: str) -> BenchFile:
    """Write the bench with a slower, patient bus: what is measured is STOP, not the time a host takes away."""
    lines = []
    for line in load_bench("rh380n").text.splitlines():
        key = line.split("=")[0].strip()
        if key in _PATIENT:
            line = f"{key} = {_PATIENT[key]}"
        if key not in _WITHOUT and not (key == "motor_acceleration" and "400" in line):
            lines.append(line)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return on_interface(load_bench(str(path)), interface)


def _write_commissioning_record(file: BenchFile) -> None:
    """Leave a record as a commissioning does, with the marker of drives that were just switched on."""
    bench = file.configuration
    path = record_path(bench)
    assert path is not None
    now = datetime.now().astimezone().isoformat(timespec="seconds")
    zero = Zero("stop-times", 0.0, 0.0, _MARKER, now, "stop-times")
    Commissioned(bench.name, bench.bus.interface, digest(bench), now, "stop-times", (), zero).save(path)


def _kill(pid: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGTERM)
    deadline = time.monotonic() + 10.0
    while Path(f"/proc/{pid}").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
