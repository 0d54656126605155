"""What the service looks at all the time: room on the disk, its own files, its keeper, a silent run."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING

from bench.errors import BenchError
from bench.service.book import local_time
from bench.service.registry import runtime_folder
from bench.service.seen import SEEN_EVERY_S
from bench.service.stop_listener import stop_port

if TYPE_CHECKING:
    from bench.service.service import Service

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


async def look_at_disk(service: Service) -> None:
    """Say that room becomes scarce before a run has to stop for it, and that there is room again."""
    said = await asyncio.to_thread(service.storage)
    service.alarms.set("DISK", None if said["enough"] else f"the disk of {said['folder']} is nearly full")


async def look_at_itself(service: Service) -> None:
    """Let alarms of the service itself and of a silent run stand as long as they are true."""
    service.alarms.set("STATE_FOLDER", service.disk.trouble)
    service.alarms.set("KEEPER", service.keeper.trouble)
    service.alarms.set("SILENT", service.keeper.silent)
    if time.monotonic() - service.said_seen >= SEEN_EVERY_S:
        service.said_seen = time.monotonic()
        service.disk.replace(service.seen, local_time())
    port = await asyncio.to_thread(lambda: stop_port(runtime_folder()))
    if port != service.stop_port:
        service.stop_port = port
        service.tell_state()
