"""Between two runs: a process stands ready for the next and reads the bench without torque; pages see what it reads."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench.configuration import BenchFile
from bench.safety.runtime import socket_path
from bench.service.process.ready import Spec
from bench.service.runs.launcher import Launcher
from bench.service.runs.process_link import ProcessLink
from bench.service.settings import Settings

Message = dict[str, Any]
_LOOK_S = 0.5
_BEGIN_S = 180.0
"""Loading the program may take so long where the compiled loops have to be made."""


class Idle:
    """Keeps one process ready while nothing runs.

    Parameters
    ----------
    busy : whether a run has the bench, or waits for it.
    take : is given each message of the process: ``condition``, or ``unread`` and why.
    """

    def __init__(
        self,
        settings: Settings,
        bench: BenchFile,
        plant: str | None,
        launcher: Launcher,
        busy: Callable[[], bool],
        take: Callable[[Message], None],
    ) -> None:
        self._launcher, self._busy, self._take = launcher, busy, take
        reads = bench.configuration.bus.in_process or settings.watch
        self._spec = Spec("", settings.bench, settings.interface, plant, reads)
        self._socket = Path("none-yet")
        self._task: asyncio.Task[None] | None = None

    def open(self) -> None:
        """Begin."""
        self._task = asyncio.get_running_loop().create_task(self._work())

    async def close(self) -> None:
        """End; the process that stands ready ends with the launcher."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task

    async def _work(self) -> None:
        while True:
            # one that stands ready already, because the run that was to begin did not, is followed further
            if not self._busy() and not await self._follow(0.0):
                self._socket = socket_path(f"idle-{secrets.token_hex(8)}.sock")
                self._launcher.stand_ready(replace(self._spec, socket=str(self._socket)))
                await self._follow(_BEGIN_S)
            await asyncio.sleep(_LOOK_S)

    async def _follow(self, patience_s: float) -> bool:
        """Hand on what it sends, until a run takes it or it is gone; whether anything was heard within the patience."""
        clock = asyncio.get_running_loop().time
        deadline = clock() + patience_s
        heard: list[Message] = []
        link = ProcessLink(self._socket)
        async for message in link.messages(lambda: not (heard or self._busy() or clock() >= deadline)):
            heard[:] = [message]
            self._take(message)
        return bool(heard)
