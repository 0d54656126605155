"""The rig's side of a bus process: the bus as :class:`EtherCatBus` offers it, with set values handed over ahead."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.errors import BusError
from drivers.ethercat.exchange import Exchange
from drivers.ethercat.identity import check_specs
from drivers.ethercat.image import Image
from drivers.ethercat.process import layout as at
from drivers.ethercat.process.client import Client, reserve_memory
from drivers.ethercat.process.guard import Reason
from drivers.ethercat.process.layout import Layout, Shared
from drivers.ethercat.process.services import Services
from drivers.ethercat.process.settings import Protection, RealTime, Setup
from drivers.ethercat.slave import SlaveSpec

_SECONDS_OF_SET_VALUES, _SECONDS_OF_IMAGES = 4.0, 8.0
_SILENCE_S = 2.0
"""A process that hands over no image for so long does not cycle."""
_SHORTEST_WAIT_S = 0.0002
_CYCLES_TO_SEE = 1000
"""Cycles within which a process that lives has seen what was written, even on a machine that does much else."""


class RemoteBus(Services):
    """A bus in a process of its own.

    Set values are handed over ahead with :meth:`submit`, images come back with :meth:`collect`; the process takes one
    row of set values a cycle and holds the last one when there is none. Everything else is :class:`EtherCatBus`.

    Parameters
    ----------
    master : ``module:function`` of the factory of the master, called in the process with ``arguments``.
    interface, slaves, cycle_time_s : as of :class:`EtherCatBus`.
    block_capacity : most cycles handed over or collected at once.
    real_time : how the process asks to be scheduled.
    make_up_s : how much later slots may begin, see :class:`drivers.ethercat.AbsoluteDeadlines`.

    Attributes
    ----------
    outputs : structured array (block_capacity,) a slave: set values to be submitted.
    sent, inputs : the same of what was sent and received in the cycles collected last.
    meta : int64 (n, META_WORDS) beside those cycles, see :mod:`drivers.ethercat.process.layout`.
    notes : sentences on what the process was not granted; known once it is open.
    """

    def __init__(
        self,
        master: str,
        interface: str,
        slaves: Sequence[SlaveSpec],
        cycle_time_s: float = 0.0005,
        block_capacity: int = 100,
        real_time: RealTime | None = None,
        arguments: Mapping[str, Any] | None = None,
        make_up_s: float = 0.0,
    ) -> None:
        super().__init__(check_specs(slaves))
        self.interface, self.cycle_time_s, self.block_capacity = interface, cycle_time_s, block_capacity
        outputs = [(spec.name, spec.outputs) for spec in self.specs]
        inputs = [(spec.name, spec.inputs) for spec in self.specs]
        self._out = Image.build(outputs, block_capacity)
        self._sent, self._in = Image.build(outputs, block_capacity), Image.build(inputs, block_capacity)
        self.outputs: Mapping[str, NDArray[Any]] = self._out.views
        self.sent: Mapping[str, NDArray[Any]] = self._sent.views
        self.inputs: Mapping[str, NDArray[Any]] = self._in.views
        self.meta: NDArray[np.int64] = np.zeros((0, at.META_WORDS), np.int64)
        self.expected_wkc = 0
        self.notes: tuple[str, ...] = ()
        self.layout = Layout(
            self._out.bytes.shape[1],
            self._in.bytes.shape[1],
            round(_SECONDS_OF_SET_VALUES / cycle_time_s),
            round(_SECONDS_OF_IMAGES / cycle_time_s),
        )
        self._setup = Setup(
            master,
            dict(arguments or {}),
            interface,
            tuple(replace(spec, configure=None) for spec in self.specs),
            tuple(spec.configure is not None for spec in self.specs),
            cycle_time_s,
            self.layout.set_rows,
            self.layout.image_rows,
            real_time or RealTime(),
            make_up_s,
        )
        self._protection = Protection()
        self._tail = 0
        self._descriptor = -1
        self._shared: Shared | None = None

    # -- life -----------------------------------------------------------------------------------------------------

    def open(self) -> None:
        """Start the process and open the interface in it.

        Raises
        ------
        BusError
            As :meth:`EtherCatBus.open`, or if the process does not start.
        """
        self._descriptor = reserve_memory(self.layout.size)
        self._shared = Shared(self._descriptor, self.layout)
        configure = {spec.name: spec.configure for spec in self.specs if spec.configure is not None}
        self._client = Client(self._setup, self._descriptor, configure)
        self._tail = 0
        try:
            self.notes = self._client.ask("open")
        except BusError:
            self.close()
            raise

    def configure(self) -> None:
        """As :meth:`EtherCatBus.configure`; the slaves' own ``configure`` runs here, its accesses there."""
        self._running_client.ask("configure")

    def to_operational(self) -> None:
        """Bring all slaves to OP while row 0 of the outputs is sent; from then on the process cycles by itself."""
        self.expected_wkc = self._running_client.ask("to_operational", self._out.bytes[0].tobytes())

    def protect(self, protection: Protection) -> None:
        """Say when the process stops the drives by itself, and how; it acts once :meth:`arm` was called."""
        self._running_client.ask("protect", protection)
        self._protection = protection

    def close(self) -> None:
        """Bring all slaves to INIT, close the interface, end the process."""
        client, self._client = self._client, None
        if client is not None:
            client.close()
            self._shared = None
            os.close(self._descriptor)

    def __enter__(self) -> RemoteBus:
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def ended(self) -> str | None:
        """A sentence once the process has ended by itself, else None."""
        return None if self._running_client.look() else self._running_client.ended

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._running_client.pid

    # -- process data ---------------------------------------------------------------------------------------------

    @property
    def queued(self) -> int:
        """Set values handed over and not yet sent, in cycles."""
        words = self._memory.words
        return int(words[at.SET_HEAD] - max(words[at.SET_USED], words[at.SKIP_TO]))

    @property
    def used(self) -> int:
        """Index after that of the set values sent last."""
        return int(self._memory.words[at.SET_USED])

    def row(self, row: int) -> bytes:
        """Process image of one row of the outputs."""
        image: bytes = self._out.bytes[row].tobytes()
        return image

    def submit(self, n: int) -> int:
        """Hand over rows 0 … n − 1 of the outputs, one a cycle; return the index of the first.

        Raises
        ------
        BusError
            If the ring has no room for them.
        """
        shared, rows = self._memory, self.layout.set_rows
        head = int(shared.words[at.SET_HEAD])
        # one row of distance, so that the one being taken is never the one being written
        if not self._has_room(shared, n):
            raise BusError(f"set values of {n} more cycles do not fit; {rows - 1} may be ahead")
        places = np.arange(head, head + n) % rows
        shared.set_values[places] = self._out.bytes[:n]
        shared.words[at.SET_HEAD] = head + n
        return head

    def flush(self) -> int:
        """Drop what was handed over and not yet sent; return the index of the next row to be submitted."""
        words = self._memory.words
        words[at.SKIP_TO] = words[at.SET_HEAD]
        return int(words[at.SET_HEAD])

    def collect(self, least: int = 1) -> Exchange:
        """Wait until ``least`` cycles have come, then take all there are (up to the capacity): ``sent`` and ``inputs``.

        Returns an exchange of no cycles where the process has ended or does not cycle (:attr:`ended` says why).
        Cycles that were overwritten because nobody collected them in time show as a step in ``cycle``.
        """
        shared, rows = self._memory, self.layout.image_rows
        n = min(self._wait(shared, least), self.block_capacity)
        if self._lag(shared) > rows - self.block_capacity:
            self._tail += self._lag(shared) - rows + 2 * self.block_capacity
        places = np.arange(self._tail, self._tail + n) % rows
        self._tail += n
        self._sent.bytes[:n] = shared.sent[places]
        self._in.bytes[:n] = shared.inputs[places]
        meta = self.meta = shared.meta[places]
        wkc, cycle, woke, index, due = meta.T[[at.WKC, at.CYCLE, at.WOKE, at.SET_INDEX, at.DUE]]
        return Exchange(n, wkc.astype(np.int32), cycle, woke, index, woke - due)

    def arm(self, hold_cycles: int) -> None:
        """Let the last set values be held for so many cycles; then, or when a limit is broken, the drives are stopped.

        0 disarms: the last set values are held for ever and no limit acts.
        """
        self._memory.words[at.HOLD_LIMIT] = hold_cycles

    def order_stop(self) -> None:
        """Have the process stop the drives by itself, within 16 cycles."""
        words = self._memory.words
        words[at.STOP_ORDER] = words[at.RESUMED] + 1

    def silence(self) -> None:
        """Have the process send no process data any more and end, within 16 cycles; nothing is waited for."""
        self._memory.words[at.SILENCE] = 1

    def resume(self) -> None:
        """Follow set values again after the process has stopped the drives by itself: an operator's act.

        Raises
        ------
        BusError
            If the process is not done with its stop, or has ended.
        """
        words = self._memory.words
        words[at.SKIP_TO] = words[at.SET_HEAD]
        words[at.STOP_ORDER] = 0
        wanted = words[at.RESUMED] + 1
        words[at.RESUME] = wanted
        end = time.monotonic() + _SILENCE_S
        while words[at.RESUMED] != wanted:
            if not self._running_client.look() or time.monotonic() > end:
                raise BusError(self.ended or "the bus process still stops the drives; wait until they are at rest")
            time.sleep(self.cycle_time_s)

    @property
    def stopped(self) -> str | None:
        """Why the process has stopped the drives by itself, or None."""
        words = self._memory.words
        reason = Reason(words[at.STOP_REASON])
        if reason is Reason.NONE:
            return None
        return self._protection.watches[words[at.DETAIL]].broken if reason is Reason.LIMIT else reason.text

    @property
    def tap(self) -> tuple[str, Layout]:
        """File and layout by which another process of the same user can map the rings, to look at them only."""
        return f"/proc/{os.getpid()}/fd/{self._descriptor}", self.layout

    @property
    def _memory(self) -> Shared:
        if self._shared is None:
            raise BusError("the bus process does not run; open() comes first")
        return self._shared

    def _has_room(self, shared: Shared, n: int) -> bool:
        """Whether n more rows fit; rows that were dropped count until the process has seen that."""
        for _ in range(_CYCLES_TO_SEE):
            if shared.words[at.SET_HEAD] - shared.words[at.SET_NEXT] + n < self.layout.set_rows:
                return True
            if self.queued + n >= self.layout.set_rows:
                return False
            time.sleep(self.cycle_time_s)
        return False

    def _lag(self, shared: Shared) -> int:
        return int(shared.words[at.IMAGE_HEAD]) - self._tail

    def _wait(self, shared: Shared, least: int) -> int:
        """Sleep until ``least`` images are there; return how many are, 0 where none come any more."""
        deadline = time.monotonic() + _SILENCE_S + least * self.cycle_time_s
        while (lag := self._lag(shared)) < least:
            if not self._running_client.look() or time.monotonic() > deadline:
                return lag
            time.sleep(max(_SHORTEST_WAIT_S, (least - lag) * self.cycle_time_s))
        return lag
