"""Codes a slave answers with, in words: SDO aborts, AL status, mailbox errors."""

from __future__ import annotations

SDO_ABORT: dict[int, str] = {
    0x05030000: "toggle bit did not alternate",
    0x05040000: "SDO protocol timed out",
    0x05040001: "command specifier is not valid or not known",
    0x05040002: "invalid block size",
    0x05040003: "invalid sequence number",
    0x05040004: "CRC error",
    0x05040005: "out of memory",
    0x06010000: "access to this object is not supported",
    0x06010001: "object is write-only",
    0x06010002: "object is read-only",
    0x06010003: "subindex cannot be written unless subindex 0 is 0",
    0x06010004: "complete access is not supported for this object",
    0x06010005: "object is longer than the mailbox",
    0x06010006: "object is mapped to an RxPDO and not writable by SDO",
    0x06020000: "object does not exist",
    0x06040041: "object cannot be mapped into a PDO",
    0x06040042: "mapped objects would exceed the length of the PDO",
    0x06040043: "parameters are incompatible",
    0x06040047: "incompatibility inside the device",
    0x06060000: "hardware error",
    0x06070010: "length does not match the object",
    0x06070012: "value is too long for the object",
    0x06070013: "value is too short for the object",
    0x06090011: "subindex does not exist",
    0x06090030: "value is out of range",
    0x06090031: "value is too high",
    0x06090032: "value is too low",
    0x06090036: "maximum is below minimum",
    0x060A0023: "resource (SDO connection) is not available",
    0x08000000: "general error",
    0x08000020: "data cannot be transferred or stored",
    0x08000021: "data cannot be transferred or stored because of local control",
    0x08000022: "data cannot be transferred or stored in the present state of the device",
    0x08000023: "object dictionary is missing or could not be generated",
    0x08000024: "no data available",
}
"""SDO abort codes (CiA 301 table 22, ETG.1000.6 table 41)."""

AL_STATUS: dict[int, str] = {
    0x0000: "no error",
    0x0001: "unspecified error",
    0x0002: "no memory",
    0x0003: "invalid device setup",
    0x0004: "invalid revision",
    0x0006: "SII does not match the firmware",
    0x0007: "firmware update failed",
    0x000E: "licence error",
    0x0011: "requested state change is not valid",
    0x0012: "requested state is unknown",
    0x0013: "bootstrap is not supported",
    0x0014: "no valid firmware",
    0x0015: "invalid mailbox configuration (BOOT)",
    0x0016: "invalid mailbox configuration (PREOP)",
    0x0017: "invalid sync manager configuration",
    0x0018: "no valid inputs available",
    0x0019: "no valid outputs received",
    0x001A: "synchronisation error",
    0x001B: "sync manager watchdog ran out",
    0x001C: "invalid sync manager types",
    0x001D: "invalid output configuration: the length of the RxPDOs is not what the slave expects",
    0x001E: "invalid input configuration: the length of the TxPDOs is not what the slave expects",
    0x001F: "invalid watchdog configuration",
    0x0020: "slave needs a cold start",
    0x0021: "slave needs INIT",
    0x0022: "slave needs PREOP",
    0x0023: "slave needs SAFEOP",
    0x0024: "invalid input mapping",
    0x0025: "invalid output mapping",
    0x0026: "settings are inconsistent",
    0x0027: "free run is not supported",
    0x0028: "synchronous mode is not supported",
    0x0029: "free run needs three-buffer mode",
    0x002A: "background watchdog ran out",
    0x002B: "no valid inputs and outputs",
    0x002C: "fatal synchronisation error",
    0x002D: "no SYNC signal received",
    0x002E: "cycle time is too small",
    0x0030: "invalid distributed clocks configuration (SYNC)",
    0x0031: "invalid distributed clocks configuration (latch)",
    0x0032: "PLL is not locked",
    0x0033: "input or output error under distributed clocks",
    0x0034: "SYNC signal timed out",
    0x0035: "invalid SYNC cycle time",
    0x0036: "invalid SYNC0 cycle time",
    0x0037: "invalid SYNC1 cycle time",
    0x0041: "AoE mailbox error",
    0x0042: "EoE mailbox error",
    0x0043: "CoE mailbox error",
    0x0044: "FoE mailbox error",
    0x0045: "SoE mailbox error",
    0x004F: "VoE mailbox error",
    0x0050: "EEPROM cannot be accessed",
    0x0051: "EEPROM error",
    0x0052: "external hardware is not ready",
    0x0060: "slave restarted by itself",
    0x0061: "device identification was changed",
    0x0070: "detected modules do not match the configured ones",
    0x0080: "supply voltage too low",
    0x0081: "supply voltage too high",
    0x0082: "temperature too low",
    0x0083: "temperature too high",
    0x00F0: "application controller is available",
}
"""AL status codes (ETG.1000.6 table 11, ETG.1020), register 0x0134."""

MAILBOX_ERROR: dict[int, str] = {
    0x0001: "mailbox header has a wrong syntax",
    0x0002: "mailbox protocol is not supported (CoE firmware is needed)",
    0x0003: "channel field is wrong",
    0x0004: "service is not supported",
    0x0005: "mailbox header is invalid",
    0x0006: "mailbox data is too short",
    0x0007: "slave has no memory left",
    0x0008: "lengths are inconsistent",
}
"""Mailbox error codes (ETG.1000.4, mailbox error service)."""

_STATES = {0x00: "no state", 0x01: "INIT", 0x02: "PREOP", 0x03: "BOOT", 0x04: "SAFEOP", 0x08: "OP"}


def al_status_text(code: int) -> str:
    """AL status code with its meaning, such as ``0x001B (sync manager watchdog ran out)``."""
    default = "vendor specific" if code >= 0x8000 else "unknown code"
    return f"0x{code:04X} ({AL_STATUS.get(code, default)})"


def sdo_abort_text(code: int) -> str:
    """SDO abort code with its meaning."""
    return f"0x{code:08X} ({SDO_ABORT.get(code, 'unknown code')})"


def mailbox_error_text(code: int) -> str:
    """Mailbox error code with its meaning."""
    return f"0x{code:04X} ({MAILBOX_ERROR.get(code, 'unknown code')})"


def state_text(state: int) -> str:
    """AL state in words, ``SAFEOP with error`` where the error flag (bit 4) is set."""
    name = _STATES.get(state & 0x0F, f"state 0x{state & 0x0F:X}")
    return f"{name} with error" if state & 0x10 else name
