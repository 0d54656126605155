"""Finishes recordings in the background, and writes the result of each into the journal, in their order."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

from bench.campaigns.listener import Listener
from bench.campaigns.records.journal import Journal
from bench.campaigns.records.recorder import Recorder
from bench.campaigns.taken import Status, Summary, Taken
from bench.errors import one_sentence


class Closer:
    """The recordings of one run that are on their way to the disk.

    A recording that cannot be finished is a failed take: the next run makes of its rows what can be made.
    """

    def __init__(self, pool: ThreadPoolExecutor, journal: Journal, summary: Summary, listener: Listener) -> None:
        self._pool, self._journal, self._summary, self._listener = pool, journal, summary, listener
        self._waiting: list[Future[Taken]] = []

    @property
    def waiting(self) -> int:
        """Recordings of which the journal does not know the end yet."""
        return len(self._waiting)

    @property
    def is_busy(self) -> bool:
        """Whether the last recording is still being finished."""
        return bool(self._waiting) and not self._waiting[-1].done()

    def close(self, recorder: Recorder, taken: Taken, complete: bool) -> None:
        """Begin to finish a recording."""

        def finish() -> Taken:
            try:
                recorder.close(complete=complete, accepted=taken.status is Status.DONE, quality=taken.quality)
            except Exception as error:  # noqa: BLE001 - handed on as what became of the take
                return replace(taken, status=Status.FAILED, note=one_sentence(error))
            return taken

        self._waiting.append(self._pool.submit(finish))

    def collect(self, wait: bool) -> None:
        """Write down what is finished, or all of it.

        Raises
        ------
        DeviceError
            If the journal cannot be written; what was not is kept for the next time.
        """
        while self._waiting and (wait or self._waiting[0].done()):
            taken = self._waiting[0].result()
            self._journal.end(taken)
            self._waiting.pop(0)
            self._summary.taken.append(taken)
            self._listener.finished(taken)
