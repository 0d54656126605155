"""Hold-to-run: a motion goes on only while a page says, again and again, that its button is still held.

The run's own process looks at the clock: a page, a network or a service that goes silent lets go. Nothing moves before
the first word, and while the drives are brought up only the last one counts. Once something moved, a hold that was let
go does not come back; the next motion is a new one.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

SILENT_S = 0.5
"""Without a word for so long the button counts as let go."""


class Hold:
    """Whether the button is held; ``clock`` gives s of a monotonic clock. For any thread."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._until: float | None = None
        self._begun = self._gone = False

    def still(self) -> None:
        """The page reports that its button is still held."""
        with self._lock:
            self._look()
            self._until = self._clock() + SILENT_S

    def let_go(self) -> None:
        """The page reports that its button was let go."""
        with self._lock:
            self._gone = True

    def is_held(self) -> bool:
        """Whether the motion may begin, or go on; once it has been asked and was, silence is for good."""
        with self._lock:
            self._look()
            held = not self._gone and self._until is not None and self._clock() <= self._until
            self._begun = self._begun or held
            return held

    def _look(self) -> None:
        if self._begun and self._until is not None and self._clock() > self._until:
            self._gone = True
