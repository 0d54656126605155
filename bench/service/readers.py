"""Slow reading on threads of its own: so many at once, so many waiting, and none of them holds up the service's end."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from bench.service.refusals import NotNow

P = ParamSpec("P")
R = TypeVar("R")


class Readers:
    """Runs functions that may take long, each on a daemon thread.

    Parameters
    ----------
    what : what is read, for the sentence of a refusal.
    at_once : how many run at the same time.
    most_waiting : how many more may wait; further ones are refused.
    """

    def __init__(self, what: str, at_once: int, most_waiting: int) -> None:
        self._what, self._most = what, at_once + most_waiting
        self._free = asyncio.Semaphore(at_once)
        self._asked = 0

    async def __call__(self, function: Callable[P, R], *args: P.args, **more: P.kwargs) -> R:
        """Return what the function returns.

        Raises
        ------
        NotNow
            If too many wait already; and what the function raises.
        """
        if self._asked >= self._most:
            raise NotNow(f"too many {self._what} are asked for at once; ask again in a moment")
        self._asked += 1
        try:
            async with self._free:
                return await _in_thread(lambda: function(*args, **more))
        finally:
            self._asked -= 1


async def _in_thread(function: Callable[[], R]) -> R:
    loop = asyncio.get_running_loop()
    answer: asyncio.Future[R] = loop.create_future()

    def set_answer(set_: Callable[..., None], value: object) -> None:
        def now() -> None:
            if not answer.done():
                set_(value)

        try:
            loop.call_soon_threadsafe(now)
        except RuntimeError:
            # the service has ended meanwhile; nobody waits for it
            return

    def work() -> None:
        try:
            result = function()
        except BaseException as error:  # noqa: BLE001 - handed on to whoever waits
            set_answer(answer.set_exception, error)
        else:
            set_answer(answer.set_result, result)

    threading.Thread(target=work, name="reader", daemon=True).start()
    return await answer
