"""Who is told how a campaign goes: the terminal, a page, a script, or nobody."""

from __future__ import annotations

from typing import Protocol

from bench.campaigns.schedule import Task
from bench.campaigns.taken import Taken


class Listener(Protocol):
    """Is told how a campaign goes."""

    def started(self, task: Task, recording_id: str) -> None:
        """A recording begins."""
        ...

    def advanced(self, bench_time_s: float, temperature: float) -> None:
        """Bench time went on."""
        ...

    def finished(self, taken: Taken) -> None:
        """A recording is in its file."""
        ...


class Silent:
    """A listener for whoever does not want to know."""

    def started(self, task: Task, recording_id: str) -> None:
        """Do nothing."""

    def advanced(self, bench_time_s: float, temperature: float) -> None:
        """Do nothing."""

    def finished(self, taken: Taken) -> None:
        """Do nothing."""
