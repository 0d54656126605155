"""What all emulated slaves have in common: dictionary, state machine, process image, watchdog, mailbox.

A slave knows nothing of who serves it. The in-process master and the frame-level responder both configure
``sync_managers``, pass AL requests and SDO requests, and hand over process data.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from fakes.ethercat.objects.dictionary import Object, ObjectDictionary
from fakes.ethercat.objects.identity import Identity
from fakes.ethercat.objects.pdo import RX_ASSIGN, TX_ASSIGN, Layout, PdoConfiguration
from fakes.ethercat.slaves.al import AlCode, AlState, AlStateMachine

MAILBOX_SIZE = 256
MAILBOX_OUT_ADDRESS, MAILBOX_IN_ADDRESS = 0x1000, 0x1200
OUTPUT_ADDRESS, INPUT_ADDRESS = 0x1400, 0x1A00
DEFAULT_WATCHDOG_S = 0.1

Image = npt.NDArray[np.void]
"""Rows of a process image, one a cycle, structured as a :class:`Layout` says."""


@dataclass(slots=True)
class SyncManager:
    """Settings of one sync manager channel as the master wrote them."""

    start: int = 0
    length: int = 0
    enabled: bool = False


@dataclass(frozen=True, slots=True)
class Emergency:
    """An emergency message (ETG.1000.6 §5.6.4): error code, error register, five manufacturer bytes."""

    code: int
    register: int
    data: bytes = bytes(5)


@dataclass(slots=True)
class SlaveState:
    """What :meth:`Slave.save` keeps of a slave."""

    values: dict[int, bytes]
    al: tuple[AlState, AlCode]
    device: dict[str, Any] = field(default_factory=dict)


class Slave:
    """One EtherCAT slave; subclasses give it objects and a use for its process data.

    Parameters
    ----------
    role : its place on the bench, such as ``input_drive``.
    identity : what it says it is.
    objects : its object dictionary.
    """

    VOLATILE: tuple[str, ...] = ()
    """Attributes that belong to a snapshot."""
    SET_VALUES: frozenset[int] = frozenset()
    """Dictionary keys of outputs that are set values and change nothing else when they come."""

    def __init__(self, role: str, identity: Identity, objects: Iterable[Object]) -> None:
        self.role = role
        self.identity = identity
        self.dictionary = ObjectDictionary(objects)
        self.pdo = PdoConfiguration(self.dictionary)
        self.sync_managers = [SyncManager() for _ in range(4)]
        self.emergencies: list[Emergency] = []
        self.watchdog_s = DEFAULT_WATCHDOG_S
        self.outputs = self.pdo.layout(RX_ASSIGN)
        self.inputs = self.pdo.layout(TX_ASSIGN)
        self._output_slices = self.outputs.slices()
        self._settings_mapped = False
        self.al = AlStateMachine(
            checks={"IP": self._check_mailbox, "PS": self._check_process_data, "SO": self._check_outputs},
            actions={
                "PS": self._start_inputs,
                "SO": self._start_outputs,
                "OS": self._stop_outputs,
                "OP": self._stop_outputs,
                "OI": self._stop_all,
                "SI": self._stop_mailbox,
                "PI": self._stop_mailbox,
            },
        )

    # -- configuration ------------------------------------------------------------------------------------------

    def power_cycle(self) -> None:
        """Be as after power-on: INIT, default values, no settings."""
        self._stop_outputs()
        self.dictionary.reset()
        self.al.state, self.al.code = AlState.INIT, AlCode.NONE
        self.sync_managers = [SyncManager() for _ in range(4)]
        self.emergencies.clear()
        self.watchdog_s = DEFAULT_WATCHDOG_S

    def layout(self, assignment: int) -> Layout:
        """Return the process image that the present mapping gives."""
        return self.pdo.layout(assignment)

    def _check_mailbox(self) -> AlCode:
        mailboxes = self.sync_managers[:2]
        good = all(m.enabled and m.start >= 0x1000 and 34 <= m.length <= 1486 for m in mailboxes)
        return AlCode.NONE if good else AlCode.INVALID_MAILBOX

    def _check_process_data(self) -> AlCode:
        for channel, assignment, code in (
            (2, RX_ASSIGN, AlCode.INVALID_OUTPUTS),
            (3, TX_ASSIGN, AlCode.INVALID_INPUTS),
        ):
            manager, size = self.sync_managers[channel], self.layout(assignment).size
            if manager.length != size or manager.enabled != (size > 0):
                return code
        return AlCode.NONE

    def _check_outputs(self) -> AlCode:
        return AlCode.NONE

    def _start_inputs(self) -> None:
        self.outputs, self.inputs = self.layout(RX_ASSIGN), self.layout(TX_ASSIGN)
        self._output_slices = self.outputs.slices()
        self._settings_mapped = any(entry not in self.SET_VALUES for entry, *_ in self._output_slices)

    def _start_outputs(self) -> None:
        """Outputs are valid from now on (SAFE-OPERATIONAL to OPERATIONAL)."""

    def _stop_outputs(self) -> None:
        """Outputs are no longer valid (leaving OPERATIONAL)."""

    def _stop_mailbox(self) -> None:
        """Without a mailbox (INIT) what waited for it is gone."""
        self.emergencies.clear()

    def _stop_all(self) -> None:
        self._stop_outputs()
        self._stop_mailbox()

    def keep_outputs(self, row: bytes) -> None:
        """Take the last process data over into the dictionary, so that SDO uploads show it."""
        values = self.dictionary.values
        for entry, start, stop in self._output_slices:
            values[entry] = row[start:stop]
        if self._settings_mapped:
            self.dictionary.version += 1

    # -- running ------------------------------------------------------------------------------------------------

    @property
    def has_outputs(self) -> bool:
        """Whether process data is written to this slave."""
        return self.outputs.size > 0

    @property
    def exchanging(self) -> bool:
        """Whether its process data sync managers answer (SAFE-OPERATIONAL and OPERATIONAL)."""
        return self.al.state in (AlState.SAFEOP, AlState.OP)

    @property
    def working_counter(self) -> int:
        """Its share of an LRW's working counter: 1 for inputs read, 2 for outputs written."""
        if not self.exchanging:
            return 0
        return (2 if self.outputs.size else 0) + (1 if self.inputs.size else 0)

    def watchdog(self, silent_s: float) -> None:
        """Look at how long outputs have not come; past the limit the slave leaves OPERATIONAL."""
        if self.has_outputs and self.al.state is AlState.OP and 0.0 < self.watchdog_s < silent_s:
            self.al.fall_back(AlState.SAFEOP, AlCode.WATCHDOG)

    # -- snapshots ----------------------------------------------------------------------------------------------

    def save(self) -> SlaveState:
        """Return what brings the slave back to this moment."""
        device = {name: copy.copy(getattr(self, name)) for name in self.VOLATILE}
        return SlaveState(dict(self.dictionary.values), (self.al.state, self.al.code), device)

    def load(self, state: SlaveState) -> None:
        """Go back to a saved moment."""
        self.dictionary.values = dict(state.values)
        self.dictionary.version += 1
        self.al.state, self.al.code = state.al
        for name, value in state.device.items():
            setattr(self, name, copy.copy(value))
