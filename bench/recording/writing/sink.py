"""The thread that owns the HDF5 file of a recording in the making."""

from __future__ import annotations

import queue
import threading
import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from bench.errors import BacklogError, RecordingError
from bench.recording.file.ownership import make_room
from bench.recording.header import ChannelSpec, RecordingHeader
from bench.recording.reader import HDF5_ERRORS
from bench.recording.writing import layout
from bench.recording.writing.ordered_file import OrderedFile

FLUSH_INTERVAL_S = 0.4
"""A little below the half second promised, to leave time for the flush itself."""
_MIN_FLUSH_SPACING_S = 0.2
_QUEUE_WAITING = 32
"""Jobs that may wait where whoever records waits for the disk."""
_QUEUE_BACKLOG = 256
"""Jobs that may wait where nobody does: a minute of chunks."""
_UNFILTERED = 0b11  # filter mask: shuffle and deflate both left out of this chunk

Columns = dict[str, NDArray[Any]]
Partial = Callable[[], tuple[int, int, Columns]]


def compress(values: NDArray[Any]) -> bytes:
    """Shuffle the bytes of a chunk and deflate them at level 1, as the HDF5 filters of these names do."""
    planes = np.ascontiguousarray(values.view(np.uint8).reshape(values.size, values.itemsize).T)
    return zlib.compress(planes.tobytes(), 1)


class Sink:
    """Write chunks, table rows and the end of a recording in a thread of its own.

    Parameters
    ----------
    partial : gives start, filled rows and a copy of the chunk that is not full yet; called with ``lock`` held.
    wait : whoever records waits while the disk is far behind. Without, nothing here ever waits for the disk but
        :meth:`finish`; a disk that is too far behind ends the recording.
    """

    def __init__(
        self,
        part: Path,
        header: RecordingHeader,
        channels: Sequence[ChannelSpec],
        chunk_rows: int,
        partial: Partial,
        wait: bool = True,
    ) -> None:
        self.lock = threading.Lock()
        self.rows_written = 0
        self._part = part
        self._partial = partial
        self._unfiltered_start = -1
        self._error: Exception | None = None
        self._wait = wait
        self._jobs: queue.Queue[Callable[[], None] | None] = queue.Queue(_QUEUE_WAITING if wait else _QUEUE_BACKLOG)
        self._too_late: list[Callable[[], None]] = []
        try:
            make_room(part)
            self._storage = OrderedFile(part)
            self._file = h5py.File(self._storage, "w")
            layout.write_skeleton(self._file, header, channels, chunk_rows)
            self._datasets = {channel.name: self._file["channels"][channel.name] for channel in channels}
            self._flush()
        except OSError as error:
            raise RecordingError(f"{part}: cannot be created ({error}).") from error
        self._thread = threading.Thread(target=self._run, name=f"writer {part.name}", daemon=True)
        self._thread.start()

    def check(self) -> None:
        """Raise what went wrong in the thread."""
        if self._error is not None:
            raise RecordingError(
                f"{self._part}: writing failed after row {self.rows_written} ({self._error}); "
                "what was flushed before is readable."
            ) from self._error

    def put_chunk(self, start: int, columns: Columns) -> None:
        """Queue a whole chunk.

        Raises
        ------
        BacklogError
            If the disk is too far behind and may not be waited for; this chunk is still written by :meth:`finish`.
        """
        self._enqueue(lambda: self._write_chunk(start, len(next(iter(columns.values()))), columns))

    def put_table_rows(self, table: str, rows: Sequence[Sequence[Any]]) -> None:
        """Queue rows of ``segments`` or ``events``."""
        self._enqueue(lambda: layout.append_rows(self._file, table, rows))

    def put_segment_stop(self, index: int, stop: int) -> None:
        """Queue the end of a segment."""
        self._enqueue(lambda: self._write_stop(index, stop))

    def finish(self, *, accepted: bool | None, quality: Mapping[str, Any] | None, complete: bool | None) -> None:
        """Write everything and close the file; ``complete=None`` leaves the attribute out."""
        self._jobs.put(None)
        self._thread.join()
        try:
            if self._error is None:
                for job in self._too_late:
                    job()
                self._write_partial(last=True)
                if complete is not None:
                    layout.write_end(self._file, accepted=accepted, quality=quality, complete=complete)
                self._flush()
        except HDF5_ERRORS as error:
            self._error = error
        self._close_file()
        self.check()

    def _enqueue(self, job: Callable[[], None]) -> None:
        if self._wait:
            self._jobs.put(job)
            self.check()
            return
        self.check()
        try:
            if not self._too_late:
                self._jobs.put_nowait(job)
                return
        except queue.Full:
            self._too_late.append(job)
        raise BacklogError(
            f"{self._part}: the disk has not kept up, {self._jobs.maxsize} pieces of the recording wait for it; the"
            " recording ends here"
        )

    def _run(self) -> None:
        flushed_at = time.monotonic()
        while True:
            try:
                job = self._jobs.get(timeout=max(flushed_at + FLUSH_INTERVAL_S - time.monotonic(), 0.01))
            except queue.Empty:
                job = self._write_partial
            if job is None:
                return
            if self._error is not None:
                continue  # drain, so that nobody waits for a queue that is never emptied
            empty = self.rows_written == 0
            try:
                job()
                # The first rows at once: a disk that refuses soon after has them, however late this thread is.
                if (empty and self.rows_written) or time.monotonic() - flushed_at >= _MIN_FLUSH_SPACING_S:
                    self._flush()
                    flushed_at = time.monotonic()
            except (*HDF5_ERRORS, MemoryError) as error:
                self._error = error

    def _write_partial(self, *, last: bool = False) -> None:
        """Write the chunk in the making, when no whole one has come for a while.

        Such a chunk is stored without compression, now and when it is full: its place and size then stay the same and
        rows are added behind those already there, so that no moment exists in which the file lacks them. The last
        chunk of a recording is compressed if it was never written before.
        """
        with self.lock:
            start, count, columns = self._partial()
        if count and start + count > self.rows_written and start <= self.rows_written:
            if not last:
                self._unfiltered_start = start
            self._write_chunk(start, count, columns)

    def _write_chunk(self, start: int, count: int, columns: Columns) -> None:
        unfiltered = start == self._unfiltered_start
        for name, values in columns.items():
            dataset = self._datasets[name]
            dataset.resize((start + count,))
            if unfiltered:
                dataset.id.write_direct_chunk((start,), values.tobytes(), _UNFILTERED)
            else:
                dataset.id.write_direct_chunk((start,), compress(values))
        self.rows_written = start + count

    def _write_stop(self, index: int, stop: int) -> None:
        self._file["segments"]["stop"][index] = stop

    def _flush(self) -> None:
        self._file.flush()
        self._storage.commit()

    def _close_file(self) -> None:
        try:
            self._file.close()
            self._storage.commit()
        except (*HDF5_ERRORS, MemoryError) as error:
            self._error = self._error or error
        finally:
            self._storage.close()
