"""Processor time that the host of a virtual machine takes away (steal), reported with every figure of punctuality."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

_STAT = Path("/proc/stat")
_STEAL = 8
"""Place of the stolen time in the lines of /proc/stat."""
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_PERIOD_S = 0.01


def steal_s() -> float:
    """Return the time the host took from all processors of this machine since it started, s; 0 where nobody knows."""
    try:
        fields = _STAT.read_text().partition("\n")[0].split()
    except OSError:  # not a Linux
        return 0.0
    return int(fields[_STEAL]) / _TICKS_PER_S


class StealLog:
    """Notes when time was stolen, to the tick of the kernel's account; a context manager.

    Attributes
    ----------
    total_s : time stolen so far.
    """

    def __init__(self) -> None:
        self.total_s = 0.0
        self._moments: list[int] = []
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="steal", daemon=True)

    def __enter__(self) -> StealLog:
        """Begin to look."""
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop looking."""
        self._stop.set()
        self._thread.join()

    def near(self, moments_ns: NDArray[np.int64], within_s: float = 0.05) -> NDArray[np.bool_]:
        """Mask (n,) of moments (monotonic clock, ns) with stolen time not farther away than ``within_s``."""
        stolen = np.sort(np.array(self._moments, np.int64))
        if not stolen.size:
            return np.zeros(moments_ns.size, np.bool_)
        after = np.clip(np.searchsorted(stolen, moments_ns), 0, stolen.size - 1)
        before = np.clip(after - 1, 0, stolen.size - 1)
        distance = np.minimum(abs(stolen[after] - moments_ns), abs(stolen[before] - moments_ns))
        mask: NDArray[np.bool_] = distance <= within_s * 1e9
        return mask

    def _watch(self) -> None:
        first = last = steal_s()
        while not self._stop.wait(_PERIOD_S):
            now = steal_s()
            if now > last:
                self._moments.append(time.monotonic_ns())
            last = now
            self.total_s = now - first
