"""What of a file is really stored: HDF5 reads chunks that were never written as zeros, without a word."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import h5py

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
# Where the superblock keeps the end of the file, by its version (HDF5 File Format Specification 3.0, II.A).
_END_OFFSET = {0: 40, 1: 44, 2: 28, 3: 28}


def first_missing_row(dataset: h5py.Dataset, file_size: int | None = None) -> int | None:
    """Give the first row whose chunk was never stored; None where all are there or the dataset is not chunked.

    ``file_size`` is what is left of a file that was truncated: chunks beyond it count as not stored.
    """
    if dataset.chunks is None or not dataset.shape[0]:
        return None
    (rows,) = dataset.chunks
    expected = range(0, dataset.shape[0], rows)
    if file_size is None and dataset.id.get_num_chunks() == len(expected):
        return None
    for start in expected:
        try:
            place = dataset.id.get_chunk_info_by_coord((start,))
        except (OSError, RuntimeError, ValueError):
            return start
        if place.byte_offset is None or (file_size is not None and place.byte_offset + place.size > file_size):
            return start
    return None


@contextmanager
def completed_copy(path: Path) -> Iterator[tuple[Path, int | None]]:
    """Give a file that HDF5 will open, and the size of what is left where ``path`` was truncated.

    HDF5 refuses a file that is shorter than it once was, however much of it is whole. A copy is brought to the old
    length with zeros; chunks in that part are then known to be lost.
    """
    size = path.stat().st_size
    end = _stored_end(path)
    if end is None or end <= size:
        yield path, None
        return
    with TemporaryDirectory(prefix=".repair-", dir=path.parent) as folder:
        copy = Path(folder) / path.name
        shutil.copyfile(path, copy)
        with copy.open("r+b") as file:
            file.truncate(end)
        yield copy, size


def _stored_end(path: Path) -> int | None:
    with path.open("rb") as file:
        head = file.read(64)
    if len(head) < 64 or not head.startswith(_SIGNATURE) or head[8] not in _END_OFFSET:
        return None
    offset = _END_OFFSET[head[8]]
    return int.from_bytes(head[offset : offset + 8], "little")
