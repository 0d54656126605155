"""The rig on the emulated bench, through the real drivers: motion, replay of a trip to its very cycle, the ladder."""

import errno
import math
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.campaigns.planning.facts import facts
from bench.campaigns.planning.registry import build_sequence
from bench.configuration import BenchFile, load_bench, parse_bench
from bench.cycle.assembly import Assembly, assemble
from bench.cycle.end import EndKind
from bench.cycle.rig import Rig
from bench.errors import DeviceError, LimitError
from bench.protocols import Phase, Point, Segment
from bench.safety import Cause, LatchFile, Standing


class Tape:
    """Keeps all rows, segments and events."""

    def __init__(self) -> None:
        self.blocks: list[dict[str, NDArray[Any]]] = []
        self.segments: list[tuple[int, Segment | None]] = []
        self.events: list[str] = []
        self.count = 0

    def segment(self, segment: Segment | None) -> None:
        self.segments.append((self.count, segment))

    def rows(self, raw: dict[str, NDArray[Any]]) -> None:
        self.blocks.append(raw)
        self.count += raw["cycle"].size

    def event(self, level: str, text: str) -> None:
        self.events.append(text)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return np.concatenate([block[name] for block in self.blocks])


def never() -> bool:
    return False


def short(file: BenchFile, torque: float = 200.0, speed: float = 10.0, hold_s: float = 1.0) -> tuple[Phase, ...]:
    """A loaded motion without a whole revolution."""
    point = Point("run_in", torque, math.radians(speed))
    return build_sequence("run_in", (("duration", hold_s),)).phases(point, facts(file.configuration))


def emulated(name: str = "rh380n", block: int | None = None) -> tuple[BenchFile, Assembly]:
    text = load_bench(name).text
    if block is not None:
        text = text.replace("block = 4000", f"block = {block}")
    file = parse_bench(text, name)
    return file, assemble(file.configuration, seed=3, real_time=False)


