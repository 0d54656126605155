"""The in-process stand-in for pysoem's master: same names, same exceptions, blocks equal to single cycles."""

from __future__ import annotations

import inspect

import numpy as np
import pysoem
import pytest

from fakes.ethercat.faults import BUS_FAULTS, UnknownFaultError
from fakes.ethercat.master import EmulatedMaster, emulated_master
from fakes.ethercat.stand_in_slave import StandInSlave
from tests.fakes.ethercat.simple_plant import simple_bench
from tests.fakes.ethercat.stand_in import INPUT, LOAD, TEMPERATURE, TORQUE, Bus

BEYOND_PYSOEM = {"exchange_block", "snapshot", "restore", "bench", "faults", "check_open", "reaches"}
SLAVE_BEYOND_PYSOEM = {"configure_mailbox", "map", "reached", "refresh", "request", "input_bytes", "output_bytes"}


def public(made):
    return {name for name in dir(made) if not name.startswith("_")}


def test_every_name_is_pysoems():
    master = EmulatedMaster(simple_bench())
    assert public(master) - BEYOND_PYSOEM <= public(pysoem.Master())
    slave = StandInSlave(master, 0, master.bench.slaves[0])
    assert public(slave) - SLAVE_BEYOND_PYSOEM <= public(pysoem.pysoem.CdefSlave)


@pytest.mark.parametrize(
    "name", ["sdo_read", "sdo_write", "set_watchdog", "state_check", "reconfig", "recover", "dc_sync"]
)
def test_parameters_are_pysoems(name):
    theirs = inspect.signature(getattr(pysoem.pysoem.CdefSlave, name)).parameters
    assert list(inspect.signature(getattr(StandInSlave, name)).parameters) == list(theirs)


def test_before_open_everything_is_refused():
    master = EmulatedMaster(simple_bench())
    for call in (master.config_init, master.config_map, master.read_state, master.write_state, master.send_processdata):
        with pytest.raises(pysoem.NetworkInterfaceNotOpenError):
            call()


def test_the_way_to_op():
    master = EmulatedMaster(simple_bench())
    master.open("any")
    assert master.config_init() == 4
    assert [s.state for s in master.slaves] == [pysoem.INIT_STATE] * 4
    assert master.config_map() == 9 + 9 + 15 + 15 + 4 + 8
    assert master.expected_wkc == 8
    assert master.state_check(pysoem.SAFEOP_STATE) == pysoem.SAFEOP_STATE
    master.state = pysoem.OP_STATE
    assert master.write_state() == 4
    assert master.read_state() == pysoem.OP_STATE
    master.send_processdata()
    assert master.receive_processdata() == 8
    assert master.receive_processdata() == -1


def test_configuration_hook_gets_the_position_and_its_errors_come_out_of_config_map():
    master = EmulatedMaster(simple_bench())
    master.open("any")
    master.config_init()
    seen = []
    master.slaves[1].config_func = seen.append
    master.config_map()
    assert seen == [1]

    def fail(position):
        master.slaves[position].sdo_read(0x5FFF, 0)

    master.slaves[1].config_func = fail
    with pytest.raises(pysoem.SdoError) as caught:
        master.config_map()
    assert (caught.value.slave_pos, caught.value.index, caught.value.abort_code) == (2, 0x5FFF, 0x06020000)


def test_only_bytes_are_taken_as_output():
    bus = Bus()
    with pytest.raises(TypeError):
        bus.master.slaves[0].output = bytearray(9)


def test_blocks_equal_single_cycles():
    """One block of 60 and 60 blocks of one give the same process data, with control word changes within the block."""
    blocks, singles = Bus(60), Bus(60)
    words = np.repeat([0x06, 0x07, 0x0F, 0x0F, 0x02, 0x00], 10)
    velocity = np.linspace(0, 900_000, 60).astype(np.int32)
    for bus in (blocks, singles):
        bus.out[INPUT]["6040:00"], bus.out[INPUT]["60FF:00"] = words, velocity
    blocks.run()
    for k in range(60):
        counters = np.zeros(1, np.int32)
        singles.master.exchange_block(singles.raw_out[k : k + 1], singles.raw_in[k : k + 1], counters)
    np.testing.assert_array_equal(blocks.raw_in, singles.raw_in)
    assert {0x31, 0x33, 0x37} <= set(blocks.in_[INPUT]["6041:00"] & 0x7F)


