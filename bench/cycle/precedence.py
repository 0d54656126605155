"""Let the rig go before ordinary programs: set values are ahead of the bus, but not for ever."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

_NICE = -10


@contextmanager
def precedence(wanted: bool = True) -> Iterator[str | None]:
    """Raise this thread, and those it starts, above ordinary programs for a while; yields a sentence if it may not."""
    before = os.getpriority(os.PRIO_PROCESS, 0)
    refused = None
    if wanted and before > _NICE:
        try:
            os.setpriority(os.PRIO_PROCESS, 0, _NICE)
        except PermissionError:
            refused = "the rig has no precedence over other programs and may fall behind them: CAP_SYS_NICE is needed"
    try:
        yield refused
    finally:
        os.setpriority(os.PRIO_PROCESS, 0, before)
