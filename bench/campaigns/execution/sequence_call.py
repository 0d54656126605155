"""Call code of a sequence while the bench is open: it may take long, fail, or never return.

A sequence is other people's code. It is called in a thread of its own, so that meanwhile the bus is served, limits are
judged and the operator's stop is obeyed; one that does not return is left behind.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol, TypeVar

from bench.errors import BenchError, one_sentence

T = TypeVar("T")
PATIENCE_S = 60.0
"""A sequence that has not answered for so long will not."""
_FIRST_S = 0.02
_STEP_S = 0.05


class SequenceFailed(BenchError):
    """A sequence raised something, or did not answer in time."""


class Stopped(BenchError):
    """The operator did not want to wait for the answer any longer."""


class Waiting(Protocol):
    """The bench that has to be served meanwhile."""

    @property
    def is_real_time(self) -> bool:
        """Whether its time is that of the clock."""
        ...

    @property
    def elapsed_s(self) -> float:
        """Bench time."""
        ...

    def idle(self, duration_s: float = ...) -> None:
        """Keep the bus alive."""
        ...


def call_sequence(
    what: str, answer: Callable[[], T], bench: Waiting, stop: Callable[[], bool], patience_s: float = PATIENCE_S
) -> T:
    """Return ``answer()``; ``what`` names it in a sentence, such as ``the plan of campaign quick``.

    Raises
    ------
    SequenceFailed
        If it raises anything that is not for users, or does not come back within ``patience_s``.
    Stopped
        If ``stop`` says so first.
    BenchError
        What it raises itself.
    """
    answers: list[T] = []
    failures: list[BaseException] = []

    def ask() -> None:
        try:
            answers.append(answer())
        except BaseException as error:  # noqa: BLE001 - handed over to whoever waits, and raised there
            failures.append(error)

    # a daemon: one that never answers must not keep the process from ending
    worker = threading.Thread(target=ask, name=f"asked for {what}", daemon=True)
    worker.start()
    worker.join(_FIRST_S)
    deadline = time.monotonic() + patience_s
    while worker.is_alive():
        if stop():
            raise Stopped(f"stopped on the operator's request while waiting for {what}")
        if time.monotonic() > deadline:
            raise SequenceFailed(f"{what} did not come within {patience_s:g} s")
        if bench.is_real_time:
            bench.idle(_STEP_S)
        else:
            worker.join(_STEP_S)
    if not failures:
        return answers[0]
    error = failures[0]
    if isinstance(error, BenchError):
        raise error
    raise SequenceFailed(f"{what} failed: {one_sentence(error)}") from error
