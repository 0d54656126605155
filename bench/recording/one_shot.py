"""A recording from arrays that are already there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike

from bench.errors import RecordingError
from bench.recording import _layout
from bench.recording.header import PART_SUFFIX, ChannelSpec, Event, RecordingHeader, Segment

_CHUNK_ROWS = 16384


def write_recording(
    path: str | Path,
    header: RecordingHeader,
    channels: Mapping[str, tuple[ArrayLike, ChannelSpec]],
    segments: Iterable[Segment] = (),
    events: Iterable[Event] = (),
    *,
    accepted: bool | None = None,
    quality: Mapping[str, Any] | None = None,
) -> None:
    """Write a complete recording at once, through a ``.part`` file that is renamed when it is on the disk.

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
    path = Path(path)
    arrays = {name: np.asarray(values) for name, (values, _) in channels.items()}
    specs = [spec for _, spec in channels.values()]
    _layout.check_channels(path, specs)
    sizes = {array.shape for array in arrays.values()}
    if len(sizes) != 1 or len(next(iter(sizes))) != 1:
        raise RecordingError(f"{path}: the channels differ in shape ({sizes}), they should all be (N,).")
    (size,) = sizes.pop()
    part = path.with_name(path.name + PART_SUFFIX)
    with h5py.File(part, "w") as file:
        _layout.write_skeleton(file, header, specs, max(min(size, _CHUNK_ROWS), 1))
        for spec in specs:
            dataset = file["channels"][spec.name]
            dataset.resize((size,))
            dataset[...] = _layout.exact(path, spec, arrays[spec.name])
        _layout.append_rows(file, "segments", _layout.segment_rows(segments))
        _layout.append_rows(file, "events", _layout.event_rows(events))
        _layout.write_end(file, accepted=accepted, quality=quality)
    _layout.finish(part, path)
