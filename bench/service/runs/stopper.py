"""STOP: brings the run to rest by its socket and by signals, whatever else works or does not; touches no file.

Who pressed first, and when, is kept for the pages and the book.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from bench.service.runs.process_link import ProcessLink, send_once
from bench.stop_button.rest import after_press_s, is_own_time

_SAME_PRESS_NS = 10**9
"""Presses of one person closer than this are one: nobody looks and presses anew so soon."""


@dataclass(frozen=True, slots=True)
class Press:
    """The press of STOP that was first for a run.

    Attributes
    ----------
    by : name, for the record.
    pressed_at_ns : when it was pressed, Unix time in ns, stamped by whoever took the press first.
    run : id of the run it was for, None where nothing ran.
    at_rest : whether both shafts were seen at rest.
    at_rest_after_s : from the press until both shafts were seen at rest, s; None where that is not known.
    bench_to_rest_s : from the begin of the stop until then, s of a bench whose time is not the clock's; else None.
    over : whether the run has ended, so that no more will be seen.
    """

    by: str
    pressed_at_ns: int
    run: str | None
    at_rest: bool = False
    at_rest_after_s: float | None = None
    bench_to_rest_s: float | None = None
    over: bool = False

    def as_dict(self) -> dict[str, Any]:
        """For the pages."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class Target:
    """What is stopped: a run's process, if it is known, and its socket."""

    run: str
    pid: int | None
    socket: Path


def _is_same(press: Press, by: str, at_ns: int) -> bool:
    """Whether this press has been heard of already: a page presses here and at the run's own listener, and a service
    that hung hears of it when the run has ended.
    """
    return press.by == by and abs(press.pressed_at_ns - at_ns) < _SAME_PRESS_NS


class Stopper:
    """Stops what runs.

    Parameters
    ----------
    deadline_s : how long a stop may take before the process is killed and the bus process and drives act alone.
    """

    def __init__(self, deadline_s: float, killed: Callable[[], None]) -> None:
        self.deadline_s, self._killed = deadline_s, killed
        self.press: Press | None = None
        self._late: asyncio.Task[None] | None = None
        self._sending: set[asyncio.Task[bool]] = set()

    def pressed(self, by: str, pressed_at_ns: int | None, run: str | None) -> tuple[Press, bool]:
        """Note a press; return the one that counts for this run and whether it is this one."""
        now = time.time_ns()
        # a stamp of a clock that is wrong stamps nothing
        at = now if pressed_at_ns is None or not is_own_time(pressed_at_ns, now) else pressed_at_ns
        known = self.press
        if known is not None and (known.run == run if run is not None else _is_same(known, by, at)):
            return known, False
        self.press = Press(by, at, run)
        return self.press, True

    def stop(self, target: Target, link: ProcessLink | None, is_running: Callable[[], bool]) -> None:
        """Send STOP by every way there is; returns at once."""
        press = self.press
        more: dict[str, Any] = {} if press is None else {"by": press.by, "pressed_at_ns": press.pressed_at_ns}
        loop = asyncio.get_running_loop()
        if link is None or not link.send("stop", **more):
            # nobody follows the run at the moment; its socket is there all the same
            task = loop.create_task(send_once(target.socket, {"do": "stop", **more}))
            self._sending.add(task)
            task.add_done_callback(self._sending.discard)
        if target.pid is None or not is_running():
            return
        with contextlib.suppress(ProcessLookupError, PermissionError):
            # the socket may be stuck; the signal is not
            os.kill(target.pid, signal.SIGTERM)
        if self._late is None or self._late.done():
            self._late = loop.create_task(self._kill_late(target.pid, is_running))

    def seen(self, run: str, at_rest: bool, rest_seen_at_ns: int | None, bench_to_rest_s: float | None) -> None:
        """The run that was stopped has ended, and this was seen of its shafts.

        Parameters
        ----------
        at_rest : whether both were seen at rest.
        rest_seen_at_ns : when, Unix time in ns; None where nobody stamped it.
        bench_to_rest_s : see :class:`Press`.
        """
        press = self.press
        if press is not None and press.run == run:
            after_s = after_press_s(press.pressed_at_ns, rest_seen_at_ns) if at_rest else None
            self.press = replace(
                press, at_rest=at_rest, at_rest_after_s=after_s, bench_to_rest_s=bench_to_rest_s, over=True
            )

    def forget(self) -> None:
        """A new run begins: the press was for another."""
        self.press = None

    async def close(self) -> None:
        """End what waits."""
        for task in (self._late, *self._sending):
            if task is not None:
                task.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await task

    async def _kill_late(self, pid: int, is_running: Callable[[], bool]) -> None:
        await asyncio.sleep(self.deadline_s)
        if is_running():
            self._killed()
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.kill(pid, signal.SIGKILL)
