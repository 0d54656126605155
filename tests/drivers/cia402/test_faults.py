import pytest
from canopen.emcy import EmcyError

from drivers.cia402 import describe, describe_emergency
from drivers.cia402.faults import CLASSES, CODES


def test_every_class_that_canopen_knows_has_words_here() -> None:
    for code, _mask, _text in EmcyError.DESCRIPTIONS:
        assert code in CLASSES, hex(code)


def test_every_code_belongs_to_a_class() -> None:
    for code in CODES:
        assert code & 0xFF00 in CLASSES or code & 0xF000 in CLASSES, hex(code)


@pytest.mark.parametrize(
    ("code", "text"),
    [
        (0x8611, "0x8611 (following error)"),
        (0x3220, "0x3220 (DC link under-voltage)"),
        (0x7305, "0x7305 (encoder 1 fault)"),
        (0x2399, "0x2399 (current on the motor side)"),
        (0x1001, "0x1001 (generic error)"),
        (0xFF42, "0xFF42 (specific to the maker)"),
        (0xB000, "0xB000 (unknown class)"),
    ],
)
def test_codes_in_words(code: int, text: str) -> None:
    assert describe(code) == text


def test_emergency_message_in_words() -> None:
    text = describe_emergency(0x8611, 0x21, bytes([1, 2, 3, 4, 5]))
    assert text == "0x8611 (following error), error register generic+profile, maker's data 01 02 03 04 05"
    assert "error register clear" in describe_emergency(0x0000, 0, b"")
