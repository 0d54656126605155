"""A recording from arrays that are already there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bench.errors import RecordingError
from bench.recording.header import ChannelSpec, Event, RecordingHeader, Segment
from bench.recording.writing.writer import FAST_CHUNK_ROWS, RecordingWriter


def write_recording(
    path: str | Path,
    header: RecordingHeader,
    channels: Mapping[str, tuple[ArrayLike, ChannelSpec]],
    segments: Sequence[Segment] = (),
    events: Sequence[Event] = (),
    *,
    accepted: bool | None = None,
    quality: Mapping[str, Any] | None = None,
) -> None:
    """Write a complete recording at once; where it is refused, no file is left, and one that was there stays.

    Parameters
    ----------
    channels : raw values (N,) and specification by name; all of one length, ``time`` among them.
    segments, events : rows of their tables, in this order.
    accepted, quality : result of the quality gate, where there was one.

    Raises
    ------
    RecordingError
        Channels of unequal length, without ``time``, or of a type the format does not allow.
    """
    arrays = {name: np.asarray(values) for name, (values, _) in channels.items()}
    specs = [spec for _, spec in channels.values()]
    rows = max((array.size for array in arrays.values()), default=0)
    writer = RecordingWriter(path, header, specs, chunk_rows=min(max(rows, 1), FAST_CHUNK_ROWS), replace=True)
    try:
        with writer:
            writer.append(arrays)
            writer.restore(segments, events)
            writer.close(accepted=accepted, quality=quality)
    except RecordingError:
        writer.part.unlink(missing_ok=True)
        raise
