"""Rig and bus process on real frames, and what becomes of the drives when one of the two is killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.campaigns.records.recorder import Recorder
from bench.configuration import BenchFile, load_bench, on_interface, parse_bench
from bench.cycle.assembly import assemble
from bench.cycle.end import EndKind
from bench.cycle.rig import Rig
from bench.errors import DeviceError, LimitError
from bench.protocols import Segment
from bench.recording import Gearbox, Recording, RecordingHeader
from bench.recording.validation import validate
from bench.safety import Act, Cause, is_device_fault
from tests.system.test_rig import Tape, never, short
from tests.veth import Emulator, VethPair

PATIENCE_S = 20.0
ROOT = Path(__file__).parents[2]


def patient(file: BenchFile) -> BenchFile:
    """The same bench where a host that takes processor time away stops nothing: these tests are about other stops."""
    text = file.text.replace("lost_cycles = 20", "lost_cycles = 4000\nlost_share = 1.0")
    text = text.replace('cycle_time = "0.5 ms"', 'cycle_time = "1 ms"\nhold = "500 ms"\nahead = "500 ms"')
    return parse_bench(text.replace('velocity_error = "6 rad/s"', 'velocity_error = "60 rad/s"'), file.origin)


@pytest.fixture
def emulator(veth: VethPair, tmp_path: Path) -> Iterator[Emulator]:
    running = Emulator(veth.far, tmp_path, seed=5, cycle_time_s=0.001)
    yield running
    running.stop()


def wait_for(true: Callable[[], bool], what: str) -> float:
    """Wait until something is so; return how long it took, s."""
    began = time.monotonic()
    while not true():
        assert time.monotonic() - began < PATIENCE_S, f"not in time: {what}"
        time.sleep(0.01)
    return time.monotonic() - began


def powered(emulator: Emulator) -> bool:
    states = emulator.order("status")["drives"].values()
    return any(state in ("ENABLED", "QUICK_STOP", "FAULT_REACTION") for state in states)


def alive(pid: int) -> bool:
    status = Path(f"/proc/{pid}/stat")
    return status.exists() and status.read_text().rpartition(")")[2].split()[0] != "Z"


@pytest.fixture(scope="module")
def on_stand_in() -> tuple[BenchFile, Any]:
    file = patient(load_bench("rh380n"))
    return file, lambda: assemble(file.configuration, seed=3, real_time=True, own_process=True)


def test_a_motion_is_whole_though_set_values_go_ahead(on_stand_in: tuple[BenchFile, Any]) -> None:
    file, make = on_stand_in
    tape = Tape()
    with Rig(file, assembly=make()) as rig:
        rig.enable()
        assert rig.run(short(file, speed=2.0, hold_s=0.3), tape, never).kind is EndKind.FINISHED
        assert rig.set_values == (0.0, 0.0)
        assert rig.is_real_time
    velocity, cycle = tape["motor_velocity_setpoint"], tape["cycle"]
    assert [segment for _, segment in tape.segments][:1] == [Segment.RAMP_UP]
    assert tape.segments[0][0] == 0
    assert velocity[0] != 0  # the very first set value of the motion, not what was sent before it
    assert velocity[-1] == 0
    steps = np.abs(np.diff(velocity.astype(np.int64)))
    ramp = np.median(steps[steps > 0])
    assert steps.max() <= 1.5 * ramp * max(1, np.diff(cycle).max())
    assert (np.diff(cycle) >= 1).all()


def test_a_stop_of_the_bus_process_ends_the_run_and_is_not_taken_up_again(on_stand_in: tuple[BenchFile, Any]) -> None:
    file, make = on_stand_in
    assembly = make()
    tape = Tape()
    with Rig(file, assembly=assembly) as rig:
        rig.enable()

        def stop() -> bool:
            if tape.count > 500:
                assembly.bus.order_stop()
            return False

        end = rig.run(short(file, speed=5.0, hold_s=30.0), tape, stop)
        assert (end.kind, end.cause) == (EndKind.TRIPPED, Cause.BUS_STOPPED)
        assert end.text == "the bus process has stopped the drives by itself: the rig ordered it"
        assert rig.drives_off()
        with pytest.raises(LimitError, match="was stopped"):
            rig.enable()
        for act in Act:
            rig.latch.act(act, "test")
        rig.enable()
        # the speed at which it was stopped is forgotten
        assert rig.set_values == (0.0, 0.0)
        rig.idle(0.2)
        assert not assembly.bus.sent["input_drive"]["60FF:00"][: len(assembly.bus.meta)].any()
        assert rig.run(short(file, speed=2.0, hold_s=0.1), Tape(), never).kind is EndKind.FINISHED


def test_process_data_that_is_stopped_is_stopped_at_once(on_stand_in: tuple[BenchFile, Any]) -> None:
    _, make = on_stand_in
    assembly = make()
    with Rig(on_stand_in[0], assembly=assembly) as rig:
        rig.enable()
        rig.go_silent()
        wait_for(lambda: assembly.bus.ended is not None, "the bus process has ended")
        with pytest.raises(DeviceError, match=r"open the bench anew|nobody sends"):
            rig.enable()


def test_a_killed_rig_leaves_drives_at_rest(veth: VethPair, emulator: Emulator, tmp_path: Path) -> None:
    path = tmp_path / "bench.toml"
    path.write_text(patient(on_interface(load_bench("rh380n"), veth.near)).text)
    code = (
        "import sys\n"
        "from tests.system.test_bus_process import drive_for_ever\n"
        "drive_for_ever(sys.argv[1])\n"
    )  # fmt: skip
    rig = subprocess.Popen([sys.executable, "-c", code, str(path)], stdout=subprocess.PIPE, text=True, cwd=ROOT)
    assert rig.stdout is not None
    try:
        bus = json.loads(rig.stdout.readline())["bus"]
        wait_for(lambda: powered(emulator), "the drives are enabled")
        time.sleep(0.5)
    finally:
        rig.send_signal(signal.SIGKILL)
        rig.communicate()
    wait_for(lambda: not powered(emulator), "the drives have no power")
    drives = emulator.order("status")["drives"]
    assert set(drives.values()) == {"SWITCH_ON_DISABLED"}, "stopped by command, not by their watchdogs"
    wait_for(lambda: not alive(bus), "the bus process has ended")
    assert set(emulator.order("status")["al_status"].values()) == {1}


def drive_for_ever(path: str) -> None:
    """What the process that is killed does: say who has the bus, then turn the shafts."""
    file = load_bench(path)
    assembly = assemble(file.configuration, seed=0, real_time=True)
    with Rig(file, assembly=assembly) as rig:
        print(json.dumps({"bus": assembly.bus.pid}), flush=True)
        rig.enable()
        rig.run(short(file, speed=5.0, hold_s=600.0), Tape(), never)


def test_a_killed_bus_process_is_said_and_the_recording_is_kept(
    veth: VethPair, emulator: Emulator, tmp_path: Path
) -> None:
    file = patient(on_interface(load_bench("rh380n"), veth.near))
    assembly = assemble(file.configuration, seed=0, real_time=True)
    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        rate = 1.0 / file.configuration.bus.cycle_time
        header = RecordingHeader(
            "cut", "killed", "free", datetime.now(UTC), rate, rig.source, gearbox=Gearbox(ratio=185.0)
        )
        recorder = Recorder(tmp_path / "cut.h5", header, rig.scaling, fast=False, ratio=185.0)
        killed: list[float] = []

        def kill() -> bool:
            if recorder.rows_taken > 1000 and not killed:
                os.kill(assembly.bus.pid, signal.SIGKILL)
                killed.append(time.monotonic())
            return False

        end = rig.run(short(file, speed=5.0, hold_s=30.0), recorder, kill)
        said_after = time.monotonic() - killed[0]
        recorder.close(complete=False, accepted=False, quality=None)
        assert (end.kind, end.cause) == (EndKind.TRIPPED, Cause.BUS_ENDED)
        assert is_device_fault(end.cause)
        assert "the bus process was killed by SIGKILL" in end.text
        assert "whether the drives' watchdogs stop them nobody sees" in end.text
        assert said_after < 5.0
        wait_for(lambda: not powered(emulator), "the drives' watchdogs have acted")
        assert set(emulator.order("status")["drives"].values()) == {"FAULT"}
        again = rig.run(short(file), Tape(), never)
        assert again.cause is Cause.BUS_ENDED
    assert validate(tmp_path / "cut.h5").violations == ()
    recording = Recording.open(tmp_path / "cut.h5")
    assert not recording.complete
    assert recording.size > 1000
    assert any("killed by SIGKILL" in event.text for event in recording.events)
