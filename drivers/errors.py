"""Errors of the drivers: each carries one sentence that says what is wrong, where, and what would be right."""

from __future__ import annotations


class DriverError(Exception):
    """Base of everything a driver raises about a device, a bus or a wrong setting of a driver."""


class BusError(DriverError):
    """The bus cannot be opened, configured or brought to an operating state."""


class IdentityError(BusError):
    """The devices on the bus are not those of the configuration, or not in its order."""


class UnmappedError(BusError):
    """A slave has no process data where the configuration has some."""


class SdoAccessError(BusError):
    """An object of a slave could not be read or written.

    Attributes
    ----------
    slave, index, subindex : which object of which slave.
    abort_code : SDO abort code (ETG.1000.6), or None where the mailbox or the frame failed.
    """

    def __init__(self, message: str, slave: str, index: int, subindex: int, abort_code: int | None = None) -> None:
        super().__init__(message)
        self.slave = slave
        self.index = index
        self.subindex = subindex
        self.abort_code = abort_code

    def __reduce__(self) -> tuple[type[SdoAccessError], tuple[object, ...]]:
        return type(self), (str(self), self.slave, self.index, self.subindex, self.abort_code)


class ParameterMismatchError(DriverError):
    """A parameter that a device keeps differently from what was written to it."""


class DriveFaultError(DriverError):
    """A servo drive in fault, or one that does not follow its state machine in time."""


class SensorError(DriverError):
    """A reading that is not a measurement: open or short circuit, over-range, silence, an implausible value."""
