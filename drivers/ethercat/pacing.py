"""When a cycle may start: at absolute deadlines, so that a late cycle does not shift the ones after it."""

from __future__ import annotations

import ctypes
import ctypes.util
import time
from collections.abc import Callable
from typing import Protocol

_CLOCK_MONOTONIC = 1
_TIMER_ABSTIME = 1
_EINTR = 4


class Pacing(Protocol):
    """Waits for the slot of the next cycle."""

    def next_slot(self) -> tuple[int, int]:
        """Wait for the next slot; its number (steps by more than 1 where slots were missed) and the time now, ns."""
        ...


class FreeRunning:
    """No waiting: one slot after another, timestamps counted in cycles. For devices that keep time by themselves."""

    def __init__(self, cycle_time_s: float) -> None:
        self._period_ns = round(cycle_time_s * 1e9)
        self._slot = -1

    def next_slot(self) -> tuple[int, int]:
        """Return the next slot at once."""
        self._slot += 1
        return self._slot, self._slot * self._period_ns


class _Timespec(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


def _libc_sleeper() -> Callable[[int], None] | None:
    """``clock_nanosleep`` to an absolute time of the monotonic clock, or None where the C library has none."""
    library = ctypes.util.find_library("c")
    nanosleep = getattr(ctypes.CDLL(library), "clock_nanosleep", None) if library else None
    if nanosleep is None:
        return None

    def sleep_until(deadline_ns: int) -> None:
        target = _Timespec(*divmod(deadline_ns, 1_000_000_000))
        # A signal ends the sleep early; the deadline is absolute, so sleeping again does not drift.
        while nanosleep(_CLOCK_MONOTONIC, _TIMER_ABSTIME, ctypes.byref(target), None) == _EINTR:
            pass

    return sleep_until


def _relative_sleep_until(deadline_ns: int) -> None:
    remaining = deadline_ns - time.monotonic_ns()
    if remaining > 0:
        time.sleep(remaining * 1e-9)


class AbsoluteDeadlines:
    """Slots on a fixed grid of the monotonic clock, from the first call on.

    A slot whose whole period has passed before it could start is skipped: two frames close together would hand drives
    a wrong interpolation time. Slaves that wait for their master, as an emulated bench may, do not mind: with
    ``make_up_s`` slots are begun up to that much later, one right after the other.

    Parameters
    ----------
    cycle_time_s : period, s.
    make_up_s : how much later than its period's end a slot may begin, s.
    clock, sleep_until : monotonic time in ns and sleep to such a time; other ones serve tests.
    """

    def __init__(
        self,
        cycle_time_s: float,
        clock: Callable[[], int] = time.monotonic_ns,
        sleep_until: Callable[[int], None] | None = None,
        make_up_s: float = 0.0,
    ) -> None:
        self._period_ns = round(cycle_time_s * 1e9)
        self._make_up_ns = round(make_up_s * 1e9)
        self._clock = clock
        self._sleep_until = sleep_until or _libc_sleeper() or _relative_sleep_until
        self._start_ns = -1
        self._slot = -1

    @property
    def due_ns(self) -> int:
        """When the last slot was due, on the clock's time."""
        return self._start_ns + self._slot * self._period_ns

    def next_slot(self) -> tuple[int, int]:
        """Sleep until the next slot that has not passed yet, or may still be made up for."""
        now = self._clock()
        if self._start_ns < 0:
            self._start_ns = now
        self._slot = max(self._slot + 1, (now - self._start_ns - self._make_up_ns) // self._period_ns)
        self._sleep_until(self._start_ns + self._slot * self._period_ns)
        return self._slot, self._clock()
