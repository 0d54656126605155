"""Unmodified pysoem on the other end of a veth pair: scan, configuration, SDO, process data, faults."""

from __future__ import annotations

import struct
import time
from itertools import pairwise

import pysoem
import pytest

from drivers.ethercat.watchdog import set_watchdog
from tests.veth import Emulator

WKC = 9
ANSWERED_US = 20_000
"""within which an answer comes on a busy machine as well; pysoem waits 500 µs by default"""
OUTPUT = struct.Struct("<Hihb")
INPUT = struct.Struct("<HiihbH")


@pytest.fixture(scope="module")
def emulator(veth, tmp_path_factory):
    made = Emulator(veth.far, tmp_path_factory.mktemp("emulator"))
    yield made
    counters = made.stop()
    assert counters["malformed"] == 0


@pytest.fixture
def master(veth, emulator, monkeypatch):
    # a busy machine answers a frame later than in SOEM's 2 ms: one that is late is no lost one
    monkeypatch.setattr(pysoem.settings.timeouts, "ret", 50_000)
    made = pysoem.Master()
    made.open(veth.near)
    yield made
    made.close()


@pytest.fixture
def operational(master):
    assert master.config_init() == 5
    master.config_map()
    master.config_dc()
    assert master.state_check(pysoem.SAFEOP_STATE, 1_000_000) == pysoem.SAFEOP_STATE
    master.state = pysoem.OP_STATE
    cycle(master)
    master.write_state()
    for _ in range(100):
        cycle(master)
        if master.state_check(pysoem.OP_STATE, 10_000) == pysoem.OP_STATE:
            break
    master.read_state()
    assert [slave.state for slave in master.slaves] == [pysoem.OP_STATE] * len(master.slaves)
    yield master
    master.state = pysoem.INIT_STATE
    master.write_state()


def cycle(master, count=1):
    counters = []
    for _ in range(count):
        master.send_processdata()
        counters.append(master.receive_processdata(100_000))
    return counters


def drive(master, control, velocity=0, torque=0, count=1):
    master.slaves[0].output = OUTPUT.pack(control, velocity, torque, 9)
    counters = cycle(master, count)
    return INPUT.unpack(master.slaves[0].input), counters


def until(master, control, mask, pattern, **setpoints):
    """Send a control word until the status word shows a pattern, for a second at most."""
    stop = time.monotonic() + 1.0
    status = drive(master, control, **setpoints)[0]
    while status[0] & mask != pattern:
        assert time.monotonic() < stop, f"status word 0x{status[0]:04X} after a second of 0x{control:04X}"
        status = drive(master, control, **setpoints)[0]
    return status


def enable(master):
    """Walk to operation enabled, out of a fault if there is one."""
    time.sleep(0.01)
    if drive(master, 0x00, count=20)[0][0] & 0x08:
        until(master, 0x00, 0x4F, 0x08)
    reset(master)
    for control, mask, pattern in ((0x06, 0x6F, 0x21), (0x07, 0x6F, 0x23), (0x0F, 0x6F, 0x27)):
        until(master, control, mask, pattern)


def reset(master):
    """Fault reset, for a second at most: it acts on its rising edge, and a host that pauses for longer than the drive's
    watchdog of 100 ms after one edge has a fault again that asks for another.
    """
    stop = time.monotonic() + 1.0
    while (status := drive(master, 0x80, count=20)[0])[0] & 0x4F != 0x40:
        assert time.monotonic() < stop, f"status word 0x{status[0]:04X} after a second of fault resets"
        drive(master, 0x00, count=5)


def test_scan_finds_identities(master):
    assert master.config_init() == 5
    assert [(s.man, s.id, s.rev) for s in master.slaves] == [
        (0xE0000B3C, 0x04020D01, 0x10000),
        (0xE0000B3C, 0x04021902, 0x10000),
        (0xE0000B3C, 0x0A160102, 0x10000),
        (0xE0000B3C, 0x52540202, 0x10000),
        (0xE0000B3C, 0x0D160802, 0x10000),
    ]
    assert [s.name for s in master.slaves] == ["SD-17.5-13", "SD-1650-25", "AI-10V-16", "RTD-2", "DI-8"]


def test_process_data_has_the_expected_working_counter(operational):
    assert operational.expected_wkc == WKC
    assert cycle(operational, 500) == [WKC] * 500


def test_sdo_expedited_normal_and_aborted(operational):
    slave = operational.slaves[0]
    assert slave.sdo_read(0x6076, 0) == (17500).to_bytes(4, "little")
    assert slave.sdo_read(0x1008, 0) == b"Emulated servo drive 17.5 Nm, 13 bit"
    slave.sdo_write(0x6072, 0, (2000).to_bytes(2, "little"))
    assert slave.sdo_read(0x6072, 0) == (2000).to_bytes(2, "little")
    slave.sdo_write(0x6072, 0, (3000).to_bytes(2, "little"))
    for index, subindex, code in ((0x5FFF, 0, 0x06020000), (0x1018, 9, 0x06090011)):
        with pytest.raises(pysoem.SdoError) as caught:
            slave.sdo_read(index, subindex)
        assert caught.value.abort_code == code
    for index, data, code in ((0x6041, bytes(2), 0x06010002), (0x6072, bytes(4), 0x06070012)):
        with pytest.raises(pysoem.SdoError) as caught:
            slave.sdo_write(index, 0, data)
        assert caught.value.abort_code == code


