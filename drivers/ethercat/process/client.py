"""Start a bus process, ask it things, notice its end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from multiprocessing.connection import Pipe
from typing import Any

from drivers.errors import BusError, DriverError
from drivers.ethercat.process.remote_sdo import RemoteSdo
from drivers.ethercat.process.settings import Setup
from drivers.ethercat.sdo import SdoClient

_ANSWER_S = 60.0
"""Longest wait for an answer: finding and configuring slaves takes seconds."""
_CLOSING_S = 10.0

Configure = Callable[[SdoClient], None]


class Client:
    """One bus process and the pipe to it.

    Parameters
    ----------
    setup : what the process starts with.
    memory : descriptor of the shared memory.
    configure : by slave, what is run here when the process configures it.

    Attributes
    ----------
    ended : a sentence once the process has ended by itself, else None.
    """

    def __init__(self, setup: Setup, memory: int, configure: Mapping[str, Configure]) -> None:
        self._configure = configure
        self.ended: str | None = None
        self._pipe, far = Pipe()
        descriptors = (far.fileno(), memory)
        self._process = subprocess.Popen(
            [sys.executable, "-m", "drivers.ethercat.process", *map(str, descriptors)],
            pass_fds=descriptors,
            stdin=subprocess.DEVNULL,
            # Ctrl-C in the terminal is the rig's to answer, with a ramp
            start_new_session=True,
        )
        far.close()
        self._send(setup)

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def ask(self, verb: str, *arguments: Any) -> Any:
        """Send an order and return its result; serves what the process asks meanwhile.

        Raises
        ------
        DriverError
            What the order raised there, or that the process has ended.
        """
        self._send((verb, *arguments))
        while True:
            answer, result = self._receive()
            if answer == "configure":
                self._run_configure(result)
            elif answer == "failed":
                raise result
            else:
                return result

    def look(self) -> bool:
        """Whether the process lives; sets :attr:`ended` when it does not."""
        if self.ended is None and self._process.poll() is not None:
            self.ended = _obituary(self._process.returncode)
        return self.ended is None

    def close(self) -> None:
        """Have the bus closed and the process end; afterwards it has ended, whatever it answered."""
        try:
            if self.look():
                self.ask("close")
                self._process.wait(_CLOSING_S)
        except (DriverError, subprocess.TimeoutExpired):
            self._process.terminate()
        finally:
            self._pipe.close()
            try:
                self._process.wait(_CLOSING_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def _run_configure(self, name: str) -> None:
        raised: DriverError | None = None
        try:
            self._configure[name](RemoteSdo(self.ask, name))
        except DriverError as error:
            raised = error
        self._send(("configured", raised))

    def _send(self, message: Any) -> None:
        try:
            self._pipe.send(message)
        except OSError as error:
            raise self._ended_error() from error

    def _receive(self) -> tuple[str, Any]:
        try:
            if not self._pipe.poll(_ANSWER_S):
                raise BusError(f"the bus process (pid {self.pid}) did not answer within {_ANSWER_S:g} s")
            message: tuple[str, Any] = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise self._ended_error() from error
        return message

    def _ended_error(self) -> BusError:
        try:
            self._process.wait(_CLOSING_S)
        except subprocess.TimeoutExpired:
            return BusError(f"the bus process (pid {self.pid}) has closed its pipe but does not end")
        self.look()
        return BusError(self.ended or "the bus process has ended")


def _obituary(code: int) -> str:
    how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with exit code {code}"
    return f"the bus process {how}: nobody sends process data, and whether the drives' watchdogs stop them nobody sees"


def reserve_memory(size: int) -> int:
    """Return the descriptor of ``size`` bytes of memory that can be shared and vanishes with its last user."""
    descriptor = os.memfd_create("bench-bus", os.MFD_CLOEXEC)
    os.ftruncate(descriptor, size)
    return descriptor
