"""Server-sent events: every page gets what happens, none holds up another, one that lags loses live values first."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any

Message = dict[str, Any]
_MOST_WAITING = 400
_LIVE_UNTIL = 100
_LIVE = frozenset({"live", "spectrum", "condition"})
BEAT_S = 2.0
"""Seconds between signs of life; a page that misses them says that the service is gone."""


class Stream:
    """Hands messages to all pages; used from the event loop only."""

    def __init__(self) -> None:
        self._pages: set[asyncio.Queue[str | None]] = set()
        self._closing = False

    @property
    def pages(self) -> int:
        """How many pages look on."""
        return len(self._pages)

    def publish(self, message: Message) -> None:
        """Hand a message to every page."""
        if not self._pages:
            return
        text = f"event: {message['type']}\ndata: {json.dumps(message, ensure_ascii=False, allow_nan=False)}\n\n"
        for page in list(self._pages):
            waiting = page.qsize()
            if waiting >= _MOST_WAITING:
                # it does not read any more; its browser connects again when it does
                self._pages.discard(page)
                page.put_nowait(None)
            elif waiting < _LIVE_UNTIL or message["type"] not in _LIVE:
                page.put_nowait(text)

    def close(self) -> None:
        """End all streams."""
        self._closing = True
        for page in self._pages:
            page.put_nowait(None)

    async def events(self, greeting: list[Message]) -> AsyncIterator[str]:
        """Yield the text of events: the greeting, then everything, and a beat when nothing happens."""
        page: asyncio.Queue[str | None] = asyncio.Queue()
        self._pages.add(page)
        try:
            for message in greeting:
                yield f"event: {message['type']}\ndata: {json.dumps(message, ensure_ascii=False, allow_nan=False)}\n\n"
            while not self._closing:
                try:
                    text = await asyncio.wait_for(page.get(), BEAT_S)
                except TimeoutError:
                    text = "event: beat\ndata: {}\n\n"
                if text is None:
                    return
                yield text
        finally:
            self._pages.discard(page)
