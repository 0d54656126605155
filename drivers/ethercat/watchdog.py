"""The process data watchdog of a slave: how long it holds its outputs without the master (register 0x0420)."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import pysoem

from drivers.errors import BusError
from drivers.ethercat.patience import Tries, nothing
from drivers.ethercat.protocols import Slave


def set_watchdog(slave: Slave, name: str, watchdog_s: float, settle: Callable[[], None] = nothing) -> None:
    """Set the watchdog, read it back and compare.

    Parameters
    ----------
    slave : slave of a master with pysoem's API.
    name : what the configuration calls it.
    watchdog_s : time, s.
    settle : as of :class:`~drivers.ethercat.patience.Tries`.

    Raises
    ------
    BusError
        If the slave does not take the time, or keeps another: one that is longer would stop the drive too late.
    """
    wanted_ms = watchdog_s * 1e3
    reason = "it does not answer"
    tries, more = Tries(settle=settle), True
    while more:
        try:
            kept_ms = _write_and_read(slave, wanted_ms)
        except AttributeError as error:
            reason = str(error)
            break
        except pysoem.WkcError:
            more = tries.again(silent=True)
            continue
        # One step of the default divider is 0.1 ms.
        if abs(kept_ms - wanted_ms) <= max(0.1, 0.01 * wanted_ms):
            return
        raise BusError(
            f"{name} keeps a process data watchdog of {kept_ms:g} ms where {wanted_ms:g} ms are configured; "
            "a time the slave can keep should stand in the configuration"
        )
    raise BusError(f"{name} does not take a process data watchdog of {wanted_ms:g} ms: {reason}")


def _write_and_read(slave: Slave, wanted_ms: float) -> float:
    with warnings.catch_warnings():
        # pysoem warns of every rounding to the divider's grid; the value is read back and judged instead.
        warnings.simplefilter("ignore", UserWarning)
        slave.set_watchdog("processdata", wanted_ms)
        return slave.get_watchdog("processdata")
