"""What the bench uses of a bus: one that cycles while it is asked to, or one in a process of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


class SlaveSpec(Protocol):
    """A slave as the bus should find it; drivers make it, the bus reads it."""

    @property
    def name(self) -> str:
        """Role of the slave in the bench file."""
        ...

    @property
    def coe(self) -> bool:
        """Whether it has an object dictionary."""
        ...


class ObjectDictionary(Protocol):
    """Objects of one slave; integer types are ``u1`` to ``i8``, sign and bytes."""

    def read(self, index: int, subindex: int, type_: str) -> int:
        """Read an integer."""
        ...

    def write(self, index: int, subindex: int, type_: str, value: int) -> None:
        """Write an integer."""
        ...


class Exchange(Protocol):
    """What became of a block of cycles."""

    @property
    def n_done(self) -> int:
        """Cycles that were run; fewer than asked where the master stopped early."""
        ...

    @property
    def wkc(self) -> NDArray[np.int32]:
        """Working counter of each cycle (n_done,); -1 where no frame came back."""
        ...

    @property
    def cycle(self) -> NDArray[np.int64]:
        """Number of each cycle's slot (n_done,); steps by more than 1 where slots were missed."""
        ...

    @property
    def set_index(self) -> NDArray[np.int64] | None:
        """Which of the set values handed over each cycle has sent (n_done,), -1 for others; None: those of its row."""
        ...

    @property
    def late_ns(self) -> NDArray[np.int64] | None:
        """How long after it was due each cycle began, ns (n_done,); None where nobody knows."""
        ...


class Bus(Protocol):
    """A bus of slaves, whoever cycles it. Process data are structured arrays by role, with fields such as 6040:00."""

    @property
    def specs(self) -> Sequence[SlaveSpec]:
        """The slaves in their order."""
        ...

    @property
    def outputs(self) -> Mapping[str, NDArray[Any]]:
        """Outputs of each slave that has some, to be sent."""
        ...

    @property
    def sent(self) -> Mapping[str, NDArray[Any]]:
        """The same as they were sent in the cycles exchanged last."""
        ...

    @property
    def inputs(self) -> Mapping[str, NDArray[Any]]:
        """Inputs of each slave that has some, as received in the cycles exchanged last."""
        ...

    @property
    def expected_wkc(self) -> int:
        """Working counter of a cycle in which every slave took its outputs and gave its inputs."""
        ...

    def open(self) -> None:
        """Open the interface."""
        ...

    def configure(self) -> None:
        """Find the slaves, check who they are, write their settings, map their process data: SAFEOP."""
        ...

    def to_operational(self) -> None:
        """Bring all slaves to OP while row 0 of the outputs is sent."""
        ...

    def close(self) -> None:
        """Bring all slaves to INIT and close the interface."""
        ...

    def sdo(self, name: str) -> ObjectDictionary:
        """Object dictionary of a slave."""
        ...


class BlockBus(Bus, Protocol):
    """A bus that cycles only while it is asked to."""

    def exchange(self, n: int) -> Exchange:
        """Send rows 0 … n - 1 of the outputs, one a cycle, and fill the same rows of the inputs."""
        ...


class ProcessBus(Bus, Protocol):
    """A bus in a process of its own, which takes one of the set values handed over ahead each cycle."""

    @property
    def block_capacity(self) -> int:
        """Most cycles handed over or collected at once."""
        ...

    @property
    def queued(self) -> int:
        """Cycles whose set values are handed over and not yet sent."""
        ...

    @property
    def used(self) -> int:
        """Index after that of the set values sent last."""
        ...

    @property
    def stopped(self) -> str | None:
        """Why the process has stopped the drives by itself, in a sentence; None while it has not."""
        ...

    @property
    def ended(self) -> str | None:
        """A sentence once the process has ended by itself; None while it lives."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """What the process was not granted, in sentences; known once it is open."""
        ...

    @property
    def meta(self) -> NDArray[np.int64]:
        """What was noted beside the cycles collected last (n, words): slot, times in ns, set values, counter."""
        ...

    @property
    def pid(self) -> int:
        """Number of the process."""
        ...

    def submit(self, n: int) -> int:
        """Hand over rows 0 … n - 1 of the outputs; return the index of the first."""
        ...

    def collect(self, least: int) -> Exchange:
        """Wait for that many cycles, then take all there are; none where the process does not cycle any more."""
        ...

    def flush(self) -> int:
        """Drop what was handed over and not yet sent; return the index of the next row."""
        ...

    def protect(self, protection: Any) -> None:
        """Set when and how the process stops the drives by itself; ``protection`` comes from the drivers."""
        ...

    def arm(self, hold_cycles: int) -> None:
        """Hold the last set values for so many cycles, then stop the drives; 0 disarms."""
        ...

    def order_stop(self) -> None:
        """Have the process stop the drives by itself."""
        ...

    def resume(self) -> None:
        """Follow set values again after such a stop."""
        ...

    def silence(self) -> None:
        """Send no process data any more and end; nothing is waited for."""
        ...