def test_send_and_receive_equal_a_block():
    block, loop = Bus(20), Bus(20)
    block.set(0x06)
    block.run()
    for k in range(20):
        loop.master.slaves[INPUT].output = block.out[INPUT][k].tobytes()
        loop.master.slaves[LOAD].output = block.out[LOAD][k].tobytes()
        loop.master.send_processdata()
        assert loop.master.receive_processdata() == 8
    for i, slave in enumerate(loop.master.slaves):
        assert slave.input == block.in_[i][-1].tobytes()


def test_a_fault_takes_effect_at_its_cycle():
    bus = Bus(100)
    bus.enable()
    at = bus.master.bench.cycle + 37
    bus.master.faults.apply("drive_fault", "input_drive", 0x3210, at_cycle=at)
    bus.run()
    status = bus.in_[INPUT]["6041:00"]
    assert np.flatnonzero(status & 0x08)[0] == 37
    assert set(bus.in_[INPUT]["603F:00"][:37]) == {0}
    assert set(bus.in_[INPUT]["603F:00"][37:]) == {0x3210}


def test_snapshot_replays_to_the_same_bytes():
    bus = Bus(100)
    bus.enable()
    bus.set(0x0F, _60FF=500_000)
    bus.run(10)
    token = bus.master.snapshot()
    bus.run()
    first = bus.raw_in.copy()
    bus.set(0x02)
    bus.run()
    bus.master.restore(token)
    bus.set(0x0F, _60FF=500_000)
    bus.run()
    np.testing.assert_array_equal(bus.raw_in, first)


def test_wrong_block_shapes_are_refused():
    bus = Bus(4)
    with pytest.raises(ValueError, match=r"outputs must be \(n, 18\) bytes"):
        bus.master.exchange_block(bus.raw_out[:, :-1], bus.raw_in, bus.wkc)


class TestSdo:
    def test_lost_slave_gives_a_working_counter_error(self):
        bus = Bus()
        bus.master.faults.apply("slave_lost", "load_drive")
        with pytest.raises(pysoem.WkcError):
            bus.master.slaves[LOAD].sdo_read(0x1000, 0)

    def test_long_objects_need_room(self):
        bus = Bus()
        assert bus.master.slaves[0].sdo_read(0x1008, 0).startswith(b"Emulated servo drive")
        with pytest.raises(pysoem.PacketError):
            bus.master.slaves[0].sdo_read(0x1008, 0, size=4)

    def test_process_data_shows_in_the_dictionary(self):
        bus = Bus()
        bus.enable()
        bus.set(0x0F, _60FF=1234)
        bus.run()
        slave = bus.master.slaves[INPUT]
        assert slave.sdo_read(0x60FF, 0) == (1234).to_bytes(4, "little")
        assert slave.sdo_read(0x6040, 0) == b"\x0f\x00"
        assert slave.sdo_read(0x6041, 0) == bus.in_[INPUT]["6041:00"][-1].tobytes()


