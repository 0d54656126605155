"""The bus process: owns the master, does what the rig asks until the bus is operational, then cycles."""

from __future__ import annotations

import os
import pickle
import select
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from multiprocessing.connection import Connection
from typing import Any

from drivers.errors import BusError, DriverError
from drivers.ethercat.bus import CYCLES_TO_ANSWER, EtherCatBus
from drivers.ethercat.pacing import AbsoluteDeadlines
from drivers.ethercat.process import layout as at
from drivers.ethercat.process.cyclic import Cyclic
from drivers.ethercat.process.guard import Guard, Reason
from drivers.ethercat.process.layout import Shared
from drivers.ethercat.process.realtime import become_real_time
from drivers.ethercat.process.settings import Protection, Setup
from drivers.ethercat.sdo import SdoClient

_WAITING = 0.75
"""Part of the time slots are made up for that a frame is waited for."""


class RigGoneError(Exception):
    """The rig's end of the pipe is closed."""


class Server:
    """Serves one rig over one pipe.

    Messages are tuples: a verb and its arguments; the answer is ``("done", result)`` or ``("failed", exception)``.
    While a slave is configured, the process asks the rig: ``("configure", name)``, and serves its SDO accesses until
    ``("configured", None or an exception)`` comes.
    """

    def __init__(self, pipe: Connection, shared: Shared, setup: Setup) -> None:
        self._pipe, self._shared, self._setup = pipe, shared, setup
        module, _, function = setup.master.partition(":")
        master = getattr(import_module(module), function)(**setup.arguments)
        self._pacing = AbsoluteDeadlines(setup.cycle_time_s, make_up_s=setup.make_up_s)
        slaves = [
            replace(spec, configure=self._configurer(spec.name) if has else None)
            for spec, has in zip(setup.slaves, setup.has_configure, strict=True)
        ]
        self._bus = EtherCatBus(
            master,
            setup.interface,
            slaves,
            setup.cycle_time_s,
            block_capacity=setup.image_rows,
            pacing=self._pacing,
            # slots that pass meanwhile are made up for, so waiting for an answer costs nothing
            timeout_us=round(1e6 * max(CYCLES_TO_ANSWER * setup.cycle_time_s, _WAITING * setup.make_up_s)),
            memory=(shared.sent, shared.inputs),
            whole_blocks=False,
        )
        self._poll = select.poll()
        self._poll.register(pipe.fileno(), select.POLLIN | select.POLLHUP)
        self._cyclic: Cyclic | None = None
        self._protection = Protection()
        self._notes: tuple[str, ...] = ()
        self._orders: dict[str, Callable[..., Any]] = {
            "open": self._open,
            "configure": self._bus.configure,
            "to_operational": self._to_operational,
            "protect": self._protect,
            "sdo": self._sdo,
            "emergencies": self._bus.emergencies,
            "recover": self._bus.recover,
            "close": self._leave,
        }

    def run(self) -> None:
        """Serve until the rig says close, or has gone and the drives are at rest."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, lambda *_: self._terminate())
        try:
            while self._cyclic is None:
                self._serve_one()
            self._cyclic.run()
        except RigGoneError:
            pass  # before the bus was operational: nothing has moved
        finally:
            self._shared.words[at.STATE] = at.CLOSED
            self._bus.close()
        with suppress(OSError):  # nobody may be left to receive it
            self._pipe.send(("done", None))

    # -- orders ---------------------------------------------------------------------------------------------------

    def _open(self) -> tuple[str, ...]:
        self._notes = become_real_time(self._setup.real_time)
        self._shared.words[at.PID] = os.getpid()
        self._bus.open()
        return self._notes

    def _to_operational(self, outputs: bytes) -> int:
        width = self._shared.layout.out_width
        self._shared.sent[0, :width] = memoryview(outputs)
        self._bus.to_operational()
        expected = self._bus.expected_wkc
        self._shared.words[at.EXPECTED_WKC] = expected
        cyclic = Cyclic(self._shared, self._bus.row_runner, self._pacing, time.monotonic_ns, self._look)
        cyclic.start(outputs)
        cyclic.guard = Guard(self._protection, self._setup.slaves, expected)
        self._cyclic = cyclic
        return expected

    def _protect(self, protection: Protection) -> None:
        self._protection = protection
        if self._cyclic is not None:
            self._cyclic.guard = Guard(protection, self._setup.slaves, self._shared.words[at.EXPECTED_WKC])

    def _sdo(self, name: str, method: str, *arguments: Any) -> Any:
        return getattr(self._bus.sdo(name), method)(*arguments)

    def _leave(self) -> None:
        if self._cyclic is None:
            raise RigGoneError
        self._cyclic.leaving = True

    def _terminate(self) -> None:
        if self._cyclic is None:
            raise RigGoneError
        self._cyclic.end_when_stopped = True
        self._cyclic.stop(Reason.TERMINATED)

    # -- the pipe -------------------------------------------------------------------------------------------------

    def _look(self) -> bool:
        """Serve an order if there is one; False when the rig has gone."""
        if not self._poll.poll(0):
            return True
        try:
            self._serve_one()
        except RigGoneError:
            self._poll.unregister(self._pipe.fileno())
            return False
        return True

    def _serve_one(self) -> None:
        verb, *arguments = self._receive()
        if verb == "close":
            self._leave()  # answered when the bus is closed
            return
        self._answer(self._orders[verb], *arguments)

    def _answer(self, order: Callable[..., Any], *arguments: Any) -> None:
        try:
            answer = ("done", order(*arguments))
        except DriverError as error:
            answer = ("failed", _portable(error))
        self._send(answer)

    def _configurer(self, name: str) -> Callable[[SdoClient], None]:
        def configure(_sdo: SdoClient) -> None:
            self._send(("configure", name))
            while True:
                verb, *arguments = self._receive()
                if verb == "configured":
                    if arguments[0] is not None:
                        raise arguments[0]
                    return
                self._answer(self._orders[verb], *arguments)

        return configure

    def _receive(self) -> tuple[Any, ...]:
        try:
            message: tuple[Any, ...] = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise RigGoneError from error
        return message

    def _send(self, message: tuple[Any, ...]) -> None:
        try:
            self._pipe.send(message)
        except OSError as error:
            raise RigGoneError from error


def _portable(error: DriverError) -> DriverError:
    """Return the error itself if it survives being sent, else one with its sentence."""
    try:
        pickle.loads(pickle.dumps(error))
    except TypeError:
        return BusError(str(error))
    error.__cause__ = error.__context__ = None
    return error


def serve(pipe_descriptor: int, memory_descriptor: int) -> None:
    """Run a bus process on two inherited descriptors; the first message on the pipe is its :class:`Setup`."""
    pipe = Connection(pipe_descriptor)
    setup: Setup = pipe.recv()
    out_width = _width(setup, "outputs")
    layout = at.Layout(out_width, _width(setup, "inputs"), setup.set_rows, setup.image_rows)
    Server(pipe, Shared(memory_descriptor, layout), setup).run()


def _width(setup: Setup, direction: str) -> int:
    from drivers.entries import entries_dtype

    return sum(entries_dtype(getattr(spec, direction)).itemsize for spec in setup.slaves)
