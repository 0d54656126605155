"""systemd's watchdog: fed only while the run process speaks and its recording grows."""

from __future__ import annotations

import asyncio
import os
import socket
import time
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bench.service.service import Service

_WRITING = frozenset({"measuring", "heating"})
_OLDEST_S = 15.0
"""The writer flushes at least every half second; a recording not touched for so long has no writer."""


def notify(text: str) -> bool:
    """Tell systemd (sd_notify protocol); False where nobody listens or reads: the service never waits for it."""
    address = os.environ.get("NOTIFY_SOCKET")
    if not address:
        return False
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.setblocking(False)
        try:
            sender.sendto(text.encode(), "\0" + address[1:] if address.startswith("@") else address)
        except BlockingIOError:
            return False
    return True


def interval_s() -> float:
    """How often the watchdog is fed: half of what systemd asks for."""
    return max(0.5, int(os.environ.get("WATCHDOG_USEC", "20000000")) / 2e6)


def writer_lives(folder: Path, phase: str, now: float) -> bool:
    """Whether the unfinished recording of a folder grows; True where none has to. ``now`` is Unix time in s."""
    if phase not in _WRITING:
        return True
    ages = []
    for part in folder.glob("*.part"):
        try:
            ages.append(now - part.stat().st_mtime)
        except FileNotFoundError:
            # finished between listing and looking: it lives
            return True
    return not ages or min(ages) < _OLDEST_S


def is_well(service: Service) -> bool:
    """Whether run and writer live."""
    run = service.keeper.runs.running()
    if run is None:
        return True
    phase = service.keeper.shown.status["phase"]
    return service.keeper.is_alive() and writer_lives(Path(run.folder), phase, time.time())


async def feed(service: Service) -> None:
    """Tell systemd that the service is ready, then feed its watchdog as long as all is well."""
    notify("READY=1")
    while True:
        if is_well(service):
            notify("WATCHDOG=1")
        else:
            notify("STATUS=the run or its writer is silent")
        await asyncio.sleep(interval_s())
