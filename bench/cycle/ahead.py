"""The link to a bus that has a process of its own: set values are handed over ahead, and taken back for a stop."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from bench.configuration import BenchConfiguration
from bench.cycle.assembly import Assembly
from bench.cycle.decode import Decoded
from bench.cycle.link import Link
from bench.cycle.plugins import DRIVERS, plugin
from bench.errors import DeviceError

FloatArray = NDArray[np.float64]
_REST_AHEAD_S = 2.0
"""At rest: opening and closing files may take long, and set values ahead cost nothing where they are all zero."""
_PATIENCE_S = 0.01
"""How long a drive may show a speed or torque beyond its own limit before the process stops it."""
_HISTORY = 1 << 15
"""Set values remembered until their cycle comes back: more than both rings of a bus process hold."""


class AheadLink(Link):
    """Bus process, drives and terminals of one bench.

    The attributes ``velocity`` and ``torque`` are those handed over last; :meth:`flush` makes them those sent last.
    """

    def __init__(self, bench: BenchConfiguration, assembly: Assembly, zero: float = 0.0) -> None:
        super().__init__(bench, assembly, paced=False, zero=zero)
        if assembly.process_bus is None:
            raise DeviceError("set values go ahead only to a bus with a process of its own; this one has none")
        self._bus = assembly.process_bus
        self._lead_cycles = assembly.block
        self._set_values = np.zeros((_HISTORY, 2))

    def exchange(self, velocity: FloatArray, torque: FloatArray) -> Decoded:
        """Hand over set values (n,), load side; return what has come meanwhile, n cycles at least.

        What comes back was sent up to :attr:`queued` cycles ago.
        """
        self.submit(velocity, torque)
        return self.collect(velocity.size)

    def descend(self, velocity: FloatArray, torque: FloatArray, least: int) -> Decoded:
        """Hand over set values of a stop, none if there are enough ahead; return ``least`` cycles or more."""
        if velocity.size:
            self.submit(velocity, torque)
        return self.collect(least)

    @property
    def sent_values(self) -> tuple[float, float]:
        """Set values of the cycle sent last."""
        velocity, torque = self._set_values[(self._bus.used - 1) % _HISTORY].tolist()
        return velocity, torque

    def clock(self) -> float:
        """Monotonic time, s: the bus goes on whatever this program does."""
        return time.monotonic()

    def missing_ahead(self, n: int) -> int:
        """Return how many cycles are missing ahead, so that a rig that is late delays no ramp."""
        return min(max(0, max(n, self.assembly.ahead) - self.queued), self._bus.block_capacity)

    def go_silent(self) -> None:
        """Have the process end without another frame of process data."""
        super().go_silent()
        self._bus.silence()

    @property
    def queued(self) -> int:
        """Cycles whose set values are handed over and not yet sent."""
        return self._bus.queued

    def submit(self, velocity: FloatArray, torque: FloatArray) -> int:
        """Hand over set values (n,), load side, one a cycle; return the index of the first."""
        n = velocity.size
        self._prepare(velocity, torque)
        index = self._bus.submit(n)
        self._set_values[np.arange(index, index + n) % _HISTORY] = np.column_stack((velocity, torque))
        self.velocity, self.torque = float(velocity[-1]), float(torque[-1])
        return index

    def collect(self, least: int) -> Decoded:
        """Wait for cycles and return all there are, with the index of the set values each has sent.

        Raises
        ------
        BusLostError
            If the bus process has ended or hands over nothing any more.
        """
        self._require_voice()
        done = self._bus.collect(least)
        index = done.set_index
        if index is None:
            raise DeviceError("the bus process does not say which set values it has sent; it should, for every cycle")
        velocity = np.where(index < 0, 0.0, self._set_values[index % _HISTORY, 0])
        return self._take(done, velocity * self._bench.gearbox.ratio)

    def flush(self) -> int:
        """Drop the set values not yet sent, go on from those sent last; return the index of the next."""
        index = self._bus.flush()
        self.velocity, self.torque = self.sent_values
        return index

    def drop_ahead(self) -> None:
        """Take back what has not been sent."""
        self.flush()

    def arm(self, armed: bool) -> None:
        """Let the process stop the drives by itself (set values missing, limits, working counter), or no longer.

        Arming also has it follow set values again after such a stop: whoever arms has the operator's word.
        """
        if armed:
            self.release()
        self._bus.arm(self.cycles(self._bench.bus.hold) if armed else 0)

    def hold_stopped(self) -> None:
        """Have the process keep the drives without voltage whatever it is handed, until :meth:`arm`."""
        self._bus.order_stop()

    def release(self) -> None:
        """Have the process follow set values again, if it had stopped the drives."""
        if self._bus.stopped is not None:
            self._bus.resume()

    def keep_ahead(self, at_rest: bool) -> None:
        """Hand the last set values over for a while more; long at rest."""
        missing = (self.cycles(_REST_AHEAD_S) if at_rest else self.assembly.ahead) - self.queued
        while missing > 0:
            n = min(missing, self._bus.block_capacity)
            self.submit(np.full(n, self.velocity), np.full(n, self.torque))
            missing -= n

    def stopped(self) -> str | None:
        """Why the bus process has stopped the drives by itself, or None."""
        return self._bus.stopped

    def _protect(self) -> None:
        """Tell the process how it stops these drives, and when it does without being asked."""
        bus, stopping = self._bus, self._bench.stopping
        bus.protect(
            plugin(DRIVERS, "cia402_protection")(
                bus,
                self.drives.both,
                quick_stop_s=stopping.quick_stop,
                disable_s=stopping.disable_voltage,
                patience_s=_PATIENCE_S,
                bad_cycles=2 * self._bench.limits.lost_cycles,
            )
        )


def make_link(bench: BenchConfiguration, assembly: Assembly, paced: bool, zero: float = 0.0) -> Link:
    """Return the link that suits the bus."""
    return AheadLink(bench, assembly, zero) if assembly.ahead else Link(bench, assembly, paced, zero)
