"""A reader that goes away, as ``head`` does: the command ends as it would have, and quietly."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = [sys.executable, "-c", "from bench.cli import main; main()"]


@pytest.mark.parametrize(
    ("arguments", "code"), [(["config", "rh380n"], 0), (["plan", "quick"], 0), (["--help"], 0), (["config", "none"], 3)]
)
def test_a_closed_pipe_is_no_fault_of_this_program(arguments: list[str], code: int, tmp_path: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        done = subprocess.run([*PROGRAM, *arguments], stdout=writing, stderr=subprocess.PIPE, cwd=tmp_path, check=False)
    finally:
        os.close(writing)
    assert done.returncode == code
    assert (done.stderr == b"") == (code == 0)
