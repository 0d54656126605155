"""A run that waits between two points: the operator paused, or the disk takes nothing. The bus is served meanwhile."""

from __future__ import annotations

import time
from collections.abc import Callable

from bench.campaigns.execution.room import NoRoom
from bench.campaigns.execution.sequence_call import Waiting
from bench.campaigns.listener import Listener
from bench.campaigns.operator.directions import Directions

_PAUSE_S = 0.25


class Waits:
    """The waits of one run.

    Parameters
    ----------
    rig : the bench.
    directions : what the operator asks.
    listener : is called again and again as long as a wait lasts.
    stop_requested : ends every wait.
    answered : whether somebody can go on; a run nobody talks to ends where it would wait for that.
    """

    def __init__(
        self,
        rig: Waiting,
        directions: Directions,
        listener: Listener,
        stop_requested: Callable[[], bool],
        *,
        answered: bool,
    ) -> None:
        self._rig, self._directions, self._listener = rig, directions, listener
        self._stop_requested, self._answered = stop_requested, answered

    def while_paused(self, why: str = "") -> None:
        """Return when nobody pauses (any longer), or a stop is asked for."""
        if not self._directions.paused:
            return
        while self._directions.paused and not self._stop_requested():
            # said again and again: whoever listens takes a run that says nothing for one that hangs
            self._listener.paused(True, why)
            before = self._rig.elapsed_s
            if self._rig.is_real_time:
                self._rig.idle(_PAUSE_S)
            if self._rig.elapsed_s == before:
                # fast emulation stands still; a bench that tripped does nothing until the next motion says so
                time.sleep(_PAUSE_S)
        self._listener.paused(False)

    def for_room(self, why: str, so_far: str) -> None:
        """Pause because the disk takes nothing, until the operator has made room and goes on.

        Raises
        ------
        NoRoom
            If nobody can be asked; ``so_far`` says what was done until then.
        """
        if not self._answered:
            raise NoRoom(
                f"{why}; {so_far} and the bench is brought to rest; make room and run again, finished points are not"
                " repeated"
            )
        self._directions.pause()
        self.while_paused(f"{why}; make room, then go on")
