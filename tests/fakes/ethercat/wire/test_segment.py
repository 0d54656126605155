"""Datagrams against a line of controllers: addressing, working counters, registers, mailbox handshake, FMMUs."""

from __future__ import annotations

import struct
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fakes.ethercat.wire import registers as reg
from fakes.ethercat.wire import segment as seg
from fakes.ethercat.wire.esc import SlaveController
from fakes.ethercat.wire.segment import Segment
from tests.fakes.ethercat.simple_plant import simple_bench


@pytest.fixture
def line():
    return Segment([SlaveController(slave) for slave in simple_bench().slaves])


def frame(*datagrams):
    """Return an EtherCAT frame of (command, address, offset, data) datagrams."""
    body = b""
    for i, (command, address, offset, data) in enumerate(datagrams):
        more = 0x8000 if i < len(datagrams) - 1 else 0
        body += seg.DATAGRAM.pack(command, i, address, offset, len(data) | more, 0) + data + b"\0\0"
    head = b"\xff" * 6 + b"\x01" * 6 + b"\x88\xa4" + struct.pack("<H", len(body) | 0x1000)
    return bytearray((head + body).ljust(60, b"\0"))


def send(line, command, address, offset, data):
    """Send one datagram; return (data, working counter, address as it came back)."""
    sent = frame((command, address, offset, data))
    assert line.serve(sent, len(sent))
    at = seg.ETHERNET + 2 + seg.DATAGRAM.size
    counter = int.from_bytes(sent[at + len(data) : at + len(data) + 2], "little")
    return bytes(sent[at : at + len(data)]), counter, int.from_bytes(sent[18:20], "little")


def test_auto_increment_meets_the_slave_that_sees_zero(line):
    for position in range(4):
        address = -position & 0xFFFF
        send(line, seg.APWR, address, reg.STATION_ADDRESS, (1001 + position).to_bytes(2, "little"))
        data, counter, back = send(line, seg.APRD, address, reg.STATION_ADDRESS, b"\0\0")
        assert (int.from_bytes(data, "little"), counter) == (1001 + position, 1)
        assert back == (address + 4) & 0xFFFF
    assert send(line, seg.APRD, -4 & 0xFFFF, 0, b"\0\0")[1] == 0


def test_configured_address(line):
    send(line, seg.APWR, -2 & 0xFFFF, reg.STATION_ADDRESS, b"\x11\x22")
    assert send(line, seg.FPRD, 0x2211, reg.STATION_ADDRESS, b"\0\0")[:2] == (b"\x11\x22", 1)
    assert send(line, seg.FPRD, 0x1111, reg.STATION_ADDRESS, b"\0\0")[1] == 0


def test_alias_counts_only_when_enabled(line):
    line.all[1].memory[reg.STATION_ALIAS : reg.STATION_ALIAS + 2] = b"\x55\x00"
    assert send(line, seg.FPRD, 0x55, 0, b"\0")[1] == 0
    send(line, seg.APWR, -1 & 0xFFFF, reg.DL_CONTROL, b"\x01\x00\x07\x01")
    assert send(line, seg.FPRD, 0x55, 0, b"\0")[1] == 1


def test_broadcast_read_ors_and_counts(line):
    for position, bits in enumerate((0x01, 0x02, 0x04, 0x08)):
        send(line, seg.APWR, -position & 0xFFFF, reg.EVENT_MASK, bytes([bits, 0]))
    assert send(line, seg.BRD, 0, reg.EVENT_MASK, b"\0\0") == (b"\x0f\x00", 4, 4)
    assert send(line, seg.BWR, 0, reg.EVENT_MASK, b"\x21\x00")[1] == 4
    assert send(line, seg.BRD, 0, reg.EVENT_MASK, b"\0\0")[0] == b"\x21\x00"


@pytest.mark.parametrize(("command", "gain"), [(seg.APRW, 3), (seg.BRW, 12)])
def test_read_write_counts_one_and_two(line, command, gain):
    assert send(line, command, 0, reg.EVENT_MASK, b"\x02\x00")[1] == gain
    assert line.all[0].memory[reg.EVENT_MASK] == 0x02


