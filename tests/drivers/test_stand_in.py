"""The drivers on the in-process stand-in: whole blocks, and cycle by cycle as they run on pysoem."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from drivers.cia402 import Goal, Outcome, State, lead
from drivers.errors import BusError, DriveFaultError, IdentityError
from drivers.ethercat import Condition
from fakes.ethercat.master import EmulatedMaster, emulated_master
from tests.drivers.rig import Rig, make_rig

BLOCK = 500


class CycleByCycle:
    """The stand-in without what pysoem does not have."""

    def __init__(self, master: EmulatedMaster) -> None:
        self.__dict__["master"] = master

    def __getattr__(self, name: str) -> Any:
        if name == "exchange_block":
            raise AttributeError(name)
        return getattr(self.__dict__["master"], name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self.__dict__["master"], name, value)


@pytest.fixture
def master() -> EmulatedMaster:
    return emulated_master("rh380n", seed=5)


@pytest.fixture
def rig(master: EmulatedMaster) -> Iterator[Rig]:
    made = make_rig(master, block_capacity=BLOCK)
    made.start()
    yield made
    made.bus.close()


def journey(rig: Rig) -> list[dict[str, np.ndarray[Any, Any]]]:
    """Enable, run, quick stop, disable; every input on the way."""
    rig.start()
    seen = []
    lead(rig.bus, rig.drives, Goal.ENABLED)
    for velocity in (20.0, 60.0):
        rig.run(velocity, 150.0, BLOCK)
        seen.append(rig.images(BLOCK))
    lead(rig.bus, rig.drives, Goal.QUICK_STOP)
    rig.run(0.0, 0.0, BLOCK)
    seen.append(rig.images(BLOCK))
    lead(rig.bus, rig.drives, Goal.DISABLED)
    rig.bus.close()
    return seen


def test_blocks_and_single_cycles_give_the_same_bytes() -> None:
    blocks = journey(make_rig(emulated_master("rh380n", seed=5), block_capacity=BLOCK))
    cycles = journey(make_rig(CycleByCycle(emulated_master("rh380n", seed=5)), block_capacity=BLOCK))
    for block, single in zip(blocks, cycles, strict=True):
        for name, rows in block.items():
            np.testing.assert_array_equal(rows, single[name], err_msg=name)
    # Not the same because nothing moved.
    assert np.ptp(blocks[-1]["input_drive"]["6064:00"]) > 100


def test_units_and_limits_are_those_of_the_drives(rig: Rig) -> None:
    assert rig.input_drive.units.counts_per_turn == 8192
    assert rig.load_drive.units.torque_nm == pytest.approx(1.65)
    assert rig.bus.sdo_read("load_drive", 0x6072, 0, "u2") == 848  # 1400 N·m of 1650, rounded down
    assert rig.input_drive.verify(rig.bus.sdo("input_drive")) == ()
    assert rig.bus.sdo_read("input_drive", 0x6061, 0, "i1") == 9


def test_set_values_arrive_in_si(rig: Rig) -> None:
    lead(rig.bus, rig.drives, Goal.ENABLED)
    for _ in range(8):
        exchange = rig.run(50.0, 200.0, BLOCK)
        assert rig.bus.good(exchange).all()
        turned = rig.load_drive.position_rad(rig.load_drive.position(BLOCK))
    assert rig.input_drive.velocity(BLOCK).mean() == pytest.approx(50.0, rel=0.01)
    assert rig.load_drive.velocity(BLOCK).mean() == pytest.approx(50.0 / 185.0, rel=0.01)
    assert turned[-1] - turned[0] == pytest.approx(50.0 / 185.0 * (BLOCK - 1) * 0.0005, rel=0.02)
    assert rig.load_drive.torque(BLOCK).mean() == pytest.approx(200.0, abs=5.0)
    volts = rig.torque.counts(BLOCK).mean() * rig.torque.volt_per_count
    assert volts * 1000.0 == pytest.approx(200.0, abs=25.0)
    assert rig.torque.usable(BLOCK).all()
    reading = rig.thermometer.read(BLOCK)
    assert reading.error is None
    assert reading.age_s.max() < 0.06


def test_a_fault_within_a_block_is_found_at_its_cycle(rig: Rig, master: EmulatedMaster) -> None:
    lead(rig.bus, rig.drives, Goal.ENABLED)
    rig.run(50.0, 100.0, BLOCK)
    master.faults.apply("drive_fault", "input_drive", 0x7305, at_cycle=master.bench.cycle + 200)
    rig.input_drive.set_velocity(50.0, BLOCK)
    rig.input_drive.prepare(BLOCK)
    rig.bus.exchange(BLOCK)
    assert 198 <= rig.input_drive.digest(BLOCK) <= 203
    with pytest.raises(DriveFaultError, match=r"0x7305 \(encoder 1 fault\)"):
        rig.input_drive.check(BLOCK)
    assert any(message.code == 0x7305 for message in rig.bus.emergencies())
    with pytest.raises(DriveFaultError):
        lead(rig.bus, [rig.input_drive], Goal.ENABLED)
    master.faults.clear("drive_fault", "input_drive")
    lead(rig.bus, [rig.input_drive], Goal.FAULT_RESET)
    lead(rig.bus, [rig.input_drive], Goal.ENABLED)
    assert rig.input_drive.sequence.state is State.OPERATION_ENABLED


def test_lost_frames_show_in_the_working_counter_only(rig: Rig, master: EmulatedMaster) -> None:
    lead(rig.bus, rig.drives, Goal.ENABLED)
    master.faults.apply("frame_lost", value=3.0)
    exchange = rig.run(10.0, 0.0, 10)
    assert (~rig.bus.good(exchange)).sum() == 3
    assert rig.input_drive.sequence.outcome is Outcome.REACHED


def test_a_drive_that_comes_back_has_its_limits_again_but_no_torque(rig: Rig, master: EmulatedMaster) -> None:
    lead(rig.bus, rig.drives, Goal.ENABLED)
    rig.run(20.0, 0.0, BLOCK)
    master.faults.apply("slave_lost", "load_drive")
    exchange = rig.run(20.0, 0.0, 100)
    assert not rig.bus.good(exchange).any()
    assert [step.condition for step in rig.bus.recover() if step.name == "load_drive"] == [Condition.LOST]
    master.faults.clear("slave_lost", "load_drive")
    for _ in range(20):
        if all(step.condition is Condition.OPERATIONAL for step in rig.bus.recover()):
            break
        rig.run(0.0, 0.0, 5)
    else:
        pytest.fail("the load drive was not recovered")
    rig.run(0.0, 0.0, 50)
    assert rig.bus.sdo_read("load_drive", 0x6072, 0, "u2") == 848
    assert rig.load_drive.verify(rig.bus.sdo("load_drive")) == ()
    assert rig.load_drive.sequence.outcome is Outcome.LEFT
    assert rig.load_drive.sequence.state is State.SWITCH_ON_DISABLED


def test_wrong_identity_ends_before_anything_is_written(master: EmulatedMaster) -> None:
    rig = make_rig(emulated_master("rv80n"))
    with rig.bus, pytest.raises(IdentityError, match="position 1 on emulated should be input_drive"):
        rig.bus.configure()


def test_an_empty_bus(master: EmulatedMaster) -> None:
    master.faults.apply("cable_pulled", "input_drive")
    rig = make_rig(master)
    with rig.bus, pytest.raises(BusError, match="no slave answers on 'emulated'"):
        rig.bus.configure()
