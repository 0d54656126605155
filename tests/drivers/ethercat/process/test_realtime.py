"""What the kernel grants is used, what it refuses is said."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator

import pytest

from drivers.ethercat.process import realtime
from drivers.ethercat.process.settings import RealTime


@pytest.fixture(autouse=True)
def _collector_back() -> Iterator[None]:
    yield
    gc.enable()
    gc.unfreeze()


@pytest.mark.parametrize(
    ("text", "cpus"), [("", ()), ("\n", ()), ("3\n", (3,)), ("1,4-6\n", (1, 4, 5, 6)), ("2-3,2\n", (2, 3))]
)
def test_isolated_processors_are_read_as_the_kernel_writes_them(text: str, cpus: tuple[int, ...]) -> None:
    assert realtime.isolated_cpus(text) == cpus


def test_what_is_refused_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    class NoLock:
        @staticmethod
        def mlockall(_: int) -> int:
            return -1

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(os, "sched_setaffinity", refuse)
    monkeypatch.setattr(realtime.ctypes, "CDLL", lambda *_, **__: NoLock)
    notes = realtime.become_real_time(RealTime(80, 1))
    assert len(notes) == 3
    assert "could not be pinned to processor 1" in notes[0]
    assert "SCHED_FIFO priority 80 and runs slower" in notes[1]
    assert "could not lock its memory" in notes[2]
    assert not gc.isenabled()


def test_an_isolated_processor_is_taken_without_being_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    pinned: list[set[int]] = []
    monkeypatch.setattr(realtime, "isolated_cpus", lambda: (2, 3))
    monkeypatch.setattr(os, "sched_setaffinity", lambda _, cpus: pinned.append(cpus))
    notes = realtime.become_real_time(RealTime(priority=None, lock_memory=False))
    assert pinned == [{3}]
    assert len(notes) == 1
    assert "without real-time scheduling" in notes[0]
