"""Feed the set values of a run to the bench and hand back, block by block, what came of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bench.cycle.ahead import AheadLink
from bench.cycle.decode import Decoded
from bench.cycle.link import Link
from bench.cycle.sink import Sink
from bench.cycle.trajectory import Trajectory
from bench.protocols import Segment
from bench.safety import Inputs, Verdict

FloatArray = NDArray[np.float64]
Judge = Callable[[Inputs], Verdict]


@dataclass(frozen=True, slots=True)
class Fed:
    """Cycles that came back.

    Attributes
    ----------
    decoded : the cycles.
    verdict : of the safety step on them.
    changes : offsets at which the recording's segment changes.
    start, stop : which of them belong to the run; the others came before it or are after its end.
    """

    decoded: Decoded
    verdict: Verdict
    changes: tuple[tuple[int, Segment | None], ...]
    start: int
    stop: int


class Feed(Protocol):
    """Gives the set values of one trajectory to the bench."""

    @property
    def finished(self) -> bool:
        """Whether every cycle of the trajectory has come back."""
        ...

    def next(self, judge: Judge) -> Fed | None:
        """Go on by a block; None where there was nothing to exchange."""
        ...


class BlockFeed:
    """Exchanges block by block; goes back to the very cycle of a trip where the master can."""

    def __init__(self, link: Link, trajectory: Trajectory) -> None:
        self._link, self._trajectory = link, trajectory

    @property
    def finished(self) -> bool:
        """Whether the trajectory is done."""
        return self._trajectory.finished

    def next(self, judge: Judge) -> Fed | None:
        """Exchange a block."""
        block = self._trajectory.block(self._link.assembly.block)
        if not block.size:
            return None
        decoded, verdict = run_guarded(self._link, block.velocity, block.load_torque, judge)
        changes = tuple((change.offset, change.segment) for change in block.changes if change.offset < decoded.size)
        return Fed(decoded, verdict, changes, 0, decoded.size)


def run_guarded(link: Link, velocity: FloatArray, torque: FloatArray, judge: Judge) -> tuple[Decoded, Verdict]:
    """Exchange set values (n,) and judge; where the master can go back, a trip ends the block at its very cycle."""
    memory = link.remember() if velocity.size > 1 and link.assembly.can_replay else None
    decoded = link.exchange(velocity, torque)
    verdict = judge(decoded.inputs)
    keep = verdict.cycle + 1
    if verdict.tripped and memory is not None and keep < velocity.size:
        link.go_back(memory)
        decoded = link.exchange(velocity[:keep], torque[:keep])
    return decoded, verdict


class AheadFeed:
    """Keeps set values ahead of the bus process, so that a rig that is late delays no cycle.

    What was ahead from before is dropped first: the run starts with the next cycle.
    """

    def __init__(self, link: AheadLink, trajectory: Trajectory) -> None:
        self._link, self._trajectory = link, trajectory
        self._block, self._ahead = link.assembly.block, link.assembly.ahead
        self._first = self._last = link.flush()
        self._seen = -1
        self._changes: deque[tuple[int, Segment | None]] = deque()

    @property
    def finished(self) -> bool:
        """Whether the cycle of the last set value has come back."""
        return self._trajectory.finished and self._seen >= self._last - 1

    def next(self, judge: Judge) -> Fed | None:
        """Fill up what is ahead, take what has come."""
        self._fill()
        decoded = self._link.collect(self._block)
        index = decoded.set_index
        assert index is not None
        verdict = judge(decoded.inputs)
        # the process counts set values up, and none twice unless it holds one
        start = int(np.searchsorted(index, self._first))
        stop = int(np.searchsorted(index, self._last)) if self._trajectory.finished else index.size
        if index.size:
            self._seen = max(self._seen, int(index[-1]))
        changes = []
        while self._changes and stop > start and self._changes[0][0] <= index[stop - 1]:
            at, segment = self._changes.popleft()
            changes.append((int(np.searchsorted(index, at)), segment))
        return Fed(decoded, verdict, tuple(changes), start, stop)

    def _fill(self) -> None:
        link, trajectory = self._link, self._trajectory
        while link.queued < self._ahead:
            block = trajectory.block(self._block)
            if block.size:
                first = link.submit(block.velocity, block.load_torque)
                self._last = first + block.size
                self._changes.extend((first + change.offset, change.segment) for change in block.changes)
            elif trajectory.finished:
                # the last set values go on, until somebody wants something else
                link.submit(np.full(self._block, link.velocity), np.full(self._block, link.torque))
            else:
                return


def make_feed(link: Link, trajectory: Trajectory) -> Feed:
    """Return the feed that suits the link."""
    return AheadFeed(link, trajectory) if isinstance(link, AheadLink) else BlockFeed(link, trajectory)


def emit(fed: Fed, sink: Sink) -> None:
    """Hand cycles of a run on to a sink, with the segments that begin among them."""
    begin = fed.start
    for offset, segment in fed.changes:
        hand_on(fed.decoded, begin, offset, sink)
        sink.segment(segment)
        begin = max(begin, offset)
    hand_on(fed.decoded, begin, fed.stop, sink)


def hand_on(decoded: Decoded, start: int, stop: int, sink: Sink) -> None:
    """Hand cycles ``start`` to ``stop`` on; a lost cycle leaves no row, one that was made up for an event."""
    if stop <= start:
        return
    late_s = None if decoded.late_s is None else decoded.late_s[start:stop]
    if late_s is not None and late_s.any():
        made_up = np.count_nonzero(late_s)
        sink.event("info", f"{made_up} cycles began up to {1e3 * late_s.max():.1f} ms late and were made up for")
    good = decoded.inputs.good[start:stop]
    rows = {name: values[start:stop] for name, values in decoded.raw.items()}
    sink.rows(rows if good.all() else {name: values[good] for name, values in rows.items()})
