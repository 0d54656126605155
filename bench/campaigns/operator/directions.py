"""What an operator asks of a run while it goes on: pause, skip, repeat, a note, the end. Set from any thread."""

from __future__ import annotations

import threading

from bench.campaigns.operator.remark import clean_remark


class Directions:
    """Wishes of the operator; the runner looks at them between blocks and between points.

    Points are named by their identity (:func:`bench.campaigns.taken.point_id`).
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._stop = threading.Event()
        self._paused = False
        self._skipped: set[str] = set()
        self._again: list[str] = []
        self._notes: list[str] = []

    @property
    def stop_requested(self) -> bool:
        """Whether the run is to end at rest, now."""
        return self._stop.is_set()

    @property
    def paused(self) -> bool:
        """Whether no further point is to begin."""
        return self._paused

    def stop(self) -> None:
        """Bring the bench to rest and end the run; there is no way back."""
        self._stop.set()

    def pause(self) -> None:
        """Begin no further point; the one that runs is finished."""
        self._paused = True

    def go_on(self) -> None:
        """End a pause."""
        self._paused = False

    def skip(self, identity: str) -> None:
        """Leave a point out of this run; if it runs, it is brought to rest and cut short."""
        with self._lock:
            self._skipped.add(identity)
            self._again = [other for other in self._again if other != identity]

    def is_skipped(self, identity: str) -> bool:
        """Whether a point is to be left out."""
        with self._lock:
            return identity in self._skipped

    def repeat(self, identity: str) -> None:
        """Measure a point once more after the one that runs."""
        with self._lock:
            self._skipped.discard(identity)
            if identity not in self._again:
                self._again.append(identity)

    def take_repeat(self) -> str | None:
        """Return the next point to be measured once more and forget it; None if there is none."""
        with self._lock:
            return self._again.pop(0) if self._again else None

    def note(self, text: str) -> None:
        """Write a remark into the recording that runs, or into the next one.

        Raises
        ------
        ConfigurationError
            If it is too long, or holds nothing that can be printed.
        """
        remark = clean_remark(text)
        with self._lock:
            self._notes.append(remark)

    def take_notes(self) -> list[str]:
        """Return the remarks not yet written and forget them."""
        with self._lock:
            notes, self._notes = self._notes, []
            return notes
