"""What the bus process receives once: who is on the bus, when to stop by itself and how, how to be scheduled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from drivers.ethercat.slave import SlaveSpec


@dataclass(frozen=True, slots=True)
class RealTime:
    """How the process asks to be scheduled; what it does not get it says in a sentence and does without.

    Attributes
    ----------
    priority : of SCHED_FIFO, 1–99; None leaves the ordinary scheduling.
    cpu : processor to be pinned to; None: the last isolated one, where the kernel keeps any for such work.
    lock_memory : keep every page in memory (mlockall).
    """

    priority: int | None = 80
    cpu: int | None = None
    lock_memory: bool = True


@dataclass(frozen=True, slots=True)
class Watch:
    """An integer entry of a slave's inputs that must stay within low … high.

    One reading beyond is noise; ``patience`` of them in a row stop the bus process's drives.
    """

    slave: str
    entry: str
    low: int
    high: int
    patience: int

    @property
    def broken(self) -> str:
        """What is said once it has stopped the drives."""
        return f"{self.slave} {self.entry} left {self.low} … {self.high} for {self.patience} cycles in a row"


@dataclass(frozen=True, slots=True)
class Condition:
    """Fulfilled while an entry of a slave's inputs, masked, has a value."""

    slave: str
    entry: str
    mask: int
    value: int


@dataclass(frozen=True, slots=True)
class StopStep:
    """One step of the stop the process does by itself: the outputs it sends, and until when.

    Attributes
    ----------
    outputs : process image of all slaves.
    cycles : longest time.
    until : the step ends earlier when all of these hold; empty: it takes its time.
    """

    outputs: bytes
    cycles: int
    until: tuple[Condition, ...] = ()


@dataclass(frozen=True, slots=True)
class Protection:
    """When the process stops the drives by itself, and how.

    Attributes
    ----------
    steps : sent one after the other; the last one's outputs stay. After a broken limit only the last one is sent.
    watches : limits on inputs.
    bad_cycles : cycles in a row with a wrong working counter.
    """

    steps: tuple[StopStep, ...] = ()
    watches: tuple[Watch, ...] = ()
    bad_cycles: int = 1 << 30


@dataclass(frozen=True, slots=True)
class Setup:
    """Everything a bus process starts with; ``slaves`` come without their ``configure``, which runs in the rig.

    ``master`` is ``module:function`` of a factory that is called with ``arguments``; ``make_up_s`` as of
    :class:`drivers.ethercat.AbsoluteDeadlines`.
    """

    master: str
    arguments: dict[str, Any]
    interface: str
    slaves: tuple[SlaveSpec, ...]
    has_configure: tuple[bool, ...]
    cycle_time_s: float
    set_rows: int
    image_rows: int
    real_time: RealTime
    make_up_s: float = 0.0