def test_read_multiple_write_spreads_the_system_time(line):
    data, counter, _ = send(line, seg.ARMW, 0, reg.DC_SYSTEM_TIME, bytes(8))
    assert counter == 4
    assert int.from_bytes(data, "little") > 0


def test_read_multiple_write_of_an_ordinary_register(line):
    send(line, seg.APWR, -1 & 0xFFFF, reg.EVENT_MASK, b"\x77\x00")
    _, counter, _ = send(line, seg.ARMW, -1 & 0xFFFF, reg.EVENT_MASK, b"\x11\x00")
    assert counter == 4
    assert [c.memory[reg.EVENT_MASK] for c in line.all] == [0x11, 0x77, 0x77, 0x77]


def test_nop_passes_untouched(line):
    assert send(line, seg.NOP, 0x1234, 0x5678, b"\xaa\xbb") == (b"\xaa\xbb", 0, 0x1234)


def test_several_datagrams_in_a_frame(line):
    sent = frame((seg.BRD, 0, 0, b"\0\0"), (seg.APRD, 0, reg.AL_STATUS, b"\0\0"))
    assert line.serve(sent, len(sent))
    assert sent[28] == 4
    assert sent[42] == 1


def test_source_address_is_marked(line):
    sent = frame((seg.BRD, 0, 0, b"\0\0"))
    line.serve(sent, len(sent))
    assert sent[6] == 0x03


@settings(max_examples=100)
@given(st.binary(max_size=120))
def test_any_frame_is_answered_or_refused_but_never_breaks(raw):
    line = Segment([SlaveController(slave) for slave in simple_bench().slaves[2:3]])
    sent = bytearray(b"\xff" * 12 + b"\x88\xa4" + raw)
    length = len(sent)
    assert line.serve(sent, length) in (True, False)
    assert len(sent) == length


def test_read_only_registers_stay(line):
    before = bytes(line.all[0].memory[0:0x0A])
    assert send(line, seg.APWR, 0, 0x0000, b"\xff" * 10)[1] == 1
    assert bytes(line.all[0].memory[0:0x0A]) == before


def test_dl_status_shows_the_line(line):
    ports = [int.from_bytes(c.memory[reg.DL_STATUS : reg.DL_STATUS + 2], "little") for c in line.all]
    assert [bool(p & 0x0200) for p in ports] == [True] * 4
    assert [bool(p & 0x0800) for p in ports] == [True, True, True, False]
    line.arrange(line.all[:2])
    assert not line.all[1].memory[reg.DL_STATUS + 1] & 0x08


def test_receive_times_show_the_line(line):
    """Delay between neighbours: half the difference of what the ports saw (ETG.1000.4 §9)."""
    send(line, seg.BWR, 0, reg.DC_RECEIVE, bytes(4))
    there_and_back = []
    for controller in line.all[:3]:
        out, back = struct.unpack_from("<2I", controller.memory, reg.DC_RECEIVE)
        there_and_back.append((back - out) & 0xFFFFFFFF)
    assert [a - b for a, b in pairwise(there_and_back)] == [1000, 1000]