@pytest.mark.parametrize("name", ["rh380n", "rv80n"])
def test_motion_is_what_was_asked_for(name: str) -> None:
    file, assembly = emulated(name)
    tape = Tape()
    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        assert rig.run(short(file), tape, never).kind is EndKind.FINISHED
        si = {spec: tape[spec] * rig.scaling.scale(spec) + rig.scaling.offset(spec) for spec in rig.scaling.specs}
    ratio = file.configuration.gearbox.ratio
    forward = slice(tape.count // 3, tape.count // 3 + 1000)
    assert np.mean(si["motor_velocity"][forward]) / ratio == pytest.approx(math.radians(10), rel=0.02)
    assert np.mean(si["load_velocity"][forward]) == pytest.approx(math.radians(10), rel=0.05)
    # signs: the sensor sees the set torque, the load motor opposes motion with it, both encoders turn the same way
    assert np.mean(si["load_torque"][forward]) == pytest.approx(200, abs=25)
    assert np.mean(si["load_motor_torque"][forward]) == pytest.approx(200, abs=15)
    assert np.mean(si["motor_torque"][forward]) > 200 / ratio
    assert np.abs(si["load_angle"] - si["motor_angle"] / ratio).max() < 2e-3
    assert np.all(np.diff(tape["cycle"]) == 1)


def test_every_channel_has_its_type_and_no_cycle_is_lost() -> None:
    file, assembly = emulated()
    tape = Tape()
    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        rig.run(short(file, hold_s=0.2), tape, never)
        specs = rig.scaling.specs
    for name, spec in specs.items():
        values = tape[name]
        assert values.shape == (tape.count,)
        assert values.dtype.kind in "iu"
        assert np.can_cast(values.dtype, spec.dtype) or np.array_equal(values, values.astype(spec.dtype))


FAULTS: list[tuple[str, dict[str, Any], Cause]] = [
    ("drive_fault", {"role": "input_drive", "value": 0x7305}, Cause.INPUT_DRIVE_FAULT),
    ("drive_fault", {"role": "load_drive", "value": 0x4310}, Cause.LOAD_DRIVE_FAULT),
    ("cable_pulled", {"role": "input_drive"}, Cause.LOST_CYCLES),
]


@pytest.mark.parametrize(("fault", "arguments", "cause"), FAULTS)
@pytest.mark.parametrize("block", [1, 700, 4000])
def test_a_fault_trips_in_its_cycle_whatever_the_block(
    fault: str, arguments: dict[str, Any], cause: Cause, block: int
) -> None:
    file, assembly = emulated(block=block)
    tape = Tape()
    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        start = assembly.master.bench.cycle
        at = start + 1500
        assembly.master.faults.apply(fault, **arguments, at_cycle=at)
        end = rig.run(short(file, hold_s=3.0), tape, never)
        rows = tape["cycle"] - tape["cycle"][0] if tape.count else np.empty(0)
        position = assembly.master.bench.cycle
        assembly.master.faults.clear(fault, role=arguments.get("role"))
    assert (end.kind, end.cause) == (EndKind.TRIPPED, cause)
    assert any("stopped" in text for text in tape.events)
    reaction = file.configuration.limits.lost_cycles if cause is Cause.LOST_CYCLES else 3
    # nothing of the block after the trip has happened: set values of the stop follow within a few cycles of the fault
    stop_row = next(count for count, segment in reversed(tape.segments) if segment is Segment.RAMP_DOWN)
    assert 1500 - reaction <= stop_row <= 1500 + reaction
    assert position - start < 1500 + 4 * 2000
    status = {Cause.INPUT_DRIVE_FAULT: "motor_status", Cause.LOAD_DRIVE_FAULT: "load_status"}.get(cause)
    if status is not None:
        # the last row before the stop is the cycle that tripped, and no earlier one is bad
        enabled = tape[status][:stop_row] & 0x6F == 0x27
        assert not enabled[-1]
        assert enabled[:-1].all()
    assert np.all(np.diff(rows) >= 1)


def test_blocks_and_single_cycles_give_the_same_recording_up_to_the_trip() -> None:
    tapes = []
    for block in (1, 4000):
        file, assembly = emulated(block=block)
        tape = Tape()
        with Rig(file, assembly=assembly) as rig:
            rig.enable()
            assembly.master.faults.apply(
                "drive_fault", role="input_drive", value=0x7305, at_cycle=assembly.master.bench.cycle + 900
            )
            rig.run(short(file, hold_s=2.0), tape, never)
        tapes.append((tape["motor_angle"] - tape["motor_angle"][0], tape.segments[-1][0]))
    (single, end), (blocked, end_blocked) = tapes
    assert end == end_blocked
    # the noise differs (opening the bench took different numbers of cycles), the motion does not
    counts = np.abs(single[:end] - blocked[:end])
    assert counts.max() <= 4


@pytest.mark.parametrize("when", [0.01, 0.6, 2.5])
def test_operator_stop_ends_at_rest_without_load_and_voltage(when: float) -> None:
    file, assembly = emulated(block=100)
    tape = Tape()

    def stop() -> bool:
        return tape.count * file.configuration.bus.cycle_time >= when

    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        end = rig.run(short(file, torque=500.0, hold_s=5.0), tape, stop)
        assert end.kind is EndKind.INTERRUPTED
        assert rig.drives_off()
        si = {name: tape[name] * rig.scaling.scale(name) for name in ("motor_velocity", "load_motor_torque_setpoint")}
    assert abs(np.mean(si["motor_velocity"][-20:])) < file.configuration.motion.standstill
    assert tape["load_motor_torque_setpoint"][-1] == 0
    # the load went off before the input stopped
    loaded = np.flatnonzero(np.abs(si["load_motor_torque_setpoint"]) > 5.0)
    if loaded.size:
        assert abs(np.mean(si["motor_velocity"][loaded[-1] - 20 : loaded[-1]])) > 10.0
    assert "bench at rest" in tape.events[-1]


def test_a_stopped_bench_moves_again_only_after_it_is_enabled() -> None:
    file, assembly = emulated(block=500)
    stops: list[Callable[[], bool]] = [lambda: True, never]
    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        assert rig.run(short(file), Tape(), stops[0]).kind is EndKind.INTERRUPTED
        refused = rig.run(short(file), Tape(), never)
        assert (refused.kind, refused.cause) == (EndKind.TRIPPED, Cause.INPUT_DRIVE_FAULT)
        rig.enable()
        assert rig.run(short(file, hold_s=0.2), Tape(), never).kind is EndKind.FINISHED


def test_limits_hold_while_the_bench_waits() -> None:
    file, assembly = emulated(block=100)
    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        rig.idle(0.2)
        assembly.master.faults.apply("drive_fault", role="load_drive", value=0x4310)
        rig.idle(0.2)
        assert rig.drives_off()
        end = rig.run(short(file), Tape(), never)
        assert (end.kind, end.cause) == (EndKind.TRIPPED, Cause.LOAD_DRIVE_FAULT)


def test_waiting_after_a_stop_is_no_further_stop() -> None:
    """A recording is finished while the bench waits with its drives off."""
    file, assembly = emulated(block=100)
    with Rig(file, assembly=assembly) as rig:
        rig.enable()
        assert rig.run(short(file), Tape(), lambda: True).kind is EndKind.INTERRUPTED
        rig.idle(0.2)
        assert [stop.cause for stop in rig.stops] == [Cause.OPERATOR]
        assert rig.latch.read().standing is Standing.CLEAR
        rig.enable()
        assembly.master.faults.apply("input_encoder_frozen")
        end = rig.run(short(file), Tape(), never)
        assert end.kind is EndKind.TRIPPED
        rig.idle(0.2)
        assert rig.latch.read().cause == end.cause.name


def test_a_slave_of_another_identity_is_refused_before_anything_moves() -> None:
    text = load_bench("rh380n").text.replace("product = 0x0402_0D01", "product = 0x0402_0D0F")
    file = parse_bench(text, "wrong")
    with pytest.raises(DeviceError, match="input_drive"):
        Rig(file).open()


def test_a_wrong_rated_torque_is_refused_before_anything_moves() -> None:
    text = load_bench("rh380n").text.replace('nominal_torque = "17.5 N*m"', 'nominal_torque = "18 N*m"')
    with pytest.raises(DeviceError, match="rated torque"):
        Rig(parse_bench(text, "wrong")).open()


@pytest.mark.parametrize("disk", ["read-only", "frozen"])
def test_a_disk_that_fails_holds_up_no_stop(disk: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    thaw = threading.Event()

    def fail(_: int) -> None:
        if disk == "read-only":
            raise OSError(errno.EROFS, "Read-only file system")
        thaw.wait(20.0)

    monkeypatch.setattr("os.fsync", fail)
    file, assembly = emulated(block=100)
    began = 0.0

    class Watch(Tape):
        def event(self, level: str, text: str) -> None:
            nonlocal began
            super().event(level, text)
            if text.startswith("stopped: "):
                began = time.monotonic()
            elif text == "bench at rest":
                assert time.monotonic() - began < 5.0, "the disk was waited for"

    tape = Watch()
    with Rig(file, assembly=assembly, latch=LatchFile(tmp_path / "latch.json")) as rig:
        rig.enable()
        assembly.master.faults.apply(
            "drive_fault", role="input_drive", value=0x7305, at_cycle=assembly.master.bench.cycle + 2000
        )
        end = rig.run(short(file, hold_s=3.0), tape, never)
        assembly.master.faults.clear("drive_fault", role="input_drive")
        assert (end.kind, end.cause) == (EndKind.TRIPPED, Cause.INPUT_DRIVE_FAULT)
        assert rig.latch.read().standing is Standing.STOPPED
        assert rig.stops[0].rungs
        assert "could not be stored" in end.text
        assert any("could not be stored" in text for text in tape.events)
        with pytest.raises(LimitError, match="gives no torque"):
            rig.enable()
    thaw.set()
