"""The same request twice is done once: answers by the id the client made for its act."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Awaitable, Callable
from typing import Any

from bench.errors import BenchError

_KEPT = 2000


class IdUsedAgain(BenchError):
    """One id was given to two different requests."""


class Once:
    """Remembers what was answered."""

    def __init__(self) -> None:
        self._answers: OrderedDict[str, tuple[str, asyncio.Future[Any]]] = OrderedDict()

    async def __call__(self, request_id: str, content: str, act: Callable[[], Awaitable[Any]]) -> Any:
        """Return the answer of ``act``, or the one given before to the same id. A refusal is not remembered.

        Raises
        ------
        IdUsedAgain
            If the id was used for another ``content``.
        """
        known = self._answers.get(request_id)
        if known is not None:
            if known[0] != content:
                raise IdUsedAgain(f"request id {request_id} was used for another request; make a new one for each act")
            return await asyncio.shield(known[1])
        answer: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._answers[request_id] = (content, answer)
        while len(self._answers) > _KEPT:
            self._answers.popitem(last=False)
        try:
            result = await act()
        except BaseException as error:
            self._answers.pop(request_id, None)
            answer.set_exception(error)
            # somebody may wait for it, or nobody
            answer.exception()
            raise
        answer.set_result(result)
        return result
