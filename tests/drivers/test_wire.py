"""The drivers on unmodified pysoem, over a veth pair, against the slaves as frames.

What counts is the accounting (each cycle done, good or marked), never how many were late: the host may be busy.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.cia402 import DriveLimits, Goal, Outcome, ServoDrive, State, lead
from drivers.errors import BusError, DriveFaultError, DriverError, IdentityError, UnmappedError
from drivers.ethercat import AbsoluteDeadlines, Condition, EtherCatBus, soem_master
from drivers.ethercat import bus as bus_module
from tests.drivers.rig import INPUT, Rig, make_rig
from tests.veth import Emulator, VethPair

BLOCK = 100
WATCHDOG_S = 0.2
"""Above what a busy host takes away at a time."""


@pytest.fixture(scope="module")
def emulator(veth: VethPair, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Emulator]:
    running = Emulator(veth.far, tmp_path_factory.mktemp("wire"), seed=5)
    yield running
    running.stop()


@pytest.fixture
def rig(veth: VethPair, emulator: Emulator) -> Iterator[Rig]:
    made = make_rig(soem_master(), veth.near, WATCHDOG_S, block_capacity=BLOCK, pacing=AbsoluteDeadlines(0.0005))
    try:
        made.start()
        # The test before may have left the bus with its drives enabled, which they take as a fault of communication.
        lead(made.bus, made.drives, Goal.FAULT_RESET, timeout_s=5.0)
        yield made
    finally:
        made.bus.close()


def run_until(rig: Rig, velocity: float, done: str, limit_s: float = 5.0) -> None:
    """Run at a velocity until a drive's sequence has that outcome."""
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        rig.run(velocity, 0.0, 1)
        if done in {drive.sequence.outcome.name for drive in rig.drives}:
            return
    pytest.fail(f"no drive came to {done} within {limit_s} s")


