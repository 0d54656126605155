"""Object dictionary: access rules, limits, complete access, PDO configuration."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.ethercat.objects import aborts, types
from fakes.ethercat.objects.aborts import SdoAbort
from fakes.ethercat.objects.dictionary import Entry, ObjectDictionary, array, record, sparse_record, variable
from fakes.ethercat.objects.pdo import RX_ASSIGN, TX_ASSIGN
from fakes.ethercat.objects.types import DINT, STRING, UDINT, UINT, USINT
from tests.fakes.ethercat.simple_plant import simple_bench

SAFEOP = 4


def dictionary():
    return ObjectDictionary(
        [
            variable(0x2000, "limited", DINT, "rw", 5, "", -10, 10),
            variable(0x2001, "secret", UINT, "wo", 0),
            variable(0x2002, "fixed", UINT, "ro", 7),
            variable(0x2003, "text", STRING, "rw", b"abc"),
            variable(0x2004, "early", UINT, "rwpre", 1),
            record(0x2010, "pair", Entry("a", UINT, "rw", 1), Entry("b", UDINT, "rw", 2)),
            array(0x2011, "list", UINT, (1, 2), "rw", capacity=4),
            sparse_record(0x2012, "sparse", {1: Entry("a", USINT), 0x11: Entry("b", USINT, "ro", 9)}),
        ]
    )


def refused(do):
    with pytest.raises(SdoAbort) as caught:
        do()
    return caught.value.code


@pytest.mark.parametrize(
    ("index", "subindex", "code"),
    [(0x1FFF, 0, aborts.NO_OBJECT), (0x2000, 1, aborts.NO_SUBINDEX), (0x2001, 0, aborts.WRITE_ONLY)],
)
def test_reading_is_refused(index, subindex, code):
    assert refused(lambda: dictionary().read(index, subindex)) == code


@pytest.mark.parametrize(
    ("index", "data", "state", "code"),
    [
        (0x1FFF, b"\0\0", 2, aborts.NO_OBJECT),
        (0x2002, b"\0\0", 2, aborts.READ_ONLY),
        (0x2000, b"\0\0", 2, aborts.TOO_SHORT),
        (0x2000, bytes(5), 2, aborts.TOO_LONG),
        (0x2000, (11).to_bytes(4, "little"), 2, aborts.TOO_HIGH),
        (0x2000, (-11).to_bytes(4, "little", signed=True), 2, aborts.TOO_LOW),
        (0x2004, b"\0\0", SAFEOP, aborts.WRONG_STATE),
    ],
)
def test_writing_is_refused_and_changes_nothing(index, data, state, code):
    d = dictionary()
    before = dict(d.values)
    assert refused(lambda: d.write(index, 0, data, state)) == code
    assert d.values == before


@given(st.sampled_from([t for t in vars(types).values() if isinstance(t, types.DataType) and t.bits]), st.data())
def test_values_come_back_as_they_went_in(kind, data):
    raw = data.draw(st.binary(min_size=kind.bits // 8, max_size=kind.bits // 8))
    d = ObjectDictionary([variable(0x2000, "any", kind, "rw", kind.decode(bytes(kind.bits // 8)))])
    d.write(0x2000, 0, raw)
    assert d.read(0x2000, 0) == kind.encode(kind.decode(raw))


@given(st.binary(max_size=300))
def test_strings_keep_their_length(raw):
    d = dictionary()
    d.write(0x2003, 0, raw)
    assert d.read(0x2003, 0) == raw


def test_complete_access_widens_subindex_zero():
    d = dictionary()
    assert d.read_complete(0x2010, 0) == b"\x02\x00" + b"\x01\x00" + b"\x02\x00\x00\x00"
    assert d.read_complete(0x2010, 1) == b"\x01\x00" + b"\x02\x00\x00\x00"
    d.write_complete(0x2010, 1, b"\x05\x00\x06\x00\x00\x00")
    assert (d.integer(0x2010, 1), d.integer(0x2010, 2)) == (5, 6)
    assert refused(lambda: d.read_complete(0x2000, 0)) == aborts.NO_COMPLETE_ACCESS
    assert refused(lambda: d.write_complete(0x2010, 1, b"\x05")) == aborts.TOO_SHORT
    assert refused(lambda: d.write_complete(0x2010, 1, bytes(7))) == aborts.TOO_LONG


def test_complete_access_resizes_a_list():
    d = dictionary()
    d.write_complete(0x2011, 0, b"\x03\x00" + b"\x07\x00\x08\x00\x09\x00")
    assert d.read_complete(0x2011, 0) == b"\x03\x00" + b"\x07\x00\x08\x00\x09\x00"
    assert refused(lambda: d.write_complete(0x2011, 0, b"\x05\x00" + bytes(10))) == aborts.TOO_LONG


def test_reset_brings_defaults_back():
    d = dictionary()
    d.write(0x2000, 0, (-3).to_bytes(4, "little", signed=True))
    d.reset()
    assert d.integer(0x2000) == 5


class TestPdoConfiguration:
    """0x1C12/0x1C13 and the mapping objects of a drive."""

    @pytest.fixture
    def drive(self):
        return simple_bench().slaves[0]

    def word(self, index, subindex, bits):
        return (index << 16 | subindex << 8 | bits).to_bytes(4, "little")

    def test_default_image(self, drive):
        assert drive.layout(RX_ASSIGN).names == ("6040:00", "60FF:00", "6071:00", "6060:00")
        assert (drive.layout(RX_ASSIGN).size, drive.layout(TX_ASSIGN).size) == (9, 15)

    def test_mapping_is_locked_while_it_counts(self, drive):
        d = drive.dictionary
        assert refused(lambda: d.write(0x1600, 1, self.word(0x6040, 0, 16))) == aborts.SUBINDEX_ZERO
        assert refused(lambda: d.write(0x1600, 0, b"\0", SAFEOP)) == aborts.WRONG_STATE

    @pytest.mark.parametrize(
        ("word", "code"),
        [
            ((0x6041, 0, 16), aborts.NOT_MAPPABLE),
            ((0x6040, 0, 32), aborts.NOT_MAPPABLE),
            ((0x6040, 0, 4), aborts.NOT_MAPPABLE),
            ((0x5FFF, 0, 16), aborts.NO_OBJECT),
            ((0x6040, 1, 16), aborts.NO_SUBINDEX),
        ],
    )
    def test_what_cannot_be_mapped(self, drive, word, code):
        d = drive.dictionary
        d.write(0x1600, 0, b"\0")
        d.write(0x1600, 1, self.word(*word))
        assert refused(lambda: d.write(0x1600, 0, b"\x01")) == code

    def test_padding_takes_room_without_a_name(self, drive):
        d = drive.dictionary
        d.write(0x1A00, 0, b"\0")
        d.write(0x1A00, 1, self.word(0x6041, 0, 16))
        d.write(0x1A00, 2, self.word(0, 0, 16))
        d.write(0x1A00, 3, self.word(0x6064, 0, 32))
        d.write(0x1A00, 0, b"\x03")
        layout = drive.layout(TX_ASSIGN)
        assert layout.names == ("6041:00", "6064:00")
        assert layout.size == 8
        assert layout.dtype.fields["6064:00"][1] == 4

    def test_two_pdos_follow_each_other(self, drive):
        d = drive.dictionary
        d.write(0x1C12, 0, b"\0")
        d.write(0x1601, 0, b"\0")
        d.write(0x1601, 1, self.word(0x60FF, 0, 32))
        d.write(0x1601, 0, b"\x01")
        d.write(0x1600, 0, b"\x01")
        for i, pdo in enumerate((0x1600, 0x1601), start=1):
            d.write(0x1C12, i, pdo.to_bytes(2, "little"))
        d.write(0x1C12, 0, b"\x02")
        assert drive.layout(RX_ASSIGN).names == ("6040:00", "60FF:00")

    @pytest.mark.parametrize("pdo", [0x1A00, 0x1700, 0x6040])
    def test_assignment_of_what_is_no_rxpdo(self, drive, pdo):
        d = drive.dictionary
        d.write(0x1C12, 0, b"\0")
        d.write(0x1C12, 1, pdo.to_bytes(2, "little"))
        assert refused(lambda: d.write(0x1C12, 0, b"\x01")) == aborts.RANGE

    def test_terminals_have_fixed_mappings(self):
        terminal = simple_bench().slaves[2]
        assert refused(lambda: terminal.dictionary.write(0x1A00, 0, b"\0")) == aborts.READ_ONLY