class TestBusFaults:
    def test_lost_frames_repeat_the_last_inputs(self):
        bus = Bus(10)
        bus.run()
        bus.master.bench.plant.torque_adc = 99
        bus.master.faults.apply("frame_lost", value=3)
        held = bus.in_[TORQUE][-1].copy()
        assert list(bus.run()) == [-1] * 3 + [8] * 7
        assert set(bus.in_[TORQUE][:3].tolist()) == {held.item()}
        assert bus.in_[TORQUE]["6000:11"][3] == 99

    def test_watchdog_trips_after_its_time_without_frames(self):
        bus = Bus(400)
        bus.enable()
        bus.master.faults.apply("frame_lost", value=250)
        bus.run()
        bus.master.read_state()
        assert [s.state for s in bus.master.slaves] == [0x14, 0x14, 0x08, 0x08]
        assert bus.master.slaves[INPUT].al_status == 0x001B
        assert bus.in_[INPUT]["603F:00"][-1] == 0x7500

    def test_watchdog_holds_just_before_its_time(self):
        bus = Bus(400)
        bus.master.faults.apply("frame_lost", value=200)
        bus.run()
        assert bus.master.read_state() == pysoem.OP_STATE

    def test_watchdog_time_can_be_set(self):
        bus = Bus(400)
        slave = bus.master.slaves[INPUT]
        assert slave.get_watchdog("processdata") == 100.0
        slave.set_watchdog("processdata", 1000.0)
        bus.master.faults.apply("frame_lost", value=250)
        bus.run()
        bus.master.read_state()
        assert [s.state for s in bus.master.slaves[:2]] == [0x08, 0x14]
        with pytest.raises(AttributeError):
            slave.set_watchdog("processdata", 10_000.0)
        with pytest.warns(UserWarning, match="resolution"):
            slave.set_watchdog("processdata", 0.25)

    def test_working_counter_short(self):
        bus = Bus(10)
        bus.master.faults.apply("wkc_short", "torque_terminal", at_cycle=bus.master.bench.cycle + 4)
        assert list(bus.run()) == [8] * 4 + [7] * 6
        bus.master.faults.clear("wkc_short", "torque_terminal")
        assert list(bus.run()) == [8] * 10

    def test_cable_pulled(self):
        bus = Bus(10)
        bus.master.faults.apply("cable_pulled", "load_drive")
        assert list(bus.run()) == [3] * 10
        bus.master.read_state()
        assert [s.state for s in bus.master.slaves] == [8, 0, 0, 0]
        bus.master.faults.clear("cable_pulled", "load_drive")
        assert list(bus.run()) == [8] * 10

    def test_no_slave_at_all_is_no_frame(self):
        bus = Bus(3)
        bus.master.faults.apply("cable_pulled", "input_drive")
        assert list(bus.run()) == [-1] * 3
        assert bus.master.config_init() == -1

    def test_lost_slave_comes_back_with_default_settings(self):
        bus = Bus(10)
        slave = bus.master.slaves[LOAD]
        slave.sdo_write(0x6072, 0, (500).to_bytes(2, "little"))
        bus.master.faults.apply("slave_lost", "load_drive")
        assert list(bus.run()) == [5] * 10
        assert (slave.recover(), slave.reconfig()) == (0, 0)
        bus.master.faults.clear("slave_lost", "load_drive")
        assert slave.recover() == 1
        assert slave.reconfig() == pysoem.SAFEOP_STATE
        assert slave.sdo_read(0x6072, 0) == (2061).to_bytes(2, "little")
        slave.state = pysoem.OP_STATE
        slave.write_state()
        assert list(bus.run()) == [8] * 10

    def test_safe_torque_off(self):
        bus = Bus(10)
        bus.enable()
        bus.master.faults.apply("sto", "input_drive")
        bus.run()
        assert bus.in_[INPUT]["6041:00"][-1] & 0x5F == 0x40
        assert bus.in_[LOAD]["6041:00"][-1] & 0x6F == 0x27

    def test_unknown_names_are_refused(self):
        faults = Bus().master.faults
        for name, role in (("nothing", None), ("drive_fault", None), ("drive_fault", "torque_terminal"), ("sto", "x")):
            with pytest.raises(UnknownFaultError):
                faults.apply(name, role)

    def test_every_fault_can_be_switched(self):
        faults = Bus().master.faults
        for fault in BUS_FAULTS:
            faults.apply(fault.name, "input_drive")
            faults.clear(fault.name, "input_drive")


def test_emulated_master_runs_on_the_plant_that_ships():
    master = emulated_master("rh380n", seed=1)
    bus = Bus(50, master.bench)
    bus.enable()
    assert bus.in_[TEMPERATURE]["6000:11"][3] == pytest.approx(220, abs=30)
    with pytest.raises(Exception, match="no plant file"):
        emulated_master("nowhere")