def test_complete_access(master):
    master.config_init()
    assert master.slaves[0].sdo_read(0x1018, 0, ca=True)[:6] == b"\x04\x00" + (0xE0000B3C).to_bytes(4, "little")


def test_segments_through_a_small_mailbox(master):
    """A mailbox of 40 bytes holds 24 bytes of a string: longer ones go up and down in segments."""
    master.manual_state_change = 1
    master.config_init()
    slave = master.slaves[3]
    slave.amend_mbx("out", 0x1000, 40)
    slave.amend_mbx("in", 0x1200, 40)
    slave.state = pysoem.PREOP_STATE
    slave.write_state()
    assert slave.state_check(pysoem.PREOP_STATE, 1_000_000) == pysoem.PREOP_STATE
    assert slave.sdo_read(0x1008, 0) == b"Emulated PT100 input, 2 channels"
    for size in (1, 4, 5, 24, 25, 55, 56, 200):
        text = bytes(65 + i % 26 for i in range(size))
        slave.sdo_write(0x2001, 0, text)
        assert slave.sdo_read(0x2001, 0) == text
    slave.state = pysoem.INIT_STATE
    slave.write_state()
    master.manual_state_change = 0


def test_object_dictionary_is_described(master):
    master.config_init()
    found = {o.index: o for o in master.slaves[0].od}
    assert {0x1000, 0x1018, 0x1600, 0x1C12, 0x6040, 0x6502} <= set(found)
    assert found[0x6064].name == b"Position actual value"
    assert (found[0x6064].data_type, found[0x6064].bit_length) == (0x0004, 32)
    assert [entry.name for entry in found[0x1018].entries][1:3] == [b"Vendor ID", b"Product code"]


def test_mapping_written_before_the_map_is_what_is_exchanged(master):
    master.config_init()
    slave = master.slaves[0]

    def configure(position):
        slave.sdo_write(0x1C12, 0, b"\0")
        slave.sdo_write(0x1600, 0, b"\0")
        slave.sdo_write(0x1600, 1, (0x60400010).to_bytes(4, "little"))
        slave.sdo_write(0x1600, 2, (0x60FF0020).to_bytes(4, "little"))
        slave.sdo_write(0x1600, 0, b"\x02")
        slave.sdo_write(0x1C12, 1, (0x1600).to_bytes(2, "little"))
        slave.sdo_write(0x1C12, 0, b"\x01")

    slave.config_func = configure
    master.config_map()
    assert len(slave.output) == 6
    assert master.state_check(pysoem.SAFEOP_STATE, 1_000_000) == pysoem.SAFEOP_STATE
    master.state = pysoem.INIT_STATE
    master.write_state()
    slave.config_func = None


def test_a_map_that_does_not_fit_is_refused_with_its_code(master):
    """The master programs the sync manager for the mapping it read; one changed afterwards must not pass."""
    master.manual_state_change = 1
    master.config_init()
    master.state = pysoem.PREOP_STATE
    master.write_state()
    assert master.state_check(pysoem.PREOP_STATE, 1_000_000) == pysoem.PREOP_STATE
    master.config_map()
    slave = master.slaves[0]
    slave.sdo_write(0x1C13, 0, b"\0")
    master.state = pysoem.SAFEOP_STATE
    master.write_state()
    master.state_check(pysoem.SAFEOP_STATE, 50_000)
    master.read_state()
    assert slave.state == pysoem.PREOP_STATE | pysoem.STATE_ERROR
    assert slave.al_status == 0x001E
    slave.state = pysoem.PREOP_STATE | pysoem.STATE_ACK
    slave.write_state()
    assert slave.state_check(pysoem.PREOP_STATE, 50_000) == pysoem.PREOP_STATE
    slave.sdo_write(0x1C13, 0, b"\x01")
    master.manual_state_change = 0
    master.state = pysoem.INIT_STATE
    master.write_state()


def test_drive_is_enabled_and_turns(operational):
    for _ in range(5):
        enable(operational)
        before = drive(operational, 0x0F)[0]
        began = last = time.monotonic()
        pause = 0.0
        while (now := time.monotonic()) - began < 0.5:
            after = drive(operational, 0x0F, velocity=300_000)[0]
            pause, last = max(pause, now - last), now
        if pause < 0.05:  # a host that pauses for longer trips the drive's watchdog of 100 ms
            break
    assert after[0] & 0x6F == 0x27
    assert after[2] == pytest.approx(300_000, rel=0.2)
    turned = (after[1] - before[1]) / 8192
    assert 1.0 < turned < 300.0 / 60.0


