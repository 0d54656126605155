"""Exit codes of every command; scripts may rely on them."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

from bench.errors import BenchError, ConfigurationError, DeviceError, LimitError, RecordingError

if TYPE_CHECKING:
    from bench.safety import Cause


class ExitCode(IntEnum):
    """What a command's exit code says."""

    OK = 0
    INTERNAL_ERROR = 1
    USAGE = 2
    BAD_INPUT = 3
    LIMIT = 4
    DEVICE = 5
    NOT_VALID = 6
    NOT_WRITTEN = 7
    INTERRUPTED = 130


MEANING: dict[ExitCode, str] = {
    ExitCode.OK: "all done",
    ExitCode.INTERNAL_ERROR: "a fault of this program or of a sequence",
    ExitCode.USAGE: "the command line is wrong",
    ExitCode.BAD_INPUT: "a bench, campaign, model or recording file is wrong",
    ExitCode.LIMIT: "refused or stopped, because a limit would be or was broken",
    ExitCode.DEVICE: "a device or the bus failed, or after STOP a bench was not seen at rest",
    ExitCode.NOT_VALID: "finished, but some points failed or some files are not valid",
    ExitCode.NOT_WRITTEN: (
        "the bench was stopped while it moved because a recording could not be written, for example on a full disk"
    ),
    ExitCode.INTERRUPTED: (
        "interrupted by the operator, or no room on the disk before a point; the bench is at rest and the recording "
        "finished"
    ),
}

_OF_ERROR: tuple[tuple[type[BenchError], ExitCode], ...] = (
    (ConfigurationError, ExitCode.BAD_INPUT),
    (RecordingError, ExitCode.BAD_INPUT),
    (LimitError, ExitCode.LIMIT),
    (DeviceError, ExitCode.DEVICE),
)


def exit_code_of(error: BenchError) -> ExitCode:
    """Return the exit code that stands for an error."""
    return next((code for kind, code in _OF_ERROR if isinstance(error, kind)), ExitCode.BAD_INPUT)


def exit_code_of_stop(cause: Cause) -> ExitCode:
    """Return the exit code that stands for what stopped a bench."""
    from bench.safety import Cause, is_device_fault

    if cause is Cause.RECORDER:
        return ExitCode.NOT_WRITTEN
    if cause is Cause.PROGRAM:
        return ExitCode.INTERNAL_ERROR
    return ExitCode.DEVICE if is_device_fault(cause) else ExitCode.LIMIT


def exit_code_help() -> str:
    """Return the table for ``--help``."""
    return "Exit codes: " + "; ".join(f"{code.value} {meaning}" for code, meaning in MEANING.items()) + "."
