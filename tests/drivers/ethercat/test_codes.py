import pysoem
import pytest
from canopen.sdo.exceptions import SdoAbortedError

from drivers.ethercat import codes


def test_every_al_status_code_that_soem_knows_is_in_the_table() -> None:
    known = {code for code in range(0x100) if pysoem.al_status_code_to_string(code) != "Unknown"}
    assert len(known) > 40
    assert known - set(codes.AL_STATUS) == set()


def test_every_abort_code_that_canopen_knows_is_in_the_table() -> None:
    # 0x05040004 is "CRC error" in both.
    assert set(SdoAbortedError.CODES) - set(codes.SDO_ABORT) == set()


@pytest.mark.parametrize(
    ("code", "text"),
    [
        (0x001B, "0x001B (sync manager watchdog ran out)"),
        (0x8123, "0x8123 (vendor specific)"),
        (0x00EE, "0x00EE (unknown code)"),
    ],
)
def test_al_status_in_words(code: int, text: str) -> None:
    assert codes.al_status_text(code) == text


@pytest.mark.parametrize(
    ("state", "text"), [(0x14, "SAFEOP with error"), (0x08, "OP"), (0x00, "no state"), (0x05, "state 0x5")]
)
def test_states_in_words(state: int, text: str) -> None:
    assert codes.state_text(state) == text


def test_sdo_and_mailbox_codes_in_words() -> None:
    assert codes.sdo_abort_text(0x06090030) == "0x06090030 (value is out of range)"
    assert codes.sdo_abort_text(0x12345678) == "0x12345678 (unknown code)"
    assert "CoE firmware" in codes.mailbox_error_text(2)
