"""SDO abort codes (ETG.1000.6 table 41, CiA 301 table 22)."""

from __future__ import annotations

TOGGLE = 0x05030000
TIMEOUT = 0x05040000
COMMAND = 0x05040001
MEMORY = 0x05040005
ACCESS = 0x06010000
WRITE_ONLY = 0x06010001
READ_ONLY = 0x06010002
SUBINDEX_ZERO = 0x06010003
NO_COMPLETE_ACCESS = 0x06010004
NO_OBJECT = 0x06020000
NOT_MAPPABLE = 0x06040041
MAPPING_TOO_LONG = 0x06040042
INCOMPATIBLE = 0x06040043
LENGTH = 0x06070010
TOO_LONG = 0x06070012
TOO_SHORT = 0x06070013
NO_SUBINDEX = 0x06090011
RANGE = 0x06090030
TOO_HIGH = 0x06090031
TOO_LOW = 0x06090032
STORE = 0x08000020
LOCAL_CONTROL = 0x08000021
WRONG_STATE = 0x08000022
NO_DICTIONARY = 0x08000023

TEXT: dict[int, str] = {
    TOGGLE: "toggle bit did not alternate",
    TIMEOUT: "transfer timed out",
    COMMAND: "unknown command specifier",
    MEMORY: "no memory left",
    ACCESS: "access not supported",
    WRITE_ONLY: "object is write-only",
    READ_ONLY: "object is read-only",
    SUBINDEX_ZERO: "subindex 0 must be 0 before this one is written",
    NO_COMPLETE_ACCESS: "no complete access to this object",
    NO_OBJECT: "no such object",
    NOT_MAPPABLE: "object cannot be mapped",
    MAPPING_TOO_LONG: "mapping exceeds the PDO",
    INCOMPATIBLE: "parameters do not fit together",
    LENGTH: "length does not fit the data type",
    TOO_LONG: "more data than the data type holds",
    TOO_SHORT: "less data than the data type needs",
    NO_SUBINDEX: "no such subindex",
    RANGE: "value out of range",
    TOO_HIGH: "value above its upper limit",
    TOO_LOW: "value below its lower limit",
    STORE: "value cannot be taken over",
    LOCAL_CONTROL: "value is under local control",
    WRONG_STATE: "not possible in the present state of the device",
    NO_DICTIONARY: "no object dictionary",
}
"""What each code says, for messages of our own (only codes travel on the bus)."""


class SdoAbort(Exception):
    """An SDO request the slave refuses; the server turns it into an abort response."""

    def __init__(self, code: int) -> None:
        super().__init__(f"0x{code:08X} {TEXT.get(code, 'unknown')}")
        self.code = code
