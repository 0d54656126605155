"""Rows on real frames: a process is killed, or frames come late, while a rig of its own process turns the bench."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from bench.configuration import BenchFile
from bench.cycle.round_trip import emulator, veth_pair
from bench.errors import DeviceError
from bench.matrix.outcome import Envelope, Outcome
from bench.matrix.processes import as_hardware
from bench.matrix.rows import Row
from bench.matrix.worker import CYCLE_S
from bench.recording.repairing import repair
from bench.recording.validation import validate
from bench.safety import LatchFile, Standing

_LOOK_S = 0.02
_LEAD_S = 5.0
"""From the beginning of the motion until it is struck: it turns under load by then."""
_LOAD_STANDSTILL, _GRACE_S, _START_S = 0.02, 3.0, 60.0
_STARTS = 3
"""A bench that does not come to move is started again so often; what was struck is never struck again."""
_END_S = 40.0
"""Patience with a run that goes on to its end: its set values count cycles, so a host that is late makes it longer."""


class _NotMoving(DeviceError):
    """The bench never moved, so nothing was struck: a host that takes time away may keep a bus from starting."""


@dataclass(slots=True)
class Scene:
    """What a row can strike."""

    worker: subprocess.Popen[str]
    bus: int
    order: Callable[[str], dict[str, Any]]


def _kill_writer(scene: Scene) -> None:
    scene.worker.kill()


def _kill_bus(scene: Scene) -> None:
    os.kill(scene.bus, signal.SIGKILL)


def _late_frames(scene: Scene) -> None:
    scene.order("fault frame_late=0.05")


def _pull_cable(scene: Scene) -> None:
    scene.order("fault cable_pulled:input_drive")


_STRIKES: dict[str, Callable[[Scene], None]] = {
    "writer_killed": _kill_writer,
    "bus_process_killed": _kill_bus,
    "frame_late": _late_frames,
    "cable_pulled_on_the_wire": _pull_cable,
}


def run_wire_row(row: Row, file: BenchFile, folder: Path, seed: int = 0) -> Outcome:
    """Start emulator and rig, strike, and look at the emulator's true shafts until they rest."""
    for attempt in range(_STARTS):
        place = folder / str(attempt)
        place.mkdir()
        outcome = Outcome(row.name, row.text, row.kind)
        try:
            _run(row, outcome, file, place, seed)
        except DeviceError as error:
            log = place / "worker.log"
            last = log.read_text("utf-8").splitlines()[-1:] if log.exists() else []
            outcome.require(False, f"{error}: {' '.join(last)}")
            if isinstance(error, _NotMoving):
                continue
        break
    return outcome


def _run(row: Row, outcome: Outcome, file: BenchFile, folder: Path, seed: int) -> None:
    bench, envelope = file.configuration, Envelope.of(file.configuration)
    control = folder / "control"
    options = ("--control", str(control), "--seed", str(seed), *as_hardware())
    with veth_pair() as (near, far), emulator(far, CYCLE_S, *options):
        with orders(control) as order, _worker(folder, near, row.last_s) as worker:
            scene = Scene(worker, _until(worker, "moving")["bus"], order)
            looks = _watch(order, _LEAD_S, lambda look: False)
            turned = max(look.motor_speed for look in looks) > 50.0
            outcome.require(turned, "the bench did not turn before it was struck")
            outcome.struck = looks[-1].load_speed, looks[-1].torque
            struck = time.monotonic()
            _STRIKES[row.name](scene)
            resting = bench.motion.standstill

            def rests(look: Look) -> bool:
                return look.motor_speed < resting and look.load_speed < _LOAD_STANDSTILL and not look.powered

            after = _watch(order, row.within_s + _GRACE_S if row.causes else row.last_s + _END_S, rests)
            elapsed = time.monotonic() - struck if rests(after[-1]) else None
            looks += after
            end = _end_of(worker)
            outcome.drives = order("status")["drives"]
        outcome.sampled_s = apart_s(looks)
        _judge(row, outcome, looks, after, elapsed, end, envelope)
        if row.name == "writer_killed":
            _look_at_latch(outcome, folder)
    _read_back(outcome, folder)


def _look_at_latch(outcome: Outcome, folder: Path) -> None:
    """Nobody is left to say what happened: take what stands in the latch, if anything does."""
    latch = LatchFile(folder / "latch.json").read()
    if latch.standing is not Standing.CLEAR:
        outcome.cause, outcome.sentence = latch.cause, latch.text


class Look(NamedTuple):
    """The truth at a moment: speeds in rad/s and torque in N·m as amounts, whether a drive has torque, when in s."""

    motor_speed: float
    load_speed: float
    torque: float
    powered: bool
    at_s: float