class TestMailbox:
    def prepare(self, line):
        send(line, seg.APWR, 0, reg.SYNC_MANAGER, struct.pack("<HHBBBB", 0x1000, 64, 0x26, 0, 1, 0))
        send(line, seg.APWR, 0, reg.SYNC_MANAGER + 8, struct.pack("<HHBBBB", 0x1200, 64, 0x22, 0, 1, 0))
        return struct.pack("<HHBBHBHB4x", 10, 0, 0, 3, 0x2000, 0x40, 0x1000, 0).ljust(64, b"\0")

    def status(self, line):
        return send(line, seg.APRD, 0, reg.SYNC_MANAGER + 8 + 5, b"\0")[0][0] & reg.MAILBOX_FULL

    def test_handshake(self, line):
        request = self.prepare(line)
        assert send(line, seg.APRD, 0, 0x1200, bytes(64))[1] == 0
        assert not self.status(line)
        assert send(line, seg.APWR, 0, 0x1000, request)[1] == 1
        assert self.status(line)
        answer, counter, _ = send(line, seg.APRD, 0, 0x1200, bytes(64))
        assert (counter, answer[8]) == (1, 0x43)
        assert not self.status(line)
        assert send(line, seg.APRD, 0, 0x1200, bytes(64))[1] == 0

    def test_an_answer_lost_on_the_way_is_repeated_on_request(self, line):
        request = self.prepare(line)
        send(line, seg.APWR, 0, 0x1000, request)
        first = send(line, seg.APRD, 0, 0x1200, bytes(64))[0]
        send(line, seg.APWR, 0, reg.SYNC_MANAGER + 8 + 6, b"\x03")
        assert send(line, seg.APRD, 0, reg.SYNC_MANAGER + 8 + 7, b"\0")[0][0] & 0x02
        again, counter, _ = send(line, seg.APRD, 0, 0x1200, bytes(64))
        assert (again, counter) == (first, 1)

    def test_a_request_sent_twice_is_served_once(self, line):
        """A master that sends a late frame again uses the same counter; the next counter is a new request."""
        for counter, answers in ((0x13, 1), (0x13, 0), (0x23, 1), (0x03, 1), (0x03, 1)):
            request = bytearray(self.prepare(line))
            request[5] = counter
            assert send(line, seg.APWR, 0, 0x1000, bytes(request))[1] == 1
            assert send(line, seg.APRD, 0, 0x1200, bytes(64))[1] == answers
            assert not self.status(line)

    def test_half_a_request_is_not_served(self, line):
        request = self.prepare(line)
        send(line, seg.APWR, 0, 0x1000, request[:32])
        assert not self.status(line)


class TestLogical:
    def fmmu(self, logical, length, first, last, physical, physical_first, kind):
        return struct.pack("<IHBBHBBB3x", logical, length, first, last, physical, physical_first, kind, 1)

    def operational(self, line):
        for controller in line.all:
            controller.slave.al.state = 8

    def test_slices_and_counters(self, line):
        self.operational(line)
        for position in (0, 1):
            address = -position & 0xFFFF
            send(line, seg.APWR, address, reg.FMMU, self.fmmu(0x10000 + 4 * position, 4, 0, 7, 0x1400, 0, 2))
            send(line, seg.APWR, address, reg.FMMU + 16, self.fmmu(0x10008 + 4 * position, 4, 0, 7, 0x1A00, 0, 1))
            line.all[position].memory[0x1A00:0x1A04] = bytes([position + 1] * 4)
        data, counter, _ = send(line, seg.LRW, 0, 1, bytes(range(8)) + bytes(8))
        assert counter == 6
        assert data[8:] == b"\x01" * 4 + b"\x02" * 4
        assert line.all[0].memory[0x1400:0x1404] == bytes(range(4))
        assert line.all[1].memory[0x1400:0x1404] == bytes(range(4, 8))
        assert send(line, seg.LRD, 0, 1, bytes(16))[1] == 2
        assert send(line, seg.LWR, 0, 1, bytes(16))[1] == 2
        assert send(line, seg.LRD, 4, 1, bytes(2))[1] == 0

    def test_a_part_of_what_is_mapped(self, line):
        self.operational(line)
        send(line, seg.APWR, 0, reg.FMMU, self.fmmu(0x10000, 8, 0, 7, 0x1A00, 0, 1))
        line.all[0].memory[0x1A00:0x1A08] = bytes(range(8))
        assert send(line, seg.LRD, 2, 1, bytes(3)) == (b"\x02\x03\x04", 1, 2)

    def test_single_bits_and_registers(self, line):
        send(line, seg.APWR, 0, reg.FMMU, self.fmmu(0x10000, 1, 2, 2, reg.SYNC_MANAGER + 8 + 5, 3, 1))
        line.all[0].memory[reg.SYNC_MANAGER + 8 + 5] = 0x08
        assert send(line, seg.LRD, 0, 1, b"\xf0") == (b"\xf4", 1, 0)
        line.all[0].memory[reg.SYNC_MANAGER + 8 + 5] = 0x00
        assert send(line, seg.LRD, 0, 1, b"\xff")[0] == b"\xfb"

    def test_slaves_outside_safe_operational_do_not_take_part(self, line):
        send(line, seg.APWR, 0, reg.FMMU, self.fmmu(0x10000, 4, 0, 7, 0x1400, 0, 2))
        assert send(line, seg.LRW, 0, 1, bytes(4))[1] == 0
