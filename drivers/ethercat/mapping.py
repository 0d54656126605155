"""Find the slaves of a bus and map their process data."""

from __future__ import annotations

import time
from collections.abc import Sequence

import pysoem

from drivers.errors import BusError, IdentityError, UnmappedError
from drivers.ethercat.identity import check_identity
from drivers.ethercat.image import Image
from drivers.ethercat.protocols import Master, Slave
from drivers.ethercat.slave import SlaveSpec

_SCANS = 5
_SCAN_PAUSE_S = 0.1
MAPPINGS = 3
"""times that slaves are mapped where one has no process data: SOEM asks each for its PDOs once, by the mailbox, and an
answer that is late on a busy host leaves the slave with none
"""


def scan(master: Master, specs: Sequence[SlaveSpec], interface: str) -> Sequence[Slave]:
    """Find the slaves and check who they are.

    More than once: a link that has just come up loses the first frames, and SOEM takes the data of the EEPROM
    access before for that of one whose frames were lost.

    Raises
    ------
    BusError
        If no slave answers, or (an IdentityError) others than those wanted.
    """
    error = BusError(f"no slave answers on '{interface}'; check the cable and that the slaves are powered")
    for _ in range(_SCANS):
        if master.config_init() > 0:
            found = master.slaves or ()
            try:
                check_identity(specs, found, interface)
            except IdentityError as mismatch:
                error = mismatch
            else:
                return found
        time.sleep(_SCAN_PAUSE_S)
    raise error


def map_process_data(master: Master) -> None:
    """Have the slaves configured and their process data mapped.

    Raises
    ------
    BusError
        If that fails.
    """
    try:
        master.config_map()
    except pysoem.ConfigMapError as error:
        # Left-over packet errors appear here though the mapping succeeded; the sizes, checked next, decide.
        serious = [item for item in error.error_list if not isinstance(item, pysoem.PacketError)]
        if serious:
            raise BusError(f"process data could not be mapped: {serious[0]!r}") from error


def check_sizes(specs: Sequence[SlaveSpec], found: Sequence[Slave], outputs: Image, inputs: Image) -> None:
    """Compare the process data the slaves have mapped with what the configuration says.

    Raises
    ------
    BusError
        With the first slave that differs; an UnmappedError if it has no process data at all.
    """
    for place, (spec, slave) in enumerate(zip(specs, found, strict=True)):
        for kind, image, actual in (("outputs", outputs, slave.output), ("inputs", inputs, slave.input)):
            start, stop = image.spans[place]
            if not len(actual) and stop > start:
                raise UnmappedError(
                    f"{spec.name} has no process data of {kind}, the configuration has {stop - start} bytes; "
                    "it did not say its PDOs when asked, or none are assigned"
                )
            if len(actual) != stop - start:
                raise BusError(
                    f"{spec.name} maps {len(actual)} bytes of {kind} but the configuration has {stop - start}; "
                    "its PDOs in the configuration should be those of the device"
                )
