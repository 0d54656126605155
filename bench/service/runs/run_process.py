"""The process of a run: where its files and its socket are, and whether it still lives."""

from __future__ import annotations

from pathlib import Path

from bench.safety.runtime import socket_path
from bench.service.runs.launcher import Launcher
from bench.service.runs.runs import Run, process_of

SOCKET = ".sock"
"""Ends the name of the socket of a run, which begins with the run's id."""


class RunProcesses:
    """Looks after processes by their runs.

    Parameters
    ----------
    state : folder of the service's own files.
    launcher : hears of the end of the processes it started.
    """

    def __init__(self, state: Path, launcher: Launcher) -> None:
        self._state, self._launcher = state, launcher
        self._sockets: dict[str, Path] = {}

    def live(self, run: Run) -> bool:
        """Whether the process of a run still lives (and is the very one: process ids are used again)."""
        if run.pid is None or self._launcher.exit_code(run.pid) is not None:
            return False
        if self._launcher.has_started(run.pid):
            # its end will be heard of; right after its start the command line may still be empty
            return True
        return process_of(self.folder(run) / "job.json", run.pid) is not None

    def exit_code(self, run: Run) -> int | None:
        """Exit code of a process that has ended, None where it is not known."""
        return None if run.pid is None else self._launcher.exit_code(run.pid)

    def folder(self, run: Run) -> Path:
        """Folder of the files between the service and the process."""
        return self._state.absolute() / "runs" / run.id

    def socket(self, run: Run) -> Path:
        """Return the socket of a run; its folder is looked at once, for STOP must not wait for a disk."""
        if run.id not in self._sockets:
            # not beside the recordings: their folders may have long names, and paths of sockets may not
            self._sockets = {run.id: socket_path(f"{run.id}{SOCKET}")}
        return self._sockets[run.id]