def test_slaves_are_mapped_again_where_one_had_no_process_data(
    veth: VethPair, emulator: Emulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second mapping begins with slaves that the first has left in SAFEOP."""
    real, seen = bus_module.check_sizes, []

    def check(specs: Any, found: Any, outputs: Any, inputs: Any) -> None:
        seen.append([len(slave.output) for slave in found])
        if len(seen) == 1:
            raise UnmappedError("input_drive has no process data of outputs")
        real(specs, found, outputs, inputs)

    monkeypatch.setattr(bus_module, "check_sizes", check)
    made = make_rig(soem_master(), veth.near, WATCHDOG_S, block_capacity=BLOCK, pacing=AbsoluteDeadlines(0.0005))
    try:
        made.start()
        assert seen == [seen[0]] * 2
        assert made.bus.expected_wkc == 9
        assert 9 in made.run(0.0, 0.0, BLOCK).wkc
    finally:
        made.bus.close()


def test_slaves_that_are_late_are_waited_for_before_the_bus_cycles(veth: VethPair, emulator: Emulator) -> None:
    """SOEM waits 20 ms for a request to be taken; an emulator that has to wait for a processor may need more."""
    made = make_rig(soem_master(), veth.near, WATCHDOG_S)
    with made.bus as bus:
        bus.configure()
        drives = [bus.sdo(name) for name in ("input_drive", "load_drive")]
        before = [(sdo.read(0x6072, 0, "u2"), sdo.read(0x6080, 0, "u4")) for sdo in drives]
        assert before[0] != before[1]
        begun = time.monotonic()
        emulator.process.send_signal(signal.SIGSTOP)
        goes_on = threading.Timer(0.5, emulator.process.send_signal, (signal.SIGCONT,))
        goes_on.start()
        try:
            after = [(sdo.read(0x6072, 0, "u2"), sdo.read(0x6080, 0, "u4")) for sdo in drives]
        finally:
            goes_on.join()
        assert after == before
        assert time.monotonic() - begun >= 0.5


def test_op_process_data_and_back(rig: Rig) -> None:
    bus = rig.bus
    assert bus.expected_wkc == 9
    lead(bus, rig.drives, Goal.ENABLED, timeout_s=5.0)
    positions, cycles, good = [], [], 0
    for _ in range(30):
        exchange = rig.run(40.0, 100.0, BLOCK)
        assert exchange.n_done == BLOCK
        assert set(np.unique(exchange.wkc)) <= {-1, 9}
        good += int(bus.good(exchange).sum())
        positions.append(rig.input_drive.position(BLOCK))
        cycles.append(exchange.cycle)
    assert all(drive.sequence.outcome is Outcome.REACHED for drive in rig.drives)
    assert good > 15 * BLOCK
    assert np.all(np.diff(np.concatenate(cycles)) >= 1)
    turned = np.diff(np.concatenate(positions)[[10 * BLOCK, -1]])[0]
    elapsed = np.diff(np.concatenate(cycles)[[10 * BLOCK, -1]])[0] * 0.0005
    assert turned / elapsed * rig.input_drive.units.position_rad == pytest.approx(40.0, rel=0.1)
    assert rig.load_drive.torque(BLOCK)[-1] == pytest.approx(100.0, abs=10.0)
    assert rig.thermometer.read(BLOCK).error is None
    assert rig.input_drive.verify(bus.sdo("input_drive")) == ()
    lead(bus, rig.drives, Goal.QUICK_STOP, timeout_s=5.0)
    lead(bus, rig.drives, Goal.DISABLED, timeout_s=5.0)
    assert all(drive.sequence.state is State.SWITCH_ON_DISABLED for drive in rig.drives)


def test_a_fault_arrives_as_state_code_and_emergency(rig: Rig, emulator: Emulator) -> None:
    lead(rig.bus, rig.drives, Goal.ENABLED, timeout_s=5.0)
    emulator.order("fault drive_fault:input_drive=0x3220")
    run_until(rig, 10.0, "FAULTED")
    with pytest.raises(DriveFaultError, match="input_drive"):
        rig.input_drive.check()
    emulator.order("clear drive_fault:input_drive")
    codes = [message.code for _ in range(5) for message in rig.bus.emergencies()]
    assert 0x3220 in codes
    lead(rig.bus, [rig.input_drive], Goal.FAULT_RESET, timeout_s=5.0)
    lead(rig.bus, rig.drives, Goal.ENABLED, timeout_s=5.0)


def test_silence_of_the_master_trips_the_watchdog_and_op_comes_back_without_torque(rig: Rig) -> None:
    lead(rig.bus, rig.drives, Goal.ENABLED, timeout_s=5.0)
    time.sleep(2 * WATCHDOG_S)
    assert any("sync manager watchdog" in step.text for step in rig.bus.recover())
    for _ in range(100):
        if all(step.condition is Condition.OPERATIONAL for step in rig.bus.recover()):
            break
        rig.run(0.0, 0.0, 2)
    else:
        pytest.fail("the bus did not come back to OP")
    rig.run(0.0, 0.0, BLOCK)
    assert {drive.sequence.outcome for drive in rig.drives} <= {Outcome.LEFT, Outcome.FAULTED}


def test_a_slave_that_was_lost_is_configured_again(rig: Rig, emulator: Emulator) -> None:
    lead(rig.bus, rig.drives, Goal.ENABLED, timeout_s=5.0)
    emulator.order("fault slave_lost:load_drive")
    exchange = rig.run(0.0, 0.0, BLOCK)
    assert not rig.bus.good(exchange)[-1]
    assert {step.name for step in rig.bus.recover() if step.condition is Condition.LOST} == {"load_drive"}
    emulator.order("clear slave_lost:load_drive")
    seen = set()
    for _ in range(100):
        steps = rig.bus.recover()
        seen |= {(step.name, step.condition) for step in steps}
        if all(step.condition is Condition.OPERATIONAL for step in steps):
            break
        rig.run(0.0, 0.0, 2)
    else:
        pytest.fail(f"the load drive was not recovered: {sorted(str(s) for s in seen)}")
    assert ("load_drive", Condition.RECONFIGURED) in seen
    assert rig.load_drive.verify(rig.bus.sdo("load_drive")) == ()
    assert rig.load_drive.sequence.outcome is not Outcome.REACHED


def test_close_leaves_the_slaves_in_init(rig: Rig, emulator: Emulator) -> None:
    lead(rig.bus, rig.drives, Goal.ENABLED, timeout_s=5.0)
    rig.bus.close()
    assert set(emulator.order("status")["al_status"].values()) == {1}


def test_a_limit_the_drive_cannot_keep_ends_configure(veth: VethPair, emulator: Emulator) -> None:
    drive = ServoDrive(replace(INPUT, limits=DriveLimits(torque_nm=2000.0, speed_rad_s=300.0)))
    rig = make_rig(soem_master(), veth.near)
    bus = EtherCatBus(soem_master(), veth.near, [drive.spec, *(spec for spec in rig.bus.specs[1:])])
    with bus, pytest.raises(DriverError, match=r"torque limit 2000 N·m \(6072:00\) was not taken"):
        bus.configure()
    assert set(emulator.order("status")["al_status"].values()) == {1}


def test_drives_on_distributed_clocks(veth: VethPair, emulator: Emulator) -> None:
    rig = make_rig(
        soem_master(), veth.near, WATCHDOG_S, 125_000, block_capacity=BLOCK, pacing=AbsoluteDeadlines(0.0005)
    )
    try:
        rig.start()
        lead(rig.bus, rig.drives, Goal.FAULT_RESET, timeout_s=5.0)
        lead(rig.bus, rig.drives, Goal.ENABLED, timeout_s=5.0)
        assert rig.bus.good(rig.run(0.0, 0.0, BLOCK)).any()
    finally:
        rig.bus.close()


def test_a_bus_without_slaves_and_one_without_an_interface(veth: VethPair, emulator: Emulator) -> None:
    emulator.order("fault cable_pulled:input_drive")
    rig = make_rig(soem_master(), veth.near)
    try:
        with rig.bus, pytest.raises(BusError, match="no slave answers"):
            rig.bus.configure()
    finally:
        emulator.order("clear cable_pulled:input_drive")
    with pytest.raises(BusError, match="network interface 'none0' cannot be opened"):
        make_rig(soem_master(), "none0").bus.open()


def test_another_bench_is_refused_by_identity(veth: VethPair, emulator: Emulator, tmp_path: Path) -> None:
    emulator.order("fault slave_lost:input_drive")
    rig = make_rig(soem_master(), veth.near)
    try:
        # The load drive answers first now.
        with rig.bus, pytest.raises(IdentityError, match="that is what load_drive should be"):
            rig.bus.configure()
    finally:
        emulator.order("clear slave_lost:input_drive")
