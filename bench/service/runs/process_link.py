"""The web process's end of a run's socket: reads what the run sends, sends the operator's wishes."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

Message = dict[str, Any]
_RETRY_S = 0.05
_CONNECT_S = 2.0
_LONGEST_LINE = 16 * 1024 * 1024


class ProcessLink:
    """One run's socket."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._writer: asyncio.StreamWriter | None = None

    async def messages(self, is_alive: Callable[[], bool]) -> AsyncIterator[Message]:
        """Yield the run's messages until it ends; connects as soon as its socket is there, and again if it is cut."""
        while True:
            try:
                reader, writer = await asyncio.open_unix_connection(str(self._path), limit=_LONGEST_LINE)
            except OSError:
                if not is_alive():
                    return
                await asyncio.sleep(_RETRY_S)
                continue
            self._writer = writer
            try:
                async for message in _read(reader):
                    yield message
            finally:
                self._writer = None
                writer.close()
            if not is_alive():
                return
            await asyncio.sleep(_RETRY_S)

    def send(self, wish: str, **more: Any) -> bool:
        """Send a wish; False if there is nobody to hear it."""
        if self._writer is None or self._writer.is_closing():
            return False
        self._writer.write(_line({"do": wish, **more}))
        return True


async def send_once(path: Path, message: Message) -> bool:
    """Send one message over a connection of its own; False if nobody took it."""
    try:
        _, writer = await asyncio.wait_for(asyncio.open_unix_connection(str(path)), _CONNECT_S)
    except (OSError, TimeoutError):
        return False
    try:
        writer.write(_line(message))
        await asyncio.wait_for(writer.drain(), _CONNECT_S)
    except (OSError, TimeoutError):
        return False
    finally:
        writer.close()
    return True


async def _read(reader: asyncio.StreamReader) -> AsyncIterator[Message]:
    """Yield whole messages; a line that was cut, or is none, ends it: what became of it stands in the outcome."""
    try:
        while line := await reader.readline():
            message = json.loads(line)
            if isinstance(message, dict) and isinstance(message.get("type"), str):
                yield message
    except (OSError, ValueError):
        return


def _line(message: Message) -> bytes:
    return json.dumps(message).encode() + b"\n"
