"""SDO transfers over the mailbox protocol, at any mailbox size, and SDO information."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.ethercat.objects import aborts
from fakes.ethercat.objects.dictionary import Entry, record, variable
from fakes.ethercat.objects.identity import Identity
from fakes.ethercat.objects.types import OCTETS, UDINT, UINT
from fakes.ethercat.slaves.slave import Emergency, Slave
from fakes.ethercat.wire.coe import HEADER, CoeServer

CAPACITIES = st.integers(34, 300)
CONTENT = st.binary(max_size=700)


def slave(content=b""):
    return Slave(
        "test",
        Identity(1, 2, "T", "Test", 0),
        [
            variable(0x2000, "any", OCTETS, "rw", content),
            variable(0x2001, "word", UINT, "rw", 0x1234),
            variable(0x2002, "fixed", UDINT, "ro", 5),
            record(0x2003, "pair", Entry("a", UINT, "rw", 1), Entry("b", UDINT, "rw", 2)),
        ],
    )


def exchange(server, body, service=2):
    """Send one CoE message; return (service, body) of its single answer."""
    message = HEADER.pack(len(body) + 2, 0, 0, 3 | 0x10) + struct.pack("<H", service << 12) + body
    (answer,) = server.serve(message)
    assert len(answer) <= server.capacity
    length, _, _, kind = HEADER.unpack_from(answer)
    assert kind & 0x0F == 3
    assert length == len(answer) - HEADER.size
    (number,) = struct.unpack_from("<H", answer, HEADER.size)
    return number >> 12, answer[HEADER.size + 2 :]


def upload(server, index, subindex=0):
    service, body = exchange(server, struct.pack("<BHB4x", 0x40, index, subindex))
    if body[0] == 0x80:
        return int.from_bytes(body[4:8], "little")
    assert service == 3
    if body[0] & 0x02:
        return body[4 : 8 - (body[0] >> 2 & 3)]
    (size,) = struct.unpack_from("<I", body, 4)
    data, toggle = body[8:], 0
    while len(data) < size:
        _, part = exchange(server, bytes([0x60 | toggle]) + bytes(7))
        assert part[0] & 0x10 == toggle
        data += part[1 : len(part) - (part[0] >> 1 & 7)]
        assert bool(part[0] & 0x01) == (len(data) == size)
        toggle ^= 0x10
    assert len(data) == size
    return data


def download(server, index, data, subindex=0):
    """Download, in segments where the mailbox is too small; return the abort code or None."""
    room = server.capacity - HEADER.size - 10
    head = struct.pack("<BHBI", 0x21, index, subindex, len(data))
    _, body = exchange(server, head + data[:room])
    sent, toggle = min(room, len(data)), 0
    while body[0] != 0x80 and sent < len(data):
        part = data[sent : sent + server.capacity - HEADER.size - 3]
        sent += len(part)
        unused = max(0, 7 - len(part))
        command = toggle | unused << 1 | (0x01 if sent == len(data) else 0)
        _, body = exchange(server, bytes([command]) + part.ljust(7, b"\0"))
        if body[0] != 0x80:
            assert body[0] == 0x20 | toggle
        toggle ^= 0x10
    return int.from_bytes(body[4:8], "little") if body[0] == 0x80 else None


@given(CONTENT, CAPACITIES)
def test_upload_brings_every_byte(content, capacity):
    assert upload(CoeServer(slave(content), capacity), 0x2000) == content


@given(CONTENT, CAPACITIES)
def test_download_takes_every_byte(content, capacity):
    made = slave()
    assert download(CoeServer(made, capacity), 0x2000, content) is None
    assert made.dictionary.read(0x2000, 0) == content


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_expedited_download(size):
    made = slave()
    data = bytes(range(1, size + 1))
    command = 0x23 | (4 - size) << 2
    _, body = exchange(CoeServer(made, 128), struct.pack("<BHB", command, 0x2000, 0) + data.ljust(4, b"\0"))
    assert body[0] == 0x60
    assert made.dictionary.read(0x2000, 0) == data


@pytest.mark.parametrize(
    ("body", "code"),
    [
        (struct.pack("<BHB4x", 0x40, 0x3000, 0), aborts.NO_OBJECT),
        (struct.pack("<BHB4x", 0x40, 0x2001, 3), aborts.NO_SUBINDEX),
        (struct.pack("<BHBI", 0x23, 0x2002, 0, 1), aborts.READ_ONLY),
        (struct.pack("<BHBI", 0x23, 0x2001, 0, 1), aborts.TOO_LONG),
        (bytes([0x60]) + bytes(7), aborts.COMMAND),
        (bytes([0x00]) + bytes(7), aborts.COMMAND),
        (bytes([0xE0]) + bytes(7), aborts.COMMAND),
    ],
)
def test_aborts_carry_the_standards_code_in_an_sdo_request(body, code):
    service, answer = exchange(CoeServer(slave(), 128), body)
    assert (service, answer[0], int.from_bytes(answer[4:8], "little")) == (2, 0x80, code)


def test_a_toggle_that_does_not_alternate_ends_the_transfer():
    server = CoeServer(slave(bytes(500)), 64)
    exchange(server, struct.pack("<BHB4x", 0x40, 0x2000, 0))
    exchange(server, bytes([0x60]) + bytes(7))
    _, answer = exchange(server, bytes([0x60]) + bytes(7))
    assert (answer[0], int.from_bytes(answer[4:8], "little")) == (0x80, aborts.TOGGLE)
    assert struct.unpack_from("<HB", answer, 1) == (0x2000, 0)
    assert upload(server, 0x2000) == bytes(500)


def test_a_segmented_download_that_ends_early_changes_nothing():
    made = slave(b"before")
    server = CoeServer(made, 64)
    exchange(server, struct.pack("<BHBI", 0x21, 0x2000, 0, 200) + bytes(48))
    _, answer = exchange(server, bytes([0x01]) + bytes(40))
    assert int.from_bytes(answer[4:8], "little") == aborts.TOO_SHORT
    assert made.dictionary.read(0x2000, 0) == b"before"


def test_an_abort_by_the_master_has_no_answer():
    server = CoeServer(slave(bytes(500)), 64)
    exchange(server, struct.pack("<BHB4x", 0x40, 0x2000, 0))
    message = HEADER.pack(10, 0, 0, 3) + struct.pack("<HBHBI", 0x2000, 0x80, 0x2000, 0, aborts.TIMEOUT)
    assert server.serve(message) == []
    assert upload(server, 0x2001) == b"\x34\x12"


@pytest.mark.parametrize(("kind", "code"), [(2, 0x0002), (4, 0x0002), (15, 0x0002)])
def test_other_mailbox_protocols_are_refused(kind, code):
    (answer,) = CoeServer(slave(), 64).serve(HEADER.pack(10, 0, 0, kind) + bytes(10))
    assert answer[5] & 0x0F == 0
    assert struct.unpack_from("<HH", answer, HEADER.size) == (1, code)


def test_mailbox_counter_runs_from_one_to_seven():
    server = CoeServer(slave(), 64)
    message = HEADER.pack(10, 0, 0, 3) + struct.pack("<HBHB4x", 0x2000, 0x40, 0x2001, 0)
    assert [server.serve(message)[0][5] >> 4 for _ in range(9)] == [1, 2, 3, 4, 5, 6, 7, 1, 2]


def test_emergency_message():
    made = slave()
    made.emergencies.append(Emergency(0x3210, 0x05, b"\x01\x02\x03\x04\x05"))
    server = CoeServer(made, 64)
    message = server.emergency()
    assert message[HEADER.size :] == bytes.fromhex("00101032050102030405")
    assert server.emergency() is None


class TestInformation:
    def ask(self, body, capacity=128):
        server = CoeServer(slave(), capacity)
        message = HEADER.pack(len(body) + 2, 0, 0, 3) + struct.pack("<H", 8 << 12) + body
        parts = [answer[HEADER.size + 2 :] for answer in server.serve(message)]
        assert [struct.unpack_from("<H", p, 2)[0] for p in parts] == list(range(len(parts) - 1, -1, -1))
        assert all(bool(p[0] & 0x80) == (i < len(parts) - 1) for i, p in enumerate(parts))
        return parts[0][0] & 0x7F, b"".join(p[4:] for p in parts)

    @pytest.mark.parametrize("capacity", [34, 64, 256])
    def test_list_of_all_objects(self, capacity):
        opcode, data = self.ask(struct.pack("<BBHH", 1, 0, 0, 1), capacity)
        assert opcode == 2
        assert struct.unpack(f"<{len(data) // 2}H", data) == (1, 0x2000, 0x2001, 0x2002, 0x2003)

    def test_lengths_of_lists(self):
        _, data = self.ask(struct.pack("<BBHH", 1, 0, 0, 0))
        assert struct.unpack("<6H", data)[:2] == (0, 4)

    def test_object_and_entry(self):
        opcode, data = self.ask(struct.pack("<BBHH", 3, 0, 0, 0x2003))
        assert opcode == 4
        assert struct.unpack_from("<HHBB", data) == (0x2003, UDINT.code, 2, 9)
        assert data[6:] == b"pair"
        opcode, data = self.ask(struct.pack("<BBHHBB", 5, 0, 0, 0x2003, 2, 7))
        assert opcode == 6
        assert struct.unpack_from("<HBBHHH", data) == (0x2003, 2, 7, UDINT.code, 32, 0x3F)
        assert data[10:] == b"b"

    @pytest.mark.parametrize(
        "body", [struct.pack("<BBHH", 3, 0, 0, 0x3000), struct.pack("<BBHH", 9, 0, 0, 0), b"\x03\0\0\0"]
    )
    def test_errors(self, body):
        opcode, data = self.ask(body)
        assert opcode == 7
        assert int.from_bytes(data, "little") in aborts.TEXT
