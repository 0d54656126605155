"""An EtherCAT bus on pysoem's API: from an open interface to process data in blocks, and back to INIT."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.errors import BusError, DriverError, UnmappedError
from drivers.ethercat import nonblocking
from drivers.ethercat.assignment import assign_pdos
from drivers.ethercat.claim import Claim
from drivers.ethercat.distributed_clocks import set_up_clocks, start_sync0
from drivers.ethercat.emergency import EmergencyLog, EmergencyMessage
from drivers.ethercat.exchange import CycleExchanger, Exchange, Exchanger, make_exchanger
from drivers.ethercat.identity import check_specs
from drivers.ethercat.image import Image
from drivers.ethercat.mapping import MAPPINGS, check_sizes, map_process_data, scan
from drivers.ethercat.pacing import FreeRunning, Pacing
from drivers.ethercat.protocols import Master, Slave
from drivers.ethercat.recovery import Condition, Recovery, recover_step
from drivers.ethercat.sdo import SdoClient
from drivers.ethercat.slave import SlaveSpec
from drivers.ethercat.states import reach_init, reach_op, reach_safeop
from drivers.ethercat.watchdog import set_watchdog

_OP_TIMEOUT_S = 5.0
CYCLES_TO_ANSWER = 2
"""A frame is waited for so long, unless another time is given."""


class EtherCatBus:
    """The bus: the only one that talks to the master.

    Parameters
    ----------
    master : ``pysoem.Master()`` or anything with its API; one that also has ``exchange_block`` runs whole blocks.
    interface : network interface.
    slaves : every slave on the bus.
    cycle_time_s : period of the process data, s.
    block_capacity : most cycles of one :meth:`exchange`.
    pacing : when cycles start; :class:`FreeRunning` by default, :class:`AbsoluteDeadlines` on hardware.
    timeout_us : how long to wait for a frame, µs; None: two cycles. A late frame is still a measurement (the slots it
        was late for are skipped and show in the cycle numbers), one that was given up is none.
    nonblocking_socket : set O_NONBLOCK on the master's raw socket (:mod:`drivers.ethercat.nonblocking`).
    memory : outputs and inputs, uint8 (block_capacity, width), to use instead of own memory.
    whole_blocks : let a master that can run whole blocks do so.

    Attributes
    ----------
    sent : what stood in the outputs in the cycles of the last exchange; here the outputs themselves.
    outputs, inputs : structured array (block_capacity,) a slave that has outputs or inputs, by its name; fields by
        entry, such as ``"6040:00"``. :meth:`exchange` sends and fills rows 0 … n − 1 of all of them.
    """

    def __init__(
        self,
        master: Master,
        interface: str,
        slaves: Sequence[SlaveSpec],
        cycle_time_s: float = 0.0005,
        block_capacity: int = 1,
        pacing: Pacing | None = None,
        timeout_us: int | None = None,
        nonblocking_socket: bool = True,
        memory: tuple[NDArray[np.uint8], NDArray[np.uint8]] | None = None,
        whole_blocks: bool = True,
    ) -> None:
        self.interface = interface
        self.cycle_time_s = cycle_time_s
        self.block_capacity = block_capacity
        self.specs = check_specs(slaves)
        self._master = master
        self._pacing = pacing or FreeRunning(cycle_time_s)
        self._timeout_us = round(1e6 * CYCLES_TO_ANSWER * cycle_time_s) if timeout_us is None else timeout_us
        self._nonblocking = nonblocking_socket
        self._whole_blocks = whole_blocks
        out_memory, in_memory = memory or (None, None)
        self._out = Image.build([(spec.name, spec.outputs) for spec in self.specs], block_capacity, out_memory)
        self._in = Image.build([(spec.name, spec.inputs) for spec in self.specs], block_capacity, in_memory)
        self.outputs: Mapping[str, NDArray[Any]] = self._out.views
        self.sent: Mapping[str, NDArray[Any]] = self._out.views
        self.inputs: Mapping[str, NDArray[Any]] = self._in.views
        self._sdo: dict[str, SdoClient] = {}
        self._emergencies = EmergencyLog()
        self._exchanger: Exchanger | None = None
        self._configuration_errors: dict[str, DriverError] = {}
        self._sockets: frozenset[int] = frozenset()
        self._is_open = False
        self._claim = Claim(interface)

    def open(self) -> None:
        """Open the interface.

        Raises
        ------
        BusError
            If it does not exist, raw sockets are not allowed, or another master has it.
        """
        self._claim.take()
        before = nonblocking.packet_sockets() if self._nonblocking else frozenset()
        try:
            self._master.open(self.interface)
        except ConnectionError as error:
            self._claim.release()
            raise BusError(
                f"network interface '{self.interface}' cannot be opened; it should exist and the process should have "
                "CAP_NET_RAW and CAP_NET_ADMIN"
            ) from error
        self._is_open = True
        if self._nonblocking:
            self._sockets = nonblocking.packet_sockets() - before

    def configure(self) -> None:
        """Find the slaves, check who they are, set their process data and settings, map it: PREOP to SAFEOP.

        Raises
        ------
        IdentityError
            If the slaves are not those configured.
        DriverError
            From the settings of a slave, with the object and the reason.
        BusError
            If the mapped sizes differ from the configured ones, or SAFEOP is not reached.
        """
        for more in reversed(range(MAPPINGS)):
            try:
                found = self._mapped()
                break
            except UnmappedError:
                if not more:
                    raise
        set_up_clocks(self._master, self.specs)
        self._exchanger = make_exchanger(
            self._master,
            found,
            self._out,
            self._in,
            self.cycle_time_s,
            self._pacing,
            self._timeout_us,
            self._whole_blocks,
        )
        reach_safeop(self._master, self.specs)

    def _mapped(self) -> Sequence[Slave]:
        """The slaves, found, set up and mapped."""
        found = scan(self._master, self.specs, self.interface)
        for spec, slave in zip(self.specs, found, strict=True):
            self._sdo[spec.name] = SdoClient(slave, spec.name, self._drain)
            self._emergencies.listen(spec.name, slave)
            if spec.watchdog_s is not None:
                set_watchdog(slave, spec.name, spec.watchdog_s, self._drain)
            # config_init wipes the callback and config_map calls it, so this is the one place to set it.
            slave.config_func = self._callback(spec) if spec.coe else None
        map_process_data(self._master)
        check_sizes(self.specs, found, self._out, self._in)
        return found

    def to_operational(self) -> None:
        """Bring all slaves to OP while row 0 of the outputs is sent; SYNC0 starts where it is configured.

        Raises
        ------
        BusError
            With every slave that stays behind, its state and AL status.
        """
        # Not before: with a blocking socket a configuration frame has the patience of a jiffy, which a busy host needs.
        nonblocking.set_nonblocking(self._sockets)
        if isinstance(self._exchanger, CycleExchanger) and len(self._sockets) == 1:
            wait = nonblocking.FrameWait(next(iter(self._sockets)), self._timeout_us)
            self._exchanger.wait, self._exchanger.drain = wait, wait.drain
        for sdo in self._sdo.values():
            sdo.cycles_wait()
        start_sync0(self.specs, self._slaves(), self.cycle_time_s, lambda: self.exchange(1))
        attempts = math.ceil(_OP_TIMEOUT_S / self.cycle_time_s)
        reach_op(self._master, self.specs, lambda: int(self.exchange(1).wkc[-1]), attempts)

    @property
    def expected_wkc(self) -> int:
        """Working counter of a cycle in which every slave took its outputs and gave its inputs."""
        return self._master.expected_wkc

    def exchange(self, n: int = 1) -> Exchange:
        """Send rows 0 … n − 1 of the outputs, one a cycle, and fill the same rows of the inputs.

        Raises
        ------
        BusError
            If the bus is not configured or n is not within 1 … block_capacity.
        """
        if self._exchanger is None:
            raise BusError("the bus has no process data yet; configure() comes before exchange()")
        if not 1 <= n <= self.block_capacity:
            raise BusError(
                f"a block of {n} cycles was asked for; 1 to {self.block_capacity} fit the images of this bus"
            )
        return self._exchanger.run(n)

    @property
    def row_runner(self) -> Callable[[int], int]:
        """Function that sends one row now, fills that of the inputs and returns the working counter; it paces nothing.

        Raises
        ------
        BusError
            If the bus is not configured, or its master runs whole blocks.
        """
        if not isinstance(self._exchanger, CycleExchanger):
            raise BusError("single rows need a configured bus whose master does not run whole blocks")
        return self._exchanger.run_row

    def good(self, exchange: Exchange) -> NDArray[np.bool_]:
        """Mask (n_done,) of cycles with the full working counter; the inputs of the others are stale or partial."""
        return np.equal(exchange.wkc, self.expected_wkc)

    def sdo(self, name: str) -> SdoClient:
        """Object dictionary of a slave. Use it between cycles only: SDO beside running cycles disturbs them."""
        try:
            return self._sdo[name]
        except KeyError:
            known = ", ".join(spec.name for spec in self.specs)
            raise BusError(f"'{name}' is no configured slave of this bus; it has {known}") from None

    def sdo_read(self, name: str, index: int, subindex: int, type_: str) -> int:
        """Read an integer object of a slave (:meth:`SdoClient.read`)."""
        return self.sdo(name).read(index, subindex, type_)

    def sdo_write(self, name: str, index: int, subindex: int, type_: str, value: int) -> None:
        """Write an integer object of a slave (:meth:`SdoClient.write`)."""
        self.sdo(name).write(index, subindex, type_, value)

    def emergencies(self) -> tuple[EmergencyMessage, ...]:
        """Look into the mailboxes (between cycles only) and return the emergency messages since the last call."""
        self._emergencies.poll(self._slaves())
        return self._emergencies.take()

    def recover(self) -> tuple[Recovery, ...]:
        """Take one step of recovery for every slave that left OP; the caller bounds how often.

        Raises
        ------
        DriverError
            If the settings of a slave that came back cannot be restored.
        """
        self._configuration_errors.clear()
        steps = recover_step(self._master, self.specs)
        for step in steps:
            if step.condition in (Condition.RECONFIGURED, Condition.FAILED) and step.name in self._configuration_errors:
                raise self._configuration_errors[step.name]
        return steps

    def close(self) -> None:
        """Bring all slaves to INIT, in which none holds outputs, and close the interface, whatever happened before."""
        if not self._is_open:
            return
        try:
            if self._master.slaves:
                self._out.bytes[:] = 0
                reach_init(self._master)
        finally:
            self._exchanger = None
            self._sockets = frozenset()
            self._is_open = False
            self._master.close()
            self._claim.release()

    def __enter__(self) -> EtherCatBus:
        self.open()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _drain(self) -> None:
        for descriptor in self._sockets:
            nonblocking.drain(descriptor)

    def _slaves(self) -> Sequence[Slave]:
        return self._master.slaves or ()

    def _callback(self, spec: SlaveSpec) -> Callable[[int], None]:
        def configure(_position: int) -> None:
            sdo = self._sdo[spec.name]
            try:
                assign_pdos(sdo, spec)
                if spec.configure is not None:
                    spec.configure(sdo)
            except DriverError as error:
                # pysoem raises it again from config_map but swallows it in reconfig: keep it for recover().
                self._configuration_errors[spec.name] = error
                raise

        return configure
