"""A function over many items gives the same in one process and in several."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import bench
from bench.processes import over
from bench.stop_button.find import is_alive

BEGIN = "from tests.bench.test_processes import _stay; from bench.processes import over; list(over(_stay, {}, jobs=2))"
LONG_S = 60.0


def _square_and_process(number: int) -> tuple[int, int]:
    return number * number, os.getpid()


def test_results_come_in_order_and_from_other_processes() -> None:
    here = list(over(_square_and_process, range(7)))
    apart = list(over(_square_and_process, range(7), jobs=2, chunk=2))
    assert [square for square, _ in here] == [square for square, _ in apart] == [0, 1, 4, 9, 16, 25, 36]
    assert {process for _, process in here} == {os.getpid()}
    assert os.getpid() not in {process for _, process in apart}


def test_nothing_to_do_is_nothing_done() -> None:
    assert list(over(_square_and_process, [], jobs=4)) == []


def _stay(file: str) -> None:
    Path(file).write_text(str(os.getpid()))
    time.sleep(LONG_S)


def test_workers_end_with_the_process_that_began_them(tmp_path: Path) -> None:
    """A worker whose parent was killed would wait for work for ever, and hold its memory."""
    files = [tmp_path / "a", tmp_path / "b"]
    begin = BEGIN.format([str(file) for file in files])
    parent = subprocess.Popen([sys.executable, "-c", begin], cwd=Path(bench.__file__).parents[1])
    until = time.monotonic() + LONG_S
    while not all(file.exists() and file.read_text() for file in files) and time.monotonic() < until:
        time.sleep(0.05)
    processes = [int(file.read_text()) for file in files]
    assert all(map(is_alive, processes))
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    until = time.monotonic() + 0.5 * LONG_S
    while any(map(is_alive, processes)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(is_alive, processes))