def _watch(order: Callable[[str], dict[str, Any]], longest_s: float, enough: Callable[[Look], bool]) -> list[Look]:
    looks: list[Look] = []
    end = time.monotonic() + longest_s
    while time.monotonic() < end:
        status = order("status")
        shafts = status["shafts"]
        speeds = abs(shafts["motor_velocity"]), abs(shafts["load_velocity"])
        looks.append(Look(*speeds, abs(shafts["torque"]), bool(status["powered"]), time.monotonic()))
        if enough(looks[-1]):
            break
        time.sleep(_LOOK_S)
    return looks


def apart_s(looks: list[Look]) -> float | None:
    """Return the longest time between two looks, s, as it was: a machine that is short of time looks less often."""
    return max((later.at_s - look.at_s for look, later in pairwise(looks)), default=None)


def _judge(
    row: Row,
    outcome: Outcome,
    looks: list[Look],
    after: list[Look],
    elapsed: float | None,
    end: Any,
    envelope: Envelope,
) -> None:
    peaks = max(x.motor_speed for x in looks), max(x.load_speed for x in looks), max(x.torque for x in looks)
    outcome.peaks = peaks
    bounds = (envelope.motor_speed, envelope.load_speed, envelope.torque)
    outcome.require(all(p <= b for p, b in zip(peaks, bounds, strict=True)), f"peaks {outcome.peaks}")
    outcome.require(not after[-1].powered, "a drive kept its torque")
    if row.causes:
        outcome.rest_s = outcome.off_s = elapsed
        seen = "not seen at rest" if elapsed is None else f"stopped after {elapsed:.2f} s"
        outcome.require(elapsed is not None and elapsed <= row.within_s, f"{seen}, allowed {row.within_s:g} s")
    if row.name == "writer_killed":
        return
    outcome.require(end is not None, "the rig said nothing of its end")
    if end is None:
        return
    outcome.cause, outcome.sentence, outcome.rungs = end["cause"], end["text"], tuple(end["rungs"])
    if row.causes:
        outcome.require(end["cause"] in row.causes, f"the cause found is {end['cause']}")
        outcome.require(
            row.expected_text in end["text"], f"the sentence does not say '{row.expected_text}': {end['text']}"
        )
        outcome.require(end["latch"] == "stopped", "the stop is not latched")
    else:
        outcome.cause = outcome.cause if end["kind"] == "TRIPPED" else ""
        outcome.reaction = "runs on" if end["kind"] == "FINISHED" else end["kind"].lower()
        outcome.require(end["kind"] == "FINISHED", f"the bench stopped, it should have run on: {end['text']}")


def _read_back(outcome: Outcome, folder: Path) -> None:
    for part in folder.glob("*.h5.part"):
        repair(part)
    files = sorted(folder.glob("*.h5"))
    outcome.require([file.stem for file in files] == ["earlier", "struck"], f"there are {[f.name for f in files]}")
    for file in files:
        violations = validate(file).violations
        outcome.require(not violations, f"{file.name} is not valid: {'; '.join(map(str, violations[:1]))}")
        outcome.read_back += 1


@contextmanager
def orders(control: Path) -> Iterator[Callable[[str], dict[str, Any]]]:
    """Give a function that sends an order to the emulator and returns its answer."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as line:
        line.settimeout(10.0)
        line.connect(str(control))
        with line.makefile("rw", encoding="utf-8") as text:

            def order(what: str) -> dict[str, Any]:
                text.write(what + "\n")
                text.flush()
                answer: dict[str, Any] = json.loads(text.readline())
                return answer

            yield order


@contextmanager
def _worker(folder: Path, interface: str, last_s: float) -> Iterator[subprocess.Popen[str]]:
    options = json.dumps({"bench": "rh380n", "interface": interface, "folder": str(folder), "last_s": last_s})
    command = [sys.executable, "-m", "bench.matrix.worker", options]
    with (
        (folder / "worker.log").open("w") as log,
        subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True) as process,
    ):
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                process.kill()


def _until(worker: subprocess.Popen[str], where: str) -> dict[str, Any]:
    assert worker.stdout is not None
    for line in worker.stdout:
        said: dict[str, Any] = json.loads(line)
        if said["at"] == where:
            return said
    raise _NotMoving(f"the rig ended before it was {where}")


def _end_of(worker: subprocess.Popen[str]) -> dict[str, Any] | None:
    """Return what the rig says of its end; None if it was killed."""
    try:
        out, _ = worker.communicate(timeout=_START_S)
    except subprocess.TimeoutExpired:
        return None
    lines = [json.loads(line) for line in out.splitlines()]
    return next((line for line in lines if line["at"] == "end"), None)
