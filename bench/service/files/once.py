"""The same request twice is done once: answers by the id the client made for its act.

What has made something that lasts (a run, an analysis) is remembered over a restart: a client that heard no answer
because the service ended asks again, and must not be given a second run.
"""

from __future__ import annotations

import asyncio
import json
from collections import OrderedDict
from collections.abc import Awaitable, Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from bench.errors import BenchError
from bench.service.files.disk import Disk
from bench.service.files.kept import Broken

_KEPT = 2000
_LASTING = 300
"""Of those that made something, over a restart."""


class IdUsedAgain(BenchError):
    """One id was given to two different requests."""


class Once:
    """Remembers what was answered.

    Parameters
    ----------
    settle : is awaited after each act, before it is answered.
    path : file of the answers that name what was made; written by ``disk``. A broken one is put aside.
    """

    def __init__(self, settle: Callable[[], Awaitable[None]], path: Path, disk: Disk, broken: Broken) -> None:
        self._settle, self._path, self._disk = settle, path, disk
        self._lasting: OrderedDict[str, tuple[str, dict[str, Any]]] = broken.load(path, _parse_rows) or OrderedDict()
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
                raise _used_again(request_id)
            return await asyncio.shield(known[1])
        before = self._lasting.get(request_id)
        if before is not None:
            if before[0] != _digest(content):
                raise _used_again(request_id)
            return dict(before[1])
        answer: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._answers[request_id] = (content, answer)
        while len(self._answers) > _KEPT:
            self._answers.popitem(last=False)
        try:
            result = await act()
            self._keep(request_id, content, result)
            await self._settle()
        except BaseException as error:
            self._answers.pop(request_id, None)
            answer.set_exception(error)
            # somebody may wait for it, or nobody
            answer.exception()
            raise
        answer.set_result(result)
        return result

    def _keep(self, request_id: str, content: str, result: Any) -> None:
        """Remember an answer that names what was made."""
        if not (isinstance(result, BaseModel) and "id" in type(result).model_fields):
            return
        self._lasting[request_id] = (_digest(content), result.model_dump(mode="json"))
        while len(self._lasting) > _LASTING:
            self._lasting.popitem(last=False)
        self._disk.replace(self._path, json.dumps([[key, *entry] for key, entry in self._lasting.items()]))


def _parse_rows(rows: Any) -> OrderedDict[str, tuple[str, dict[str, Any]]]:
    return OrderedDict((str(key), (str(digest), dict(answer))) for key, digest, answer in rows)


def _digest(content: str) -> str:
    # the content holds the secret of the controls, which belongs on no disk
    return sha256(content.encode()).hexdigest()


def _used_again(request_id: str) -> IdUsedAgain:
    return IdUsedAgain(f"request id {request_id} was used for another request; make a new one for each act")
