"""Writing a recording while it is made: a valid file at any moment, whatever happens to the process.

``append`` only copies; a thread compresses the chunks (zlib works without the interpreter lock), writes and flushes
them, so that neither the bus nor the emulator waits for the disk.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.recording.header import PART_SUFFIX, ChannelSpec, Event, RecordingHeader, Segment
from bench.recording.writing import layout
from bench.recording.writing.sink import Sink

FAST_CHUNK_ROWS = 8192
"""Chunk size for emulated time, where rows come by the hundred thousand a second."""
_SMALLEST_CHUNK_ROWS = 256


def real_time_chunk_rows(sample_rate: float) -> int:
    """Chunk size for real time: a quarter of a second, so that each flush finds whole chunks."""
    return max(round(sample_rate / 4), _SMALLEST_CHUNK_ROWS)


class RecordingWriter:
    """Write one recording to ``<path>.part`` and give it its name when it is finished.

    Used as a context manager it is closed, complete, at the end of the block; an exception leaves the ``.part`` file
    closed and readable, without ``complete``.

    Parameters
    ----------
    path : final path, ``<recording_id>.h5``.
    header, channels : what stands in the file; blocks must hold exactly these channels.
    chunk_rows : rows of an HDF5 chunk; by default :func:`real_time_chunk_rows`, in emulated time
        :data:`FAST_CHUNK_ROWS` makes smaller files that are faster to read.
    replace : whether a finished recording of this name may be replaced; an unfinished one is set aside in any case.
    wait : whether :meth:`append` and events may wait for a disk that is far behind.
    part : where it is written until it is finished, in the same folder; by default ``<path>.part``.

    Raises
    ------
    RecordingError
        Channels that the format does not allow, blocks that do not fit them, a file that is there already or belongs to
        a living process, a disk that is full or gone.
    """

    def __init__(
        self,
        path: str | Path,
        header: RecordingHeader,
        channels: Sequence[ChannelSpec],
        *,
        chunk_rows: int | None = None,
        part: Path | None = None,
        replace: bool = False,
        wait: bool = True,
    ) -> None:
        self.path = Path(path)
        self.part = part or self.path.with_name(self.path.name + PART_SUFFIX)
        self.rows = 0
        self._specs = {channel.name: channel for channel in channels}
        layout.check_channels(self.path, channels)
        if self.path.exists() and not replace:
            raise RecordingError(f"{self.path}: is there already, a recording is never overwritten.")
        self._chunk_rows = chunk_rows or real_time_chunk_rows(header.sample_rate)
        self._buffers = self._new_buffers()
        self._segment_count = 0
        self._open_segment: int | None = None
        self._closed = False
        self._sink = Sink(self.part, header, channels, self._chunk_rows, self._partial, wait)

    def __enter__(self) -> RecordingWriter:
        """Give the writer itself; the file is open already."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Finish the recording, or leave its valid prefix where the block raised."""
        if self._closed:
            return
        if kind is None:
            self.close()
        else:
            # The error of the block is the one to report.
            with contextlib.suppress(RecordingError):
                self.abandon()

    def append(self, block: Mapping[str, NDArray[Any]]) -> None:
        """Take a block of rows: raw values (n,) of every channel. Returns when they are copied.

        Raises
        ------
        BacklogError
            The disk is too far behind and may not be waited for: the recording ends with these rows.
        RecordingError
            A channel is missing, unknown, of another length or does not fit its type; or the disk refused earlier rows.
        """
        self._check_open()
        arrays = self._check_block(block)
        count = len(next(iter(arrays.values())))
        taken = 0
        while taken < count:
            filled = self.rows % self._chunk_rows
            step = min(count - taken, self._chunk_rows - filled)
            with self._sink.lock:
                for name, array in arrays.items():
                    self._buffers[name][filled : filled + step] = array[taken : taken + step]
                self.rows += step
                whole = filled + step == self._chunk_rows
                if whole:
                    full, self._buffers = self._buffers, self._new_buffers()
            taken += step
            if whole:
                self._sink.put_chunk(self.rows - self._chunk_rows, full)

    def begin_segment(self, name: str) -> None:
        """Start a segment at the next row; a segment that is still open ends there."""
        self._check_open()
        self.end_segment()
        self._open_segment = self._segment_count
        self._segment_count += 1
        self._sink.put_table_rows("segments", [(name, self.rows, -1)])

    def end_segment(self) -> None:
        """End the open segment, if there is one, before the next row."""
        self._check_open()
        if self._open_segment is not None:
            self._sink.put_segment_stop(self._open_segment, self.rows)
            self._open_segment = None

    def event(self, time_s: float, level: str, text: str) -> None:
        """Note an event; ``time_s`` in s since the first sample."""
        self._check_open()
        self._sink.put_table_rows("events", layout.event_rows([Event(time_s, level, text)]))

    def restore(self, segments: Sequence[Segment], events: Sequence[Event]) -> None:
        """Take over segments and events of another recording as they are (for rows already appended)."""
        self._check_open()
        self._segment_count += len(segments)
        self._sink.put_table_rows("segments", layout.segment_rows(segments))
        self._sink.put_table_rows("events", layout.event_rows(events))

    def close(
        self, *, accepted: bool | None = None, quality: Mapping[str, Any] | None = None, complete: bool = True
    ) -> Path:
        """Finish: write what is left, close, force to the disk, rename, force the folder. Gives the final path.

        ``complete=False`` says that the run was cut short (a fault, an abort); its rows are a valid prefix.
        """
        if complete:
            self.end_segment()
        self._check_open()
        self._closed = True
        self._sink.finish(accepted=accepted, quality=quality, complete=complete)
        try:
            layout.finish(self.part, self.path)
        except OSError as error:
            raise RecordingError(
                f"{self.part}: is whole, but cannot be renamed to {self.path.name} ({error})."
            ) from error
        return self.path

    def abandon(self) -> None:
        """Close the ``.part`` file with all rows taken so far and leave it, as a kill would."""
        if not self._closed:
            self._closed = True
            self._sink.finish(accepted=None, quality=None, complete=None)

    def _check_open(self) -> None:
        if self._closed:
            raise RecordingError(f"{self.path}: the recording is finished, nothing can be added.")
        self._sink.check()

    def _new_buffers(self) -> dict[str, NDArray[Any]]:
        return {name: np.zeros(self._chunk_rows, spec.dtype) for name, spec in self._specs.items()}

    def _partial(self) -> tuple[int, int, dict[str, NDArray[Any]]]:
        """Give start, filled rows and a copy of the chunk in the making; called with the lock held."""
        filled = self.rows % self._chunk_rows
        copies = {name: buffer.copy() for name, buffer in self._buffers.items()} if filled else {}
        return self.rows - filled, filled, copies

    def _check_block(self, block: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        if block.keys() != self._specs.keys():
            odd = ", ".join(sorted(block.keys() ^ self._specs.keys()))
            raise RecordingError(f"{self.path}: a block must hold the channels of the recording, it differs in {odd}.")
        arrays = {name: np.asarray(array) for name, array in block.items()}
        shapes = {array.shape for array in arrays.values()}
        if len(shapes) != 1 or len(next(iter(shapes))) != 1:
            raise RecordingError(f"{self.path}: the channels of a block differ in shape ({shapes}).")
        return {name: layout.exact(self.path, self._specs[name], array) for name, array in arrays.items()}
