"""What the service looks at all the time: room on the disk, its own files, its keeper, a silent run."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from bench.errors import BenchError
from bench.safety.runtime import runtime_folder
from bench.service.alarms.alarms import Alarms
from bench.service.files.book import local_time
from bench.service.files.disk import Disk
from bench.service.files.seen import SEEN_EVERY_S
from bench.service.runs.keeper import Keeper
from bench.service.runs.stop_listener import stop_port

_LOG = logging.getLogger(__name__)
DISK_EVERY_S = 60.0
LOOK_EVERY_S = 0.5


async def watch(look: Callable[[], Awaitable[None]], every_s: float) -> None:
    """Look now and then for ever; an error of one look is logged, and the next is taken all the same."""
    while True:
        try:
            await look()
        except (OSError, BenchError):
            _LOG.exception("a look of the service at itself")
        await asyncio.sleep(every_s)


async def look_at_disk(alarms: Alarms, storage: Callable[[], dict[str, Any]]) -> None:
    """Say that room becomes scarce before a run has to stop for it, and that there is room again."""
    said = await asyncio.to_thread(storage)
    alarms.set("DISK", None if said["enough"] else f"the disk of {said['folder']} is nearly full")


class SelfWatch:
    """Alarms of the service itself and of a silent run, the file that says it lives, and the run's stop port.

    ``publish_state`` informs the pages; ``seen`` is the file that says when the service was last alive.
    """

    def __init__(
        self, alarms: Alarms, disk: Disk, keeper: Keeper, seen: Path, publish_state: Callable[[], None]
    ) -> None:
        self._alarms = alarms
        self._disk = disk
        self._keeper = keeper
        self._seen = seen
        self._publish_state = publish_state
        self._said_seen = 0.0  # when the file was written last, s of the monotonic clock
        self.stop_port: int | None = None
        """Of the run's own stop listener, for the pages."""

    async def look(self) -> None:
        """Let alarms of the service itself and of a silent run stand as long as they are true."""
        self._alarms.set("STATE_FOLDER", self._disk.trouble)
        self._alarms.set("KEEPER", self._keeper.trouble)
        self._alarms.set("SILENT", self._keeper.silent)
        if time.monotonic() - self._said_seen >= SEEN_EVERY_S:
            self._said_seen = time.monotonic()
            self._disk.replace(self._seen, local_time())
        port = await asyncio.to_thread(lambda: stop_port(runtime_folder()))
        if port != self.stop_port:
            self.stop_port = port
            self._publish_state()
