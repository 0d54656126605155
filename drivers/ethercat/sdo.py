"""Access to the object dictionary of one slave, with errors one can act on."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
import pysoem

from drivers.entries import TYPES, entry_name
from drivers.errors import ParameterMismatchError, SdoAccessError
from drivers.ethercat.codes import mailbox_error_text, sdo_abort_text
from drivers.ethercat.patience import PATIENCE_S, Tries, nothing
from drivers.ethercat.protocols import Slave

_T = TypeVar("_T")


class SdoClient:
    """Object dictionary of one slave over CoE.

    Parameters
    ----------
    slave : slave of a master with pysoem's API.
    name : what the configuration calls the slave; stands in every error.
    settle : as of :class:`~drivers.ethercat.patience.Tries`.
    """

    def __init__(self, slave: Slave, name: str, settle: Callable[[], None] = nothing) -> None:
        self.name = name
        self._slave, self._settle = slave, settle
        self._patience_s = PATIENCE_S

    def cycles_wait(self) -> None:
        """Wait for a silent slave no longer: cycles wait for an access from now on."""
        self._patience_s = 0.0

    def read_bytes(self, index: int, subindex: int, size: int = 0) -> bytes:
        """Raw content of an object; ``size`` in bytes where it is above 256.

        Raises
        ------
        SdoAccessError
            With the abort code in words, or that the slave did not answer.
        """
        return self._attempt("read", index, subindex, lambda: self._slave.sdo_read(index, subindex, size))

    def read(self, index: int, subindex: int, type_: str) -> int:
        """Integer value of an object of a type of :data:`drivers.entries.TYPES`.

        Raises
        ------
        SdoAccessError
            Also where the device keeps the object in another length.
        """
        data = self.read_bytes(index, subindex)
        dtype = np.dtype(TYPES[type_])
        if len(data) != dtype.itemsize:
            raise SdoAccessError(
                f"{self.name}: object {entry_name(index, subindex)} has {len(data)} bytes, not the "
                f"{dtype.itemsize} of type {type_}; the device description and the firmware should agree",
                self.name,
                index,
                subindex,
            )
        return int(np.frombuffer(data, dtype)[0])

    def read_text(self, index: int, subindex: int = 0) -> str:
        """Text of a VISIBLE_STRING object, without trailing zeros."""
        return self.read_bytes(index, subindex).rstrip(b"\0").decode("latin-1")

    def write(self, index: int, subindex: int, type_: str, value: int) -> None:
        """Write an integer.

        Raises
        ------
        SdoAccessError
            Where the value does not fit the type, or the slave refuses it.
        """
        dtype = np.dtype(TYPES[type_])
        limits = np.iinfo(dtype)
        if not limits.min <= value <= limits.max:
            raise SdoAccessError(
                f"{self.name}: {value} does not fit object {entry_name(index, subindex)} of type {type_} "
                f"({limits.min} to {limits.max})",
                self.name,
                index,
                subindex,
            )
        data = np.array(value, dtype).tobytes()
        self._attempt("written", index, subindex, lambda: self._slave.sdo_write(index, subindex, data))

    def write_checked(self, index: int, subindex: int, type_: str, value: int) -> None:
        """Write an integer, read it back and compare: devices clip silently.

        Raises
        ------
        ParameterMismatchError
            If the device keeps another value.
        """
        self.write(index, subindex, type_, value)
        kept = self.read(index, subindex, type_)
        if kept != value:
            raise ParameterMismatchError(
                f"{self.name}: object {entry_name(index, subindex)} was set to {value} but the device keeps {kept}; "
                "a value the device accepts should stand in the configuration"
            )

    def exists(self, index: int, subindex: int) -> bool:
        """Whether the device has an object (any abort but "does not exist" is raised)."""
        try:
            self.read_bytes(index, subindex)
        except SdoAccessError as error:
            if error.abort_code in (0x06020000, 0x06090011):
                return False
            raise
        return True

    def _attempt(self, verb: str, index: int, subindex: int, access: Callable[[], _T]) -> _T:
        tries, more = Tries(self._patience_s, self._settle), True
        while more:
            silent = False
            try:
                return access()
            except pysoem.SdoError as error:
                raise SdoAccessError(
                    f"{self.name}: object {entry_name(index, subindex)} could not be {verb}: "
                    f"{sdo_abort_text(error.abort_code)}",
                    self.name,
                    index,
                    subindex,
                    error.abort_code,
                ) from error
            except pysoem.MailboxError as error:
                reason = f"mailbox error {mailbox_error_text(error.error_code)}"
            except pysoem.WkcError:
                reason, silent = "the slave does not answer; its cable, supply and state should be looked at", True
            # pysoem asserts that an error it finds queued is of the slave it was asked about.
            except (pysoem.PacketError, AssertionError):
                reason = "an unexpected mailbox answer came instead"
            more = tries.again(silent=silent)
        raise SdoAccessError(
            f"{self.name}: object {entry_name(index, subindex)} could not be {verb} in {tries.made} tries "
            f"({tries.waited_s:.1f} s): {reason}",
            self.name,
            index,
            subindex,
        )
