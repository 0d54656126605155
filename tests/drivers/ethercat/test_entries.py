import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.entries import TYPES, Entry, entries_dtype, entry_name
from drivers.errors import DriverError


def test_mapping_word_of_the_standard_example() -> None:
    assert Entry("6041:00", "u2").mapping == 0x60410010
    assert Entry("6064:00", "i4").mapping == 0x60640020
    assert Entry("6000:11", "i2").mapping == 0x60001110


@given(st.integers(0, 0xFFFF), st.integers(0, 0xFF), st.sampled_from(sorted(TYPES)))
def test_names_are_addresses_and_back(index: int, subindex: int, type_: str) -> None:
    entry = Entry(entry_name(index, subindex), type_)
    assert (entry.index, entry.subindex) == (index, subindex)
    assert entry.mapping & 0xFF == 8 * np.dtype(TYPES[type_]).itemsize


@pytest.mark.parametrize(
    "name", ["6041", "60410:00", "zz:00", "6041:100", "6041-00", ":", "-1:00", "6041:0", "606c:00"]
)
def test_malformed_names_are_refused_with_a_sentence(name: str) -> None:
    with pytest.raises(DriverError, match=r"is right|should be written"):
        Entry(name, "u2")


def test_unknown_type_names_those_that_are() -> None:
    with pytest.raises(DriverError, match="unknown type 'u3'; one of u1"):
        Entry("6041:00", "u3")


def test_images_are_packed_little_endian() -> None:
    dtype = entries_dtype([Entry("6040:00", "u2"), Entry("6060:00", "i1"), Entry("60FF:00", "i4")])
    image = np.zeros((), dtype)
    image["6040:00"], image["6060:00"], image["60FF:00"] = 0x0102, -1, 0x03040506
    assert image.tobytes() == bytes([0x02, 0x01, 0xFF, 0x06, 0x05, 0x04, 0x03])


def test_an_entry_may_stand_once() -> None:
    with pytest.raises(DriverError, match="'6041:00' is mapped twice"):
        entries_dtype([Entry("6041:00", "u2"), Entry("6041:00", "u2")])
