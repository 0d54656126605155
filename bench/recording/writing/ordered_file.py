"""A file whose every intermediate state on the disk is a readable HDF5 file.

A flush of the HDF5 library overwrites object headers, chunk indices and the superblock one after another; a process
that is killed in between leaves a file in which some of them point to what is not there yet. Here, whatever is written
behind the part of the file that is already referred to goes to the disk at once (nothing refers to it yet), and what
would overwrite is held back until :meth:`OrderedFile.commit`, which writes it in an order in which no pointer comes
before its target: the superblock (end of the allocated space), chunk indices from the root down, and the rest, the
sizes of datasets among it, last. (HDF5 File Format Specification 3.0, II.A superblock, III.A.1 version 1 B-trees.)
"""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import Any

from bench.recording.file.ownership import claim

_TREE_SIGNATURE = b"TREE"
_TREE_LEVEL_OFFSET = 5


def _rank(offset: int, data: bytes) -> tuple[int, int, int]:
    """Order of a held-back write: superblock, trees from the root down, everything else by address."""
    if offset == 0:
        return (0, 0, 0)
    if data.startswith(_TREE_SIGNATURE):
        return (1, -data[_TREE_LEVEL_OFFSET], offset)
    return (2, 0, offset)


class OrderedFile(io.RawIOBase):
    """A file object for ``h5py.File`` that keeps the file on disk consistent at any moment."""

    def __init__(self, path: Path) -> None:
        """Create ``path``; it should not exist."""
        super().__init__()
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o644)
        claim(self._descriptor)
        self._position = 0
        self._committed_end = 0
        self._held: dict[int, bytes] = {}

    def readable(self) -> bool:
        """Files of h5py are read as well as written."""
        return True

    def writable(self) -> bool:
        """Say that the file can be written."""
        return True

    def seekable(self) -> bool:
        """Say that the file can be positioned."""
        return True

    def tell(self) -> int:
        """Give the position of the next read or write."""
        return self._position

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the position of the next read or write."""
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._position, os.SEEK_END: os.fstat(self._descriptor).st_size}
        self._position = base[whence] + offset
        return self._position

    def readinto(self, buffer: Any) -> int:
        """Read what was written last, held back or not."""
        view = memoryview(buffer).cast("B")
        start, data = self._position, bytearray(os.pread(self._descriptor, len(view), self._position))
        for offset, held in self._held.items():
            first, last = max(offset, start), min(offset + len(held), start + len(view))
            if first < last:
                if last - start > len(data):
                    data.extend(bytes(last - start - len(data)))
                data[first - start : last - start] = held[first - offset : last - offset]
        view[: len(data)] = data
        self._position += len(data)
        return len(data)

    def write(self, buffer: Any) -> int:
        """Write new space at once, hold back what would overwrite."""
        data = bytes(buffer)
        offset = self._position
        old = min(max(self._committed_end - offset, 0), len(data))
        if old:
            self._hold(offset, data[:old])
        if old < len(data):
            self._write_all(offset + old, data[old:])
        self._position += len(data)
        return len(data)

    def truncate(self, size: int | None = None) -> int:
        """Extend the file at once; never shorten what may be referred to."""
        size = self._position if size is None else size
        os.ftruncate(self._descriptor, max(size, self._committed_end))
        return size

    def flush(self) -> None:
        """Do nothing: the library flushes in between, only :meth:`commit` knows that a flush is whole."""

    def commit(self) -> None:
        """Write everything held back; call after a flush of the library."""
        for offset, data in sorted(self._held.items(), key=lambda item: _rank(*item)):
            self._write_all(offset, data)
        self._held.clear()
        self._committed_end = os.fstat(self._descriptor).st_size

    def close(self) -> None:
        """Close the descriptor, without what was held back and never committed."""
        if not self.closed:
            os.close(self._descriptor)
            super().close()

    def _hold(self, offset: int, data: bytes) -> None:
        overlaps = [
            start for start, held in self._held.items() if start < offset + len(data) and offset < start + len(held)
        ]
        for start in overlaps:
            held = self._held.pop(start)
            first, last = min(start, offset), max(start + len(held), offset + len(data))
            merged = bytearray(last - first)
            merged[start - first : start - first + len(held)] = held
            merged[offset - first : offset - first + len(data)] = data
            offset, data = first, bytes(merged)
        self._held[offset] = data

    def _write_all(self, offset: int, data: bytes) -> None:
        view = memoryview(data)
        while view:
            written = os.pwrite(self._descriptor, view, offset)
            view, offset = view[written:], offset + written
