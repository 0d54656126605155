"""In-process stand-in for ``pysoem.Master``: the same names over the emulated slaves, in emulated time.

Beyond pysoem, :meth:`EmulatedMaster.exchange_block` runs many cycles at once as arrays, and
:meth:`EmulatedMaster.snapshot` / :meth:`EmulatedMaster.restore` go back to replay a block. A lost frame costs a cycle
of emulated time like any other; the slaves' watchdogs count it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pysoem

from fakes.ethercat.bench import BenchState, EmulatedBench
from fakes.ethercat.faults import BusFaults, FaultSwitch, Scheduled
from fakes.ethercat.slaves.al import AlState
from fakes.ethercat.slaves.slave import Image
from fakes.ethercat.stand_in_slave import StandInSlave

NO_FRAME = -1
Bytes = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class MasterState:
    """Token of :meth:`EmulatedMaster.snapshot`."""

    bench: BenchState
    outputs: tuple[bytes, ...]
    inputs: tuple[bytes, ...]
    silent_cycles: tuple[int, ...]
    faults: tuple[BusFaults, tuple[Scheduled, ...]]


class EmulatedMaster:
    """pysoem's master over an :class:`~fakes.ethercat.bench.EmulatedBench`.

    ``faults`` switches what can break, see :mod:`fakes.ethercat.faults`.
    """

    def __init__(self, bench: EmulatedBench) -> None:
        self.bench = bench
        self.faults = FaultSwitch(bench)
        self.slaves: list[StandInSlave] = []
        self.state: int = pysoem.INIT_STATE
        self.context_initialized = False
        self.manual_state_change = 0
        self.sdo_read_timeout = 700_000
        self.sdo_write_timeout = 700_000
        self.always_release_gil = False
        self.dc_time = 0
        self._sent = False
        self._silent = [0] * len(bench.slaves)

    # -- life ---------------------------------------------------------------------------------------------------

    def open(self, ifname: str, ifname_red: str | None = None) -> None:
        """Open; any interface name serves, none is touched."""
        self.context_initialized = True

    def close(self) -> None:
        """Close; slaves stay in the state they have."""
        self.context_initialized = False

    def check_open(self) -> None:
        """Raise pysoem's error where the master is not open."""
        if not self.context_initialized:
            raise pysoem.NetworkInterfaceNotOpenError("the interface is not open: call Master.open() first")

    def reaches(self, position: int) -> bool:
        """Whether the slave at a position (from 0) answers."""
        return self.faults.bus.answering(self.bench)[position]

    # -- configuration ------------------------------------------------------------------------------------------

    def config_init(self, usetable: bool = False, *, release_gil: bool | None = None) -> int:
        """Find the slaves and ask them for PRE-OPERATIONAL; return how many, or -1."""
        self.check_open()
        reachable = self.faults.bus.answering(self.bench)
        found = [i for i, answers in enumerate(reachable) if answers]
        self.slaves = [StandInSlave(self, i, self.bench.slaves[i]) for i in found]
        for slave in self.slaves:
            slave.request(pysoem.INIT_STATE | pysoem.STATE_ACK)
            slave.configure_mailbox()
            slave.refresh()  # as pysoem: the state shown is that before PRE-OPERATIONAL was asked for
            if not self.manual_state_change:
                slave.request(pysoem.PREOP_STATE | pysoem.STATE_ACK)
        return len(found) or NO_FRAME

    def config_map(self) -> int:
        """Run the configuration hooks, map the process image, ask for SAFE-OPERATIONAL; return its size in bytes."""
        self.check_open()
        total = 0
        for slave in self.slaves:
            slave.refresh()
            out, in_ = slave.map()
            slave.output_bytes, slave.input_bytes = bytearray(out), bytearray(in_)
            total += out + in_
            if not self.manual_state_change:
                slave.request(pysoem.SAFEOP_STATE)
        self._silent = [0] * len(self.bench.slaves)
        return total

    def config_dc(self) -> bool:
        """Distributed clocks: in emulated time all clocks are one."""
        self.check_open()
        return True

    # -- states -------------------------------------------------------------------------------------------------

    def read_state(self) -> int:
        """Refresh state and AL code of every slave; return the lowest state."""
        self.check_open()
        for slave in self.slaves:
            slave.refresh()
        self.state = min((slave.state for slave in self.slaves), default=pysoem.NONE_STATE)
        return self.state

    def write_state(self) -> int:
        """Request ``state`` of every slave; return the working counter."""
        self.check_open()
        for slave in self.slaves:
            slave.request(self.state)
        return sum(slave.reached() for slave in self.slaves)

    def state_check(self, expected_state: int, timeout: int = 50_000) -> int:
        """Return the states of all slaves or-ed, as a broadcast read gives them."""
        self.check_open()
        found = 0
        for slave in self.slaves:
            found |= slave._slave.al.status if slave.reached() else 0
        self.state = found
        return found

    @property
    def expected_wkc(self) -> int:
        """Working counter of a good cycle: two for outputs, one for inputs of each slave."""
        return sum(2 * bool(slave.output_bytes) + bool(slave.input_bytes) for slave in self.slaves)

    # -- process data -------------------------------------------------------------------------------------------

    def send_processdata(self, *, release_gil: bool | None = None) -> int:
        """Send the outputs; the cycle runs when the inputs are fetched."""
        self.check_open()
        self._sent = True
        return 1

    def receive_processdata(self, timeout: int = 2000, *, release_gil: bool | None = None) -> int:
        """Run one cycle and fetch the inputs; return the working counter, or -1 if the frame was lost."""
        self.check_open()
        if not self._sent:
            return NO_FRAME
        self._sent = False
        outputs = np.frombuffer(b"".join(bytes(s.output_bytes) for s in self.slaves), np.uint8).reshape(1, -1)
        inputs = np.frombuffer(bytearray(b"".join(bytes(s.input_bytes) for s in self.slaves)), np.uint8).reshape(1, -1)
        counters = np.zeros(1, np.int32)
        self.exchange_block(outputs, inputs, counters)
        at = 0
        for slave in self.slaves:
            slave.input_bytes[:] = inputs[0, at : at + len(slave.input_bytes)].tobytes()
            at += len(slave.input_bytes)
        return int(counters[0])

    def exchange_block(self, outputs: Bytes, inputs: Bytes, wkc: npt.NDArray[np.int32]) -> int:
        """Run as many cycles as there are rows.

        Parameters
        ----------
        outputs : (n, output bytes) what each cycle sends, slaves side by side in order of position.
        inputs : (n, input bytes) filled with what each cycle brings; a cycle whose frame is lost repeats the last.
        wkc : (n,) filled with the working counter of each cycle, -1 where the frame was lost.

        Returns
        -------
        int : cycles run, always n.
        """
        self.check_open()
        n = len(wkc)
        out_rows = self._split(outputs, [slave.output_bytes for slave in self.slaves], "outputs")
        in_rows = self._split(inputs, [slave.input_bytes for slave in self.slaves], "inputs")
        first = 0
        while first < n:
            self.faults.due(self.bench.cycle)
            lost = self.faults.bus.frames_to_lose > 0
            stop = min(n, first + 1) if lost else self._until(first, n)
            counter = self._cycles(out_rows, in_rows, first, stop, lost)
            wkc[first:stop] = counter
            first = stop
        for slave, rows in zip(self.slaves, out_rows, strict=True):
            if rows is not None:
                slave.output_bytes[:] = rows[n - 1].tobytes()
        for slave, rows in zip(self.slaves, in_rows, strict=True):
            if rows is not None:
                slave.input_bytes[:] = rows[n - 1].tobytes()
        return n

    def _until(self, first: int, n: int) -> int:
        """Return where a stretch of undisturbed cycles ends: at the next scheduled fault or watchdog."""
        stop = n
        due = self.faults.next_cycle()
        if due is not None:
            stop = min(stop, first + max(1, due - self.bench.cycle))
        for slave, silent in zip(self.bench.slaves, self._silent, strict=True):
            if silent and slave.has_outputs:
                left = int(slave.watchdog_s / self.bench.cycle_time_s) + 1 - silent
                stop = min(stop, first + max(1, left))
        return stop

    def _cycles(
        self, out_rows: Sequence[Image | None], in_rows: Sequence[Image | None], first: int, stop: int, lost: bool
    ) -> int:
        """Run cycles ``first`` to ``stop`` under constant conditions; return their working counter."""
        bus = self.faults.bus
        reachable = bus.answering(self.bench)
        outputs: list[Image | None] = [None] * len(self.bench.slaves)
        inputs: list[Image | None] = [None] * len(self.bench.slaves)
        counter = 0
        for slave, out, in_ in zip(self.slaves, out_rows, in_rows, strict=True):
            position = slave._position
            served = not lost and reachable[position] and slave._slave.role not in bus.short
            if in_ is not None and not (served and slave._slave.exchanging):
                in_[first:stop] = in_[first - 1] if first else np.frombuffer(bytes(slave.input_bytes), in_.dtype)[0]
            if not served:
                continue
            counter += slave._slave.working_counter
            outputs[position] = None if out is None else out[first:stop]
            inputs[position] = in_[first:stop] if in_ is not None and slave._slave.exchanging else None
        self.bench.run(outputs, inputs, stop - first)
        self._watch(outputs, stop - first)
        if lost:
            bus.frames_to_lose -= 1
            return NO_FRAME
        return counter if any(reachable) else NO_FRAME

    def _watch(self, outputs: Sequence[Image | None], cycles: int) -> None:
        for i, (slave, rows) in enumerate(zip(self.bench.slaves, outputs, strict=True)):
            self._silent[i] = self._silent[i] + cycles if rows is None and slave.al.state is AlState.OP else 0
            slave.watchdog(self._silent[i] * self.bench.cycle_time_s)

    def _split(self, block: Bytes, sizes: Sequence[bytearray], what: str) -> list[Image | None]:
        """Return each slave's columns of a block as structured rows."""
        total = sum(map(len, sizes))
        if block.ndim != 2 or block.shape[1] != total:
            raise ValueError(f"{what} must be (n, {total}) bytes, not {block.shape}")
        rows: list[Image | None] = []
        at = 0
        for slave, held in zip(self.slaves, sizes, strict=True):
            layout = slave._slave.outputs if what == "outputs" else slave._slave.inputs
            exact = len(held) > 0 and layout.size == len(held)
            rows.append(np.ndarray((len(block),), layout.dtype, block, at, (block.strides[0],)) if exact else None)
            at += len(held)
        return rows

    # -- snapshots ----------------------------------------------------------------------------------------------

    def snapshot(self) -> MasterState:
        """Return a token of bench and process image."""
        return MasterState(
            self.bench.snapshot(),
            tuple(bytes(s.output_bytes) for s in self.slaves),
            tuple(bytes(s.input_bytes) for s in self.slaves),
            tuple(self._silent),
            self.faults.save(),
        )

    def restore(self, token: MasterState) -> None:
        """Go back to a token, to run other cycles from there."""
        self.bench.restore(token.bench)
        self._silent = list(token.silent_cycles)
        self.faults.load(token.faults)
        for slave, out, in_ in zip(self.slaves, token.outputs, token.inputs, strict=True):
            slave.output_bytes[:], slave.input_bytes[:] = out, in_


def emulated_master(
    plant: str = "rh380n", seed: int = 0, cycle_time_s: float = 0.0005, without: Sequence[str] = ()
) -> EmulatedMaster:
    """Return a master over the emulated bench of a plant file (entry point ``emulated`` of ``bench.masters``).

    ``plant`` is the name of a plant that ships or a path, ``seed`` that of its noise, ``without`` terminals it lacks.
    """
    from fakes.ethercat.benches import bench_of

    return EmulatedMaster(bench_of(plant, seed, cycle_time_s, without))
