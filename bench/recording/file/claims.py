"""What a file may claim of itself: looked at before any memory is taken for it."""

from __future__ import annotations

import math
from pathlib import Path

import h5py

from bench.errors import RecordingError
from bench.recording.file.channel_names import FOLDERS, channel_names

MAX_ROWS = 100_000_000
"""Rows of a channel: 13 hours at 2 kHz."""
MAX_TABLE_ROWS = 1_000_000
"""Segments or events."""
MAX_CHANNELS = 1000
MAX_TEXT_BYTES = 16 << 20
"""A bench configuration, or one column of a table."""
_BEST_COMPRESSION = 1100
"""Deflate makes at most 1032 bytes of one (zlib's technical details), and headers."""

_TABLES = ("segments", "events")
_GROUPS = ("channels", *(f"channels/{name}" for name in FOLDERS), "setpoint", "gearbox", "software", *_TABLES)


def check_claims(file: h5py.File, path: Path) -> None:
    """Refuse links that lead elsewhere, and rows, chunks and texts that the file cannot hold.

    Raises
    ------
    RecordingError
        One sentence: what is claimed, and what may be.
    """
    check_around(file, path)
    channels = file.get("channels")
    if isinstance(channels, h5py.Group):
        check_members(channels, path)
        for name in channel_names(channels):
            check_channel(channels.get(name), path, name)


def check_around(file: h5py.File, path: Path) -> None:
    """As :func:`check_claims`, all but the channels themselves."""
    _check_links(file, path, "")
    for name in _GROUPS:
        group = file.get(name)
        if isinstance(group, h5py.Group):
            _check_links(group, path, f"/{name}")
    for table in _TABLES:
        group = file.get(table)
        for name in group if isinstance(group, h5py.Group) else ():
            _check_dataset(group.get(name), path, f"/{table}/{name}", MAX_TABLE_ROWS, MAX_TEXT_BYTES)
    _check_dataset(file.get("config"), path, "/config", 1, MAX_TEXT_BYTES)


def check_members(channels: h5py.Group, path: Path) -> None:
    """Refuse too many channels."""
    if len(channels) > MAX_CHANNELS:
        raise RecordingError(f"{path}: /channels has {len(channels)} members, at most {MAX_CHANNELS} are read.")


def check_channel(dataset: object, path: Path, name: str) -> None:
    """Refuse a channel that is elsewhere, or claims more than it can hold."""
    _check_dataset(dataset, path, f"/channels/{name}", MAX_ROWS, None)


def _check_links(group: h5py.Group, path: Path, where: str) -> None:
    for name in group:
        if group.id.links.get_info(name.encode()).type == h5py.h5l.TYPE_HARD:
            continue
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink):
            text = f"is a link to the file {link.filename!r}, a recording holds all it says itself"
        elif isinstance(link, h5py.SoftLink):
            text = f"is a soft link to {link.path!r}, a recording has none"
        else:
            continue
        raise RecordingError(f"{path}: {where}/{name} {text}.")


def _check_dataset(dataset: object, path: Path, name: str, most_rows: int, most_bytes: int | None) -> None:
    where = f"{path}: {name}"
    if not isinstance(dataset, h5py.Dataset) or dataset.shape is None:
        return
    if dataset.is_virtual or dataset.external:
        raise RecordingError(f"{where} has its samples in other files, a recording holds them itself.")
    rows, width = math.prod(dataset.shape), dataset.dtype.itemsize
    if rows > most_rows:
        raise RecordingError(f"{where} claims {rows} rows, at most {most_rows} are read.")
    if most_bytes is not None and rows * width > most_bytes:
        raise RecordingError(f"{where} claims {rows * width} bytes, at most {most_bytes} are read.")
    if dataset.chunks is None:
        held, stored = rows * width, path.stat().st_size
    else:
        held, stored = math.prod(dataset.chunks) * width, dataset.id.get_storage_size()
    if stored and held > stored * _BEST_COMPRESSION:
        raise RecordingError(f"{where} claims {held} bytes in {stored} that are stored; no compression gives as much.")
