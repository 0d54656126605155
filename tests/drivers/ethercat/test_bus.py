from __future__ import annotations

from typing import Any

import numpy as np
import pysoem
import pytest

from drivers.entries import Entry
from drivers.errors import BusError, DriverError, UnmappedError
from drivers.ethercat import Condition, EtherCatBus, Pdo, SdoClient, SlaveSpec, nonblocking
from drivers.ethercat.exchange import CycleExchanger
from tests.drivers.ethercat.scripted import OP, PREOP, SAFEOP, ScriptedMaster, slave_for

OUT = (Entry("6040:00", "u2"), Entry("60FF:00", "i4"))
IN = (Entry("6041:00", "u2"), Entry("6064:00", "i4"))
DRIVE = SlaveSpec("drive", 1, 0xE0, 0x11, (Pdo(0x1600, OUT),), (Pdo(0x1A00, IN),))
TERMINAL = SlaveSpec("terminal", 2, 0xE0, 0x12, (), (Pdo(0x1A00, (Entry("6000:11", "i2"),), fixed=True),))


def make(*specs: SlaveSpec, **options: Any) -> tuple[EtherCatBus, ScriptedMaster]:
    chosen = specs or (DRIVE, TERMINAL)
    master = ScriptedMaster([slave_for(spec) for spec in chosen])
    for slave in master.slaves:
        slave.put(0x1C13, 0, "u1", 1)
        slave.put(0x1C13, 1, "u2", 0x1A00)
    return EtherCatBus(master, "eth1", chosen, nonblocking_socket=False, **options), master


def running(*specs: SlaveSpec, **options: Any) -> tuple[EtherCatBus, ScriptedMaster]:
    bus, master = make(*specs, **options)
    bus.open()
    bus.configure()
    bus.to_operational()
    return bus, master


def test_from_open_to_op_and_back_to_init() -> None:
    bus, master = make()
    with bus:
        bus.configure()
        bus.to_operational()
        assert [slave.state for slave in master.slaves] == [OP, OP]
        assert master.slaves[0].objects[0x1600, 2] == (0x60FF0020).to_bytes(4, "little")
    assert master.log[-2:] == ["state 1", "close"]
    assert master.opened is None


def test_a_silent_slave_is_waited_for_only_until_the_bus_cycles(monkeypatch: pytest.MonkeyPatch) -> None:
    drained: list[int] = []
    monkeypatch.setattr(nonblocking, "drain", drained.append)
    bus, master = make()
    bus.open()
    bus._sockets = frozenset({7})
    bus.configure()
    slave = master.slaves[0]
    slave.sdo_script = [pysoem.WkcError(wkc=0)] * 10
    bus.sdo_write("drive", 0x6072, 0, "u2", 900)
    assert drained == [7] * 10
    bus._sockets = frozenset()
    bus.to_operational()
    slave.sdo_script = [pysoem.WkcError(wkc=0)] * 10
    with pytest.raises(DriverError, match="in 3 tries"):
        bus.sdo_write("drive", 0x6072, 0, "u2", 900)
    assert len(slave.sdo_script) == 7


def test_rows_of_a_block_go_out_and_come_in_one_cycle_each() -> None:
    bus, master = running(block_capacity=4)
    sent: list[bytes] = []

    def answer(m: ScriptedMaster) -> int:
        sent.append(m.slaves[0].output)
        m.slaves[0].input = np.array([(len(sent), -len(sent))], "<u2,<i4").tobytes()
        m.slaves[1].input = np.int16(100 * len(sent)).tobytes()
        return 3

    master.answer = answer
    bus.outputs["drive"]["60FF:00"][:] = [10, 20, 30, 40]
    exchange = bus.exchange(3)
    assert exchange.n_done == 3
    assert bus.good(exchange).all()
    assert [int.from_bytes(row[2:], "little", signed=True) for row in sent] == [10, 20, 30]
    np.testing.assert_array_equal(bus.inputs["drive"]["6041:00"][:3], [1, 2, 3])
    np.testing.assert_array_equal(bus.inputs["drive"]["6064:00"][:3], [-1, -2, -3])
    np.testing.assert_array_equal(bus.inputs["terminal"]["6000:11"][:3], [100, 200, 300])
    assert np.all(np.diff(exchange.cycle) == 1)


def test_every_working_counter_is_returned() -> None:
    bus, master = running(block_capacity=5)
    script = iter([3, -1, 1, 3, 3])
    master.answer = lambda _: next(script)
    exchange = bus.exchange(5)
    np.testing.assert_array_equal(exchange.wkc, [3, -1, 1, 3, 3])
    np.testing.assert_array_equal(bus.good(exchange), [True, False, False, True, True])


