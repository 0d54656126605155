"""From phases to set values, cycle by cycle, handed out in blocks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.protocols import Phase, Segment, Until

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Change:
    """From cycle ``offset`` of a block on, the recording is in ``segment`` (None: in none)."""

    offset: int
    segment: Segment | None


@dataclass(frozen=True, slots=True)
class SetBlock:
    """Set values of n cycles: load-side velocity in rad/s, load torque in N·m, and where segments change."""

    velocity: FloatArray
    load_torque: FloatArray
    changes: tuple[Change, ...]

    @property
    def size(self) -> int:
        """Number of cycles."""
        return int(self.velocity.size)


class Trajectory:
    """Walks through phases, starting from the given set values.

    A phase with a condition ends its blocks with it, so that the condition is looked at after every block;
    :meth:`observe` must be called with the temperature then.
    """

    def __init__(
        self, phases: Sequence[Phase], cycle_time_s: float, velocity: float = 0.0, load_torque: float = 0.0
    ) -> None:
        self._phases = tuple(phases)
        self._cycles = tuple(max(0, round(phase.duration_s / cycle_time_s)) for phase in self._phases)
        self._index, self._done = 0, 0
        self._velocity, self._torque = velocity, load_torque
        self._start = (velocity, load_torque)
        self._segment: Segment | None = None
        self._expired: Phase | None = None

    @property
    def velocity(self) -> float:
        """Set velocity after the last block, rad/s at the load side."""
        return self._velocity

    @property
    def load_torque(self) -> float:
        """Set torque after the last block, N·m."""
        return self._torque

    @property
    def finished(self) -> bool:
        """Whether all phases are done."""
        return self._index >= len(self._phases)

    @property
    def expired(self) -> Phase | None:
        """The phase whose condition was not met within its time, if there is one; the trajectory went on after it."""
        return self._expired

    def block(self, capacity: int) -> SetBlock:
        """Return the set values of up to ``capacity`` next cycles; empty when finished."""
        velocity, torque = np.empty(capacity), np.empty(capacity)
        changes: list[Change] = []
        filled = 0
        while filled < capacity and not self.finished:
            phase, total = self._phases[self._index], self._cycles[self._index]
            take = min(capacity - filled, total - self._done)
            if take > 0 and phase.segment is not self._segment:
                self._segment = phase.segment
                changes.append(Change(filled, phase.segment))
            if take > 0:
                share = np.arange(self._done + 1, self._done + take + 1) / total
                velocity[filled : filled + take] = self._start[0] + share * (phase.velocity - self._start[0])
                torque[filled : filled + take] = self._start[1] + share * (phase.load_torque - self._start[1])
                self._velocity, self._torque = float(velocity[filled + take - 1]), float(torque[filled + take - 1])
                filled += take
                self._done += take
            if phase.until is not None:
                break
            if self._done >= total:
                self._advance(phase)
        return SetBlock(velocity[:filled], torque[:filled], tuple(changes))

    def observe(self, temperature: float) -> None:
        """Look at the condition of the present phase, if it has one; goes on when it is met or its time is over."""
        if self.finished:
            return
        phase = self._phases[self._index]
        if phase.until is None:
            return
        met = temperature >= phase.temperature if phase.until is Until.WARMER else temperature <= phase.temperature
        if met or self._done >= self._cycles[self._index]:
            if not met:
                self._expired = phase
            self._advance(phase)

    def _advance(self, phase: Phase) -> None:
        self._velocity, self._torque = phase.velocity, phase.load_torque
        self._start = (phase.velocity, phase.load_torque)
        self._index, self._done = self._index + 1, 0
