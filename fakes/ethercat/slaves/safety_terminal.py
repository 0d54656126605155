"""Digital input terminal that shows the safety relay's circuits: emergency stop (bit 0) and safe torque off (bit 1).

Both are closed-circuit: 1 says "closed, all well", so that a broken wire reads like a demand. The relay itself is
hardware and acts without any software: an emergency stop reaches the drives' STO inputs after its delay (stop category
1 of IEC 60204-1), whatever the master does meanwhile.
"""

from __future__ import annotations

from collections.abc import Sequence

from fakes.ethercat.objects.common import assignments, common, mapping
from fakes.ethercat.objects.dictionary import Entry, key, sparse_record
from fakes.ethercat.objects.identity import SAFETY_TERMINAL, Identity
from fakes.ethercat.objects.types import UINT, USINT
from fakes.ethercat.slaves.plant_link import Rows
from fakes.ethercat.slaves.servo import ServoDrive
from fakes.ethercat.slaves.slave import Image, Slave

PROFILE_MODULAR = 0x00001389
EMERGENCY_STOP, SAFE_TORQUE_OFF = 0x01, 0x02
RELAY_DELAY_S = 0.5
"""From the emergency stop to safe torque off, unless a fault says otherwise."""


class SafetyTerminal(Slave):
    """Eight digital inputs, two of them wired.

    ``pressed`` says whether the emergency stop is, ``broken`` whether its wire to this terminal is.
    """

    VOLATILE = ("pressed", "broken", "_byte")

    def __init__(self, role: str, drives: Sequence[ServoDrive], cycle_time_s: float, serial: int = 5) -> None:
        identity = Identity(SAFETY_TERMINAL, serial, "DI-8", "Emulated digital input, 8 channels", PROFILE_MODULAR)
        self.pressed = False
        self.broken = False
        self._drives = tuple(drives)
        self._byte = EMERGENCY_STOP | SAFE_TORQUE_OFF
        super().__init__(
            role,
            identity,
            (
                *common(identity, round(cycle_time_s * 1e9)),
                sparse_record(0x6000, "Inputs", {1: Entry("Inputs 1 to 8", USINT, "ro", 0, "t")}),
                mapping(0x1A00, "TxPDO inputs", ((0x6000, 0x01, 8),), "ro"),
                *assignments((), (0x1A00,), "rwpre"),
                sparse_record(0xF000, "Modular device profile", {1: Entry("Index distance", UINT, "ro", 16)}),
            ),
        )
        self.dictionary.readers[key(0x6000, 0x01)] = lambda: self._byte

    def report(self, measured: Rows, image: Image | None, first: int, stop: int, cycle: int) -> None:
        """Write the inputs of a run of cycles; the circuits do not change within one."""
        byte = 0 if self.pressed or self.broken else EMERGENCY_STOP
        if not any(drive.power.safe_torque_off for drive in self._drives):
            byte |= SAFE_TORQUE_OFF
        self._byte = byte
        if image is not None and self.inputs.size:
            image["6000:01"][first:stop] = byte