def test_soem_is_asked_even_where_no_frame_came_but_not_kept_waiting() -> None:
    bus, master = running(block_capacity=3)
    assert isinstance(bus._exchanger, CycleExchanger)
    came = iter([True, False, True])
    bus._exchanger.wait = lambda: next(came)
    master.timeouts.clear()
    bus.exchange(3)
    assert master.timeouts == [100, 1, 100]  # what has come is there at once; the patience is spent asleep


def test_what_came_too_late_is_dropped_before_every_frame() -> None:
    # SOEM counts frames modulo 16: left in the socket, an answer 16 cycles old passes for the new one
    bus, master = running(block_capacity=3)
    assert isinstance(bus._exchanger, CycleExchanger)
    order: list[str] = []
    bus._exchanger.drain = lambda: order.append("drop")
    master.answer = lambda _: order.append("answer") or 3
    bus.exchange(3)
    assert order == ["drop", "answer"] * 3


def test_skipped_slots_show_in_the_cycle_number() -> None:
    class Late:
        slots = iter(range(0, 10_000, 3))

        def next_slot(self) -> tuple[int, int]:
            slot = next(self.slots)
            return slot, slot * 500_000

    bus, _ = running(block_capacity=4, pacing=Late())
    exchange = bus.exchange(4)
    np.testing.assert_array_equal(np.diff(exchange.cycle), [3, 3, 3])
    np.testing.assert_array_equal(np.diff(exchange.time_ns), [1_500_000] * 3)


@pytest.mark.parametrize("n", [0, 3, -1])
def test_blocks_that_do_not_fit_are_refused(n: int) -> None:
    bus, _ = running(block_capacity=2)
    with pytest.raises(BusError, match="1 to 2 fit"):
        bus.exchange(n)


def test_exchange_before_configure_is_refused() -> None:
    bus, _ = make()
    with pytest.raises(BusError, match="configure"):
        bus.exchange(1)


def test_missing_interface_and_empty_bus() -> None:
    bus = EtherCatBus(ScriptedMaster(), "missing", (), nonblocking_socket=False)
    with pytest.raises(BusError, match="'missing' cannot be opened; it should exist"):
        bus.open()
    bus = EtherCatBus(ScriptedMaster(), "eth1", (), nonblocking_socket=False)
    bus.open()
    with pytest.raises(BusError, match="no slave answers on 'eth1'"):
        bus.configure()


def test_settings_that_a_slave_refuses_end_configure_and_close_still_brings_init() -> None:
    def refuse(sdo: SdoClient) -> None:
        raise DriverError(f"{sdo.name}: no")

    spec = SlaveSpec("drive", 1, 0xE0, 0x11, DRIVE.rx_pdos, DRIVE.tx_pdos, configure=refuse)
    bus, master = make(spec)
    with pytest.raises(DriverError, match="drive: no"), bus:
        bus.configure()
    assert master.log[-2:] == ["state 1", "close"]


def test_sizes_of_the_device_are_compared_before_a_byte_is_sent() -> None:
    bus, master = make()
    master.slaves[0].output = bytes(7)
    bus.open()
    with pytest.raises(BusError, match="drive maps 7 bytes of outputs but the configuration has 6"):
        bus.configure()


def test_a_slave_that_does_not_say_its_pdos_at_once_is_asked_again() -> None:
    """On a busy host an answer of the mailbox is late, and SOEM maps nothing."""
    bus, master = make()
    master.unmapped = 2
    bus.open()
    bus.configure()
    assert master.unmapped == -1
    bus.to_operational()


def test_a_slave_without_process_data_is_named() -> None:
    bus, master = make()
    master.unmapped = 100
    bus.open()
    with pytest.raises(
        UnmappedError, match="drive has no process data of outputs, the configuration has 6 bytes; it did"
    ):
        bus.configure()
    assert master.unmapped == 97


def test_left_over_packet_errors_of_the_mapping_do_no_harm() -> None:
    bus, master = make()
    master.map_error = pysoem.ConfigMapError([pysoem.PacketError(1, 1)])
    bus.open()
    bus.configure()
    master.map_error = pysoem.ConfigMapError([pysoem.MailboxError(1, 2, "not supported")])
    with pytest.raises(BusError, match="could not be mapped"):
        bus.configure()


def test_a_slave_that_stays_in_safeop_is_named_with_its_al_status() -> None:
    bus, master = make()
    bus.open()
    bus.configure()
    master.refuses[OP] = (SAFEOP | 0x10, 0x001D)
    with pytest.raises(
        BusError, match=r"did not reach OP .*drive \(position 1\) is in SAFEOP.*0x001D \(invalid output"
    ):
        bus.to_operational()
    assert master.cycles < 11_000  # five seconds of cycles
    # It was asked again only after its error had been acknowledged.
    assert SAFEOP | 0x10 in master.slaves[0].requested


