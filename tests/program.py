"""The program ``bench``, run in this process: starting one takes longer than most of what tests ask of it."""

from __future__ import annotations

import io
import sys
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from unittest.mock import patch

from bench.cli import main


@dataclass(frozen=True, slots=True)
class Done:
    """How the program ended, and what it said."""

    code: int
    out: str
    err: str


def bench(arguments: Sequence[str]) -> Done:
    """Run ``bench`` with its arguments, in the folder that is the current one."""
    out, err = io.StringIO(), io.StringIO()
    code = 0
    with patch.object(sys, "argv", ["bench", *arguments]), redirect_stdout(out), redirect_stderr(err):
        try:
            main()
        except SystemExit as end:
            code = int(end.code or 0)
    return Done(code, out.getvalue(), err.getvalue())
