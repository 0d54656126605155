"""What the stop ladder does with a bench in operation: set values towards rest, a goal for the drives, silence."""

from __future__ import annotations

import numpy as np

from bench.cycle.decode import Decoded
from bench.cycle.feed import hand_on
from bench.cycle.sink import Sink
from bench.cycle.view import View


class Stoppable(View):
    """The side of a rig that the stop ladder (:class:`bench.cycle.stop.climb.Stop`) sees."""

    def clock(self) -> float:
        """Time by which the deadlines of a stop are kept: the clock's, in fast emulation the bench's, s."""
        return self._link.clock()

    def missing_ahead(self, n: int) -> int:
        """Return how many cycles are to be handed over: ``n``, or what is missing ahead of a bus of its own."""
        return self._link.missing_ahead(n)

    def drop_ahead(self) -> None:
        """Take back what was handed over and not sent."""
        self._link.drop_ahead()

    def go_silent(self) -> None:
        """Send no process data from now on; the bench has to be opened anew after that."""
        self._link.go_silent()

    def stop_cycles(self, n: int, least: int, velocity: float, torque: float, goal: str | None, sink: Sink) -> Decoded:
        """Hand over ``n`` cycles of a stop, with set values at their end, and a goal for both drives if it changes.

        Returns what came meanwhile, ``least`` cycles or more.
        """
        if goal is not None:
            self._link.drives.request(goal)
        share = np.arange(1, n + 1) / max(n, 1)
        start_velocity, start_torque = self.set_values
        decoded = self._link.descend(
            start_velocity + share * (velocity - start_velocity), start_torque + share * (torque - start_torque), least
        )
        hand_on(decoded, 0, decoded.size, sink)
        return decoded