def test_watchdog_is_set_read_back_and_compared() -> None:
    spec = SlaveSpec("drive", 1, 0xE0, 0x11, DRIVE.rx_pdos, DRIVE.tx_pdos, watchdog_s=0.02)
    bus, master = make(spec)
    bus.open()
    bus.configure()
    assert master.slaves[0].watchdog_ms == 20.0
    too_long = SlaveSpec("drive", 1, 0xE0, 0x11, DRIVE.rx_pdos, DRIVE.tx_pdos, watchdog_s=10.0)
    bus, _ = make(too_long)
    bus.open()
    with pytest.raises(BusError, match="drive does not take a process data watchdog of 10000 ms"):
        bus.configure()
    bus, master = make(spec)
    master.slaves[0].get_watchdog = lambda _: 100.0  # type: ignore[method-assign]
    bus.open()
    with pytest.raises(BusError, match="keeps a process data watchdog of 100 ms where 20 ms"):
        bus.configure()


def test_nothing_is_written_to_a_slave_without_a_mailbox() -> None:
    def configure(sdo: SdoClient) -> None:
        raise AssertionError("a slave without a mailbox was asked for an object")

    spec = SlaveSpec(
        "stop", 1, 2, 3, (), (Pdo(0x1A00, (Entry("6000:01", "u1"),), True),), configure=configure, coe=False
    )
    bus, master = running(spec)
    assert master.slaves[0].writes == []
    assert master.slaves[0].config_func is None
    assert bus.exchange(1).n_done == 1


def test_sync0_starts_after_cycle_data() -> None:
    spec = SlaveSpec("drive", 1, 0xE0, 0x11, DRIVE.rx_pdos, DRIVE.tx_pdos, sync0_shift_ns=125_000)
    bus, master = make(spec)
    bus.open()
    bus.configure()
    assert master.log[0] == "dc"
    before = master.cycles
    bus.to_operational()
    assert master.slaves[0].sync0 == (True, 500_000, 125_000)
    assert master.cycles > before


def test_recovery_takes_one_step_for_each_slave_and_bounds_itself() -> None:
    restored: list[str] = []
    spec = SlaveSpec(
        "drive", 1, 0xE0, 0x11, DRIVE.rx_pdos, DRIVE.tx_pdos, configure=lambda sdo: restored.append(sdo.name)
    )
    bus, master = running(spec)
    slave = master.slaves[0]
    restored.clear()
    slave.state, slave.recovers = 0, 0
    assert [step.condition for step in bus.recover()] == [Condition.LOST]
    assert slave.is_lost
    slave.recovers = 1
    assert [step.condition for step in bus.recover()] == [Condition.RECONFIGURED]
    assert restored == ["drive"]
    assert not slave.is_lost
    assert [step.condition for step in bus.recover()] == [Condition.SAFE]
    assert [step.condition for step in bus.recover()] == [Condition.OPERATIONAL]
    slave.state, slave.al_status = SAFEOP | 0x10, 0x001B
    step = bus.recover()[0]
    assert step.condition is Condition.ERROR
    assert "0x001B (sync manager watchdog ran out)" in step.text


def test_settings_that_cannot_be_restored_are_not_swallowed() -> None:
    calls: list[int] = []

    def configure(sdo: SdoClient) -> None:
        calls.append(1)
        if len(calls) > 1:
            raise DriverError("drive: torque limit was not taken")

    bus, master = running(SlaveSpec("drive", 1, 0xE0, 0x11, DRIVE.rx_pdos, DRIVE.tx_pdos, configure=configure))
    master.slaves[0].state = PREOP
    with pytest.raises(DriverError, match="torque limit was not taken"):
        bus.recover()


def test_emergencies_are_kept_with_their_sender() -> None:
    bus, master = running()
    master.slaves[0].mailbox = [pysoem.Emergency(1, 0x8611, 0x21, 0x01, 0x0302, 0x0504)]
    master.slaves[1].mailbox = [pysoem.SdoError(2, 0, 0, 0x05040000, "")]
    (message,) = bus.emergencies()
    assert (message.slave, message.code, message.register) == ("drive", 0x8611, 0x21)
    assert message.data == bytes([1, 2, 3, 4, 5])
    assert bus.emergencies() == ()


def test_unknown_slave_names_are_told() -> None:
    bus, _ = running()
    with pytest.raises(BusError, match="'motor' is no configured slave of this bus; it has drive, terminal"):
        bus.sdo("motor")


def test_sdo_through_the_bus() -> None:
    bus, master = running()
    bus.sdo_write("drive", 0x6072, 0, "u2", 1000)
    assert bus.sdo_read("drive", 0x6072, 0, "u2") == 1000
    assert master.slaves[0].get(0x6072, 0, "u2") == 1000


def test_close_closes_though_init_cannot_be_requested() -> None:
    bus, master = running()

    def fail() -> int:
        raise pysoem.WkcError("gone")

    master.write_state = fail  # type: ignore[method-assign]
    with pytest.raises(pysoem.WkcError):
        bus.close()
    assert master.opened is None
