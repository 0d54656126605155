"""The order for a twin's process. Imports nothing heavy."""

from __future__ import annotations

from dataclasses import dataclass

LOWEST = 19
"""beside a bench that keeps the clock's pace"""
BESIDE_EMULATED = 10
"""beside an emulated bench that runs as fast as it can: there is no cycle to touch"""


@dataclass(frozen=True, slots=True)
class Job:
    """Which ``folder`` is watched, with which ``model``, at which ``nice`` value."""

    folder: str
    model: str
    nice: int = LOWEST
