"""Physics that begins in the middle of a campaign: nothing until a recording, then at once or growing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fakes.concealed.effects.base import Effect, Floats, Run, ThermalWorld


@dataclass(slots=True)
class Beginning(Effect):
    """Another effect that is there from recording ``since`` on, full after ``grows`` further seconds.

    Attributes:
        inner: the effect; its own amplitude scales it. since: index of the point from which it acts.
        grows: time constant of its growth in s; 0 for at once.
    """

    inner: Effect = field(default_factory=lambda: Effect("", "", (), 0.0))
    since: int = 0
    grows: float = 0.0
    began: float = -1.0
    """s of the campaign's clock at its first sample; below 0 before it"""

    def reset(self) -> None:
        """Forget that it began."""
        self.began = -1.0
        self.inner.reset()

    @classmethod
    def of(cls, inner: Effect, since: int, grows: float = 0.0) -> Beginning:
        """The effect ``inner`` from point ``since`` on."""
        return cls(inner.effect, inner.form, inner.channels, 1.0, inner=inner, since=since, grows=grows)

    def add(self, hook: str, run: Run) -> Floats | None:
        """What the effect adds, times how far it has grown."""
        if run.index < self.since:
            return None
        part = self.inner.add(hook, run)
        return None if part is None else part * self._grown(run.clock)

    def heat(self, world: ThermalWorld, run: Run, clock: Floats, coarse: slice) -> None:
        """The effect's change of the heat balance, once it is there."""
        if run.index >= self.since:
            self._grown(clock)
            self.inner.heat(world, run, clock, coarse)

    def rest(self, world: ThermalWorld, clock: Floats) -> None:
        """The same while the bench stands."""
        if self.began >= 0.0:
            self.inner.rest(world, clock)

    def _grown(self, clock: Floats) -> Floats:
        if self.began < 0.0:
            self.began = float(clock[0])
        if self.grows <= 0.0:
            return np.ones(clock.size)
        return np.asarray(1.0 - np.exp(-np.maximum(clock - self.began, 0.0) / self.grows))


@dataclass(slots=True)
class WarmerRoom(Effect):
    """Surroundings warmer by ``amplitude`` K."""

    def heat(self, world: ThermalWorld, run: Run, clock: Floats, coarse: slice) -> None:
        """Warm the surroundings."""
        world.ambient += self.amplitude

    def rest(self, world: ThermalWorld, clock: Floats) -> None:
        """Warm the surroundings."""
        world.ambient += self.amplitude
