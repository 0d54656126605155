"""The benchmark of opening measures what it says; how long it takes depends on the machine and is no test."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from bench.matrix.opening_times import WAITED_FOR, _processor_s, measure_opening

WORKS = "sum(i * i for i in range(2_000_000))"


def test_every_wait_is_measured_once_a_round() -> None:
    heard: list[str] = []
    # the name of a socket may have 107 bytes, and pytest's folders are deep
    with TemporaryDirectory(prefix="open") as folder:
        found = measure_opening(1, Path(folder), heard.append, real_time=False)
    assert [wait.name for wait in found.waits] == list(WAITED_FOR)
    for wait in found.waits:
        assert len(wait.wall_s) == len(wait.cpu_s) == 1
        assert wait.wall_s[0] == wait.median_s > 0.0
        assert wait.median_cpu_s > 0.0
    assert heard == ["round 1 of 1"]
    assert set(found.as_dict()) == {"waits", "load", "processors"}


def test_processor_time_counts_a_process_that_has_ended() -> None:
    before = _processor_s(os.getpid())
    subprocess.run([sys.executable, "-c", WORKS], check=True)
    assert _processor_s(os.getpid()) >= before + 0.02
