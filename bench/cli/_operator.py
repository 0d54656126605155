"""Is there a person? Acts that give torque back want one at a terminal, unless the bench file lets a script do them."""

from __future__ import annotations

import getpass
import sys

import typer

from bench.configuration import BenchConfiguration
from bench.errors import LimitError


def somebody(bench: BenchConfiguration, act: str, question: str) -> str:
    """Return who does an act, after asking at the terminal.

    Raises
    ------
    LimitError
        If nobody is at a terminal and ``unattended.may`` of the bench file does not name the act, or the answer is no.
    """
    name = getpass.getuser()
    if sys.stdin.isatty():
        if not typer.confirm(question, err=True):
            raise LimitError(f"{act} was not confirmed; nothing was done")
        return name
    if act not in bench.unattended.may:
        raise LimitError(
            f"{act} wants a person at a terminal; a script may do it where unattended.may of the bench file names it"
        )
    return f"script of {name}"
