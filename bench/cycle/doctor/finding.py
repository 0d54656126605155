"""What one check has found."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any


class State(StrEnum):
    """How good it is."""

    GOOD = "good"
    ADVICE = "advice"
    """Works, better otherwise."""
    BAD = "bad"
    """A bench on hardware does not run, or not punctually."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One check: what it looked at, how good that is, what was found, what to change (empty if nothing)."""

    check: str
    state: State
    found: str
    change: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For a script."""
        return asdict(self)


def good(check: str, found: str) -> Finding:
    """Return a finding that asks for nothing."""
    return Finding(check, State.GOOD, found)


def advice(check: str, found: str, change: str) -> Finding:
    """Return a finding that would be better otherwise."""
    return Finding(check, State.ADVICE, found, change)


def bad(check: str, found: str, change: str) -> Finding:
    """Return a finding that must be changed."""
    return Finding(check, State.BAD, found, change)
