"""The web process's end of a run's socket: reads what the run tells, sends the operator's wishes."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

Message = dict[str, Any]
_RETRY_S = 0.05
_LONGEST_LINE = 16 * 1024 * 1024


class ProcessLink:
    """One run's socket."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._writer: asyncio.StreamWriter | None = None

    async def messages(self, is_alive: Callable[[], bool]) -> AsyncIterator[Message]:
        """Yield the run's messages until it ends; connects as soon as its socket is there."""
        while True:
            try:
                reader, writer = await asyncio.open_unix_connection(str(self._path), limit=_LONGEST_LINE)
                break
            except OSError:
                if not is_alive():
                    return
                await asyncio.sleep(_RETRY_S)
        self._writer = writer
        try:
            while line := await reader.readline():
                yield json.loads(line)
        except (ConnectionError, ValueError):
            # killed in the middle of a line: what became of it stands in its outcome, or nowhere
            return
        finally:
            self._writer = None
            writer.close()

    def send(self, wish: str, **more: str) -> bool:
        """Send a wish; False if there is nobody to hear it."""
        if self._writer is None:
            return False
        self._writer.write(json.dumps({"do": wish, **more}).encode() + b"\n")
        return True
