"""Files are opened in a child process: one flipped bit can crash the HDF5 library, and what uses it, by a signal.

A file is a stranger: a kill, a bad disk or another program may have written anything into it. :func:`call` runs a
function on it in a child that lives on for the next file, within limits of memory and time. A crash, a hang or too much
memory becomes one :class:`~bench.errors.RecordingError` that names the file; the caller lives on.
"""

from __future__ import annotations

import atexit
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

from bench.errors import RecordingError

P = ParamSpec("P")
R = TypeVar("R")

MEMORY_BYTES = 4 << 30
"""Address space of a child. An hour of recording at 2 kHz takes some 400 MB to validate."""
TIME_S = 30.0
"""A header takes milliseconds; a network share that wakes up takes seconds."""
CPU_S = 5.0
"""Processor time: some damaged files send the HDF5 library round in circles for ever."""
_STARVED_LOOK_S = 0.5
"""How often a child that is over its time is looked at: on a busy machine it may only be waiting for a processor."""
SLOWEST_BYTES_S = 1e6
"""What is read to its end may take a second more for each of these, of either time."""
_IDLE_CHILDREN = 2
_GOODBYE_S = 1.0

_inside = False
_idle: list[Child] = []
_stuck: list[subprocess.Popen[bytes]] = []
_lock = threading.Lock()


class Gone(Exception):
    """The child has ended while it was asked."""


def call(path: Path, function: Callable[P, R], *args: P.args, **more: P.kwargs) -> R:
    """Return ``function(*args, **more)``, run in a child process; ``path`` is the file it reads, for the sentences.

    The function stands at the top of a module, and what it takes and gives can be pickled. It is given
    :data:`TIME_S`, or :data:`CPU_S` of processor time, and the time to read the file once at :data:`SLOWEST_BYTES_S`.
    A child that computes, or would if it were given a processor, is judged by its processor time alone. Relative paths
    mean what they mean here. Callable from any thread.

    Raises
    ------
    RecordingError
        The child crashed, took too long or too much memory. What the function itself raises is raised as it is.
    """
    if _inside:
        return function(*args, **more)
    limit_s = TIME_S + _size(path) / SLOWEST_BYTES_S
    cpu_s = limit_s - TIME_S + CPU_S
    while True:
        child = _take()
        fresh = child.fresh
        try:
            done, result = child.ask((function, args, more, cpu_s, _working_folder()), limit_s)
        except TimeoutError:
            child.end()
            text = f"{path}: could not be read within {limit_s:.0f} s; the disk does not answer or the file is damaged."
            raise RecordingError(text) from None
        except Gone:
            code = child.end()
            if code == -signal.SIGXCPU:
                text = f"{path}: cannot be read within {cpu_s:.0f} s of processor time; the file is damaged."
                raise RecordingError(text) from None
            if not fresh:
                continue  # an earlier file may have left the child in disorder: ask one that has seen none
            text = f"{path}: reading it ended in a crash of the HDF5 library ({_cause(code)}); the file is damaged."
            raise RecordingError(text) from None
        _give_back(child)
        if done:
            return cast(R, result)
        if isinstance(result, MemoryError):
            gib = MEMORY_BYTES / (1 << 30)
            raise RecordingError(f"{path}: cannot be read within {gib:.0f} GiB of memory; the file is damaged.")
        raise result


class Child:
    """A process that runs one function after another; ``inside`` if what it reads needs no child of its own."""

    def __init__(self, inside: bool = True) -> None:
        self.fresh = True
        self._taken: int | None = None
        self._connection: Connection
        self._connection, far = Pipe()
        with far:
            limits = (str(far.fileno()), str(MEMORY_BYTES), "inside" if inside else "outside")
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "bench.recording._guarded_child", *limits],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=(far.fileno(),),
                env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            )

    def ask(self, question: Any, limit_s: float) -> tuple[bool, Any]:
        """Return whether the function returned, and what it returned or raised.

        ``question`` is function, arguments, named arguments, the processor time in s (None: no limit) and the folder
        that relative paths start from.

        Raises
        ------
        Gone, TimeoutError
            The process has ended, or has not answered within ``limit_s`` and waits for something other than a
            processor; it is of no use any more: ``end`` it.
        """
        self.fresh = False
        try:
            self._connection.send_bytes(pickle.dumps(question))
            wait_s = limit_s
            while not self._connection.poll(wait_s):
                taken, self._taken = self._taken, self._processor_time()
                if not self._is_runnable() and taken == self._taken:
                    raise TimeoutError
                wait_s = _STARVED_LOOK_S
            return cast(tuple[bool, Any], self._connection.recv())
        except (EOFError, ConnectionError, pickle.UnpicklingError) as error:
            raise Gone from error

    def _is_runnable(self) -> bool:
        return any(_stat(pid)[:1] == ["R"] for pid in _family(self._process.pid))

    def _processor_time(self) -> int:
        """Return the ticks of processor time taken so far (user and system), with those of its own children."""
        stats = [_stat(pid) for pid in _family(self._process.pid)]
        return sum(int(fields[11]) + int(fields[12]) for fields in stats if len(fields) > 12)

    def end(self) -> int | None:
        """End the process and return its exit code; None where the kernel does not let it go yet."""
        self._connection.close()
        try:
            return self._process.wait(_GOODBYE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
        try:
            return self._process.wait(_GOODBYE_S)
        except subprocess.TimeoutExpired:
            _stuck.append(self._process)  # it waits for a disk
            return None


def _stat(pid: int) -> list[str]:
    """Return the state of a process and what follows it in ``/proc/PID/stat``; empty where it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text("utf-8").rpartition(")")[2].split()
    except OSError:
        return []


def _family(pid: int) -> list[int]:
    """Return a process and all that came from it: a child that waits for its own child computes through that one."""
    found = [pid]
    for parent in found:
        for children in Path(f"/proc/{parent}/task").glob("*/children"):
            with suppress(OSError):
                found += [int(child) for child in children.read_text("utf-8").split()]
    return found


def _take() -> Child:
    with _lock:
        if _idle:
            return _idle.pop()
    return Child()


def _give_back(child: Child) -> None:
    with _lock:
        if len(_idle) < _IDLE_CHILDREN:
            _idle.append(child)
            return
    child.end()


def _working_folder() -> str | None:
    """Return the folder that relative paths start from; None where it is gone, and no relative path leads anywhere."""
    try:
        return os.getcwd()
    except OSError:
        return None


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0  # the function says what is wrong with it


def _cause(code: int | None) -> str:
    if code is None or code >= 0:
        return f"exit code {code}"
    return signal.Signals(-code).name


def be_inside() -> None:
    """Mark this process as a child: it makes guarded calls itself."""
    global _inside
    _inside = True


def _close() -> None:
    while _idle:
        _idle.pop().end()


def _forget() -> None:
    """The children of the parent are not those of its fork."""
    global _lock
    _lock = threading.Lock()
    _stuck.extend(child._process for child in _idle)
    _idle.clear()


atexit.register(_close)
os.register_at_fork(after_in_child=_forget)
