"""Something else for the machine to do: an identification, over and over, on a processor that is not the master's."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bench.errors import BenchError

_BENCH = "from bench.cli import main; main()"
_AGAIN = """
import subprocess, sys
while True:
    subprocess.run([sys.executable, "-c", sys.argv[1], "identify", sys.argv[2], "--out", sys.argv[3], "--jobs", "1"],
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
"""


@contextmanager
def identification(folder: Path, cpus: set[int] | None) -> Iterator[None]:
    """Identify a small campaign again and again while the context lasts, on these processors (None: any).

    Raises
    ------
    BenchError
        If the campaign to be identified cannot be made.
    """
    recordings = folder / "recordings"
    made = subprocess.run(
        [sys.executable, "-c", _BENCH, "run", "quick", "--out", str(recordings), "--json"],
        capture_output=True,
        text=True,
        check=False,
    )
    if made.returncode != 0:
        raise BenchError(f"the campaign for the load could not be made: {made.stderr.strip()}")
    process = subprocess.Popen(
        [sys.executable, "-c", _AGAIN, _BENCH, str(recordings), str(folder / "model.json")], start_new_session=True
    )
    try:
        if cpus:
            os.sched_setaffinity(process.pid, cpus)
        yield
    finally:
        # the loop and the identification it runs are one session
        os.killpg(process.pid, 9)
        process.wait()