def test_watchdog_takes_the_slave_out_of_op(operational):
    enable(operational)
    time.sleep(0.3)
    operational.read_state()
    assert operational.slaves[0].state == pysoem.SAFEOP_STATE | pysoem.STATE_ERROR
    assert operational.slaves[0].al_status == 0x001B
    assert operational.slaves[2].state == pysoem.OP_STATE
    cycle(operational, 2)
    assert INPUT.unpack(operational.slaves[0].input)[5] == 0x7500


def test_watchdog_time_is_set_by_register(operational):
    slave = operational.slaves[0]
    # the driver's, which asks again: SOEM waits 2 ms for a register, and a busy machine may take longer
    set_watchdog(slave, "input_drive", 2.0)
    time.sleep(0.3)
    operational.read_state()
    assert slave.state == pysoem.OP_STATE
    set_watchdog(slave, "input_drive", 0.1)


def test_eeprom_is_read_and_written(master):
    master.config_init()
    slave = master.slaves[2]
    assert slave.eeprom_read(pysoem.SiiOffset.MAN) == (0xE0000B3C).to_bytes(4, "little")
    slave.eeprom_write(0x3F0, b"\x12\x34")
    assert slave.eeprom_read(0x3F0)[:2] == b"\x12\x34"


def test_distributed_clocks_run(operational):
    times = []
    for _ in range(50):
        cycle(operational)
        times.append(operational.dc_time)
        time.sleep(0.001)
    assert all(b > a for a, b in pairwise(times))
    assert 40e6 < times[-1] - times[0] < 2e9


class TestFaults:
    """Every fault of the bus, on command."""

    def test_drive_fault_by_code(self, operational, emulator):
        received = []
        slave = operational.slaves[0]
        slave.add_emergency_callback(received.append)
        enable(operational)
        emulator.order("fault drive_fault:input_drive=0x3210")
        status = until(operational, 0x0F, 0x4F, 0x08)
        assert status[5] == 0x3210
        for _ in range(5):
            slave.mbx_receive()
        assert (received[-1].error_code, received[-1].error_reg) == (0x3210, 0x05)
        enable(operational)

    def test_sto(self, operational, emulator):
        enable(operational)
        emulator.order("fault sto:input_drive")
        until(operational, 0x0F, 0x5F, 0x40)
        assert drive(operational, 0x06, count=100)[0][0] & 0x4F == 0x40
        emulator.order("clear sto:input_drive")
        enable(operational)

    def test_working_counter_short(self, operational, emulator):
        emulator.order("fault wkc_short:torque_terminal")
        assert cycle(operational, 3) == [WKC - 1] * 3
        emulator.order("clear wkc_short:torque_terminal")
        assert cycle(operational, 3) == [WKC] * 3

    def test_frames_lost(self, operational, emulator):
        emulator.order("fault frame_lost=2")
        counters = []
        for _ in range(4):
            operational.send_processdata()
            counters.append(operational.receive_processdata(2000))
        assert counters == [-1, -1, WKC, WKC]

    def test_frame_late(self, operational, emulator):
        emulator.order("fault frame_late=0.03")
        operational.send_processdata()
        assert operational.receive_processdata(2000) == -1
        time.sleep(0.05)
        cycle(operational)
        assert cycle(operational, 2) == [WKC, WKC]

    def test_cable_pulled_and_back(self, operational, emulator):
        emulator.order("fault cable_pulled:load_drive")
        assert cycle(operational, 2) == [3, 3]
        operational.read_state()
        assert [s.state & 0x0F for s in operational.slaves] == [pysoem.OP_STATE, 0, 0, 0, 0]
        emulator.order("clear cable_pulled:load_drive")
        assert cycle(operational, 2) == [WKC, WKC]

    def test_slave_lost_comes_back_with_default_settings(self, operational, emulator):
        slave = operational.slaves[1]
        slave.sdo_write(0x6072, 0, (500).to_bytes(2, "little"))
        emulator.order("fault slave_lost:load_drive")
        assert cycle(operational, 2) == [WKC - 3] * 2
        with pytest.raises(pysoem.WkcError):
            slave.sdo_read(0x6072, 0)
        assert slave.recover(ANSWERED_US) == 0
        emulator.order("clear slave_lost:load_drive")
        operational.slaves[1].is_lost = True
        assert slave.recover(ANSWERED_US) > 0
        assert slave.reconfig(ANSWERED_US) == pysoem.SAFEOP_STATE
        assert slave.sdo_read(0x6072, 0) == (2061).to_bytes(2, "little")

    def test_plant_faults_reach_the_process_image(self, operational, emulator):
        emulator.order("fault torque_sensor_saturated")
        emulator.order("fault pt100_open")
        time.sleep(0.3)
        cycle(operational, 2)
        status, value = struct.unpack("<Hh", operational.slaves[2].input)
        assert status & 0x42 == 0x42
        assert value == 32767
        status, _ = struct.unpack("<Hh", operational.slaves[3].input[:4])
        assert status & 0x42 == 0x42
        emulator.order("clear torque_sensor_saturated")
        emulator.order("clear pt100_open")
