"""The child of :mod:`bench.recording.guarded`: runs what it is sent, one function after another."""

from __future__ import annotations

import math
import os
import pickle
import resource
import signal
import sys
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

from bench.recording import guarded


def main() -> None:
    """Serve the connection of the descriptor given until its other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer
    resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[2]),) * 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.argv[3] == "inside":
        guarded.be_inside()
    with Connection(int(sys.argv[1])) as connection:
        while True:
            try:
                question = connection.recv_bytes()
            except EOFError:
                return
            connection.send_bytes(_answer(question))


def _answer(question: bytes) -> bytes:
    try:
        function, args, more, cpu_s, folder = pickle.loads(question)
        _limit_processor_time(cpu_s)
        if folder is not None:
            with suppress(OSError):  # a folder that is gone: whole paths are read all the same
                os.chdir(folder)
        return pickle.dumps((True, function(*args, **more)))
    except Exception as error:  # noqa: BLE001  # whatever it is, it is the caller's to see
        error.__traceback__ = None
        error.__cause__ = None
        return _pickled_error(error)


def _limit_processor_time(cpu_s: float | None) -> None:
    """End this process by SIGXCPU when it has taken ``cpu_s`` more than so far."""
    if cpu_s is not None:
        taken = resource.getrusage(resource.RUSAGE_SELF)
        soft = math.ceil(taken.ru_utime + taken.ru_stime + cpu_s)
        resource.setrlimit(resource.RLIMIT_CPU, (soft, resource.RLIM_INFINITY))


def _pickled_error(error: Exception) -> bytes:
    answer: tuple[bool, Any] = (False, error)
    try:
        data = pickle.dumps(answer)
        pickle.loads(data)
    except Exception:  # noqa: BLE001  # errors of other libraries that cannot be pickled
        return pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))
    return data


if __name__ == "__main__":
    main()
