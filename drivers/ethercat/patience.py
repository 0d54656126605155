"""How often a slave is asked again, and how long one may be silent before it counts as gone."""

from __future__ import annotations

import time
from collections.abc import Callable

ATTEMPTS = 3
"""Tries of one access that may fail for the same reason: an emergency message, or an error left over from another
slave, costs one answer."""

PATIENCE_S = 2.1
"""How long a slave may leave requests untaken: as long as it may leave ``ATTEMPTS`` requests unanswered, for each of
which SOEM waits 0.7 s (EC_TIMEOUTRXM). For the request itself SOEM waits only 20 ms (EC_TIMEOUTTXM). A slave that is
busy, or a computer that emulates one, may well be late three times in a row."""

PAUSE_S = 0.01
"""Between tries once a slave was silent: where the interface is down they fail at once, and late answers come in it."""


def nothing() -> None:
    """Do nothing between tries."""


class Tries:
    """Counts the tries of one access and says whether another one is due.

    Parameters
    ----------
    patience_s : how long a silent slave is asked again, s; 0 where cycles wait meanwhile.
    settle : called before a slave that was silent is asked again, or given up; drops frames that have come late.
    clock, sleep : monotonic time in s and a pause in s; other ones serve tests.

    Attributes
    ----------
    waited_s : time since the first try began, s.
    """

    def __init__(
        self,
        patience_s: float = PATIENCE_S,
        settle: Callable[[], None] = nothing,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._patience_s, self._settle, self._clock, self._sleep = patience_s, settle, clock, sleep
        self._begun_s = clock()
        self._silent = self._wrong = 0
        self.waited_s = 0.0

    @property
    def made(self) -> int:
        """Tries so far."""
        return self._silent + self._wrong

    def again(self, *, silent: bool) -> bool:
        """Note a try that failed, the slave being ``silent`` or its answer wrong; True if another one is due.

        Silent and wrong answers count apart where there is patience; where there is none, all tries count.
        """
        self.waited_s = self._clock() - self._begun_s
        self._silent, self._wrong = self._silent + silent, self._wrong + (not silent)
        if not self._patience_s:
            return self.made < ATTEMPTS
        more = self._wrong < ATTEMPTS
        if silent:
            more = self._silent < ATTEMPTS or self.waited_s < self._patience_s
        if self._silent:
            if more:
                self._sleep(PAUSE_S)
            self._settle()
        return more
