"""Where the samples of a channel lie in the file, and reading them there without the HDF5 library.

The library reads chunks that were never stored as zeros, and a damaged file can crash it. A child process
(:mod:`bench.recording.guarded`) asks it once where each chunk lies; from then on samples are bytes at known places,
checked in length and, where they are compressed, by the checksum of their stream (RFC 1950, Adler-32).
"""

from __future__ import annotations

import os
import zlib
from dataclasses import dataclass
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

_SHUFFLE, _DEFLATE = h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_DEFLATE
_PIPELINES = ((), (_SHUFFLE,), (_DEFLATE,), (_SHUFFLE, _DEFLATE))
_LAST_BYTE = np.iinfo(np.int64).max
"""No file has bytes beyond this address: offsets of files are signed (``off_t``)."""


class Unreadable(OSError):
    """Bytes of a chunk that are not its samples; the text is half a sentence."""


@dataclass(frozen=True, slots=True)
class Places:
    """The chunks of one channel, from the first row on; ``filters`` are HDF5 filter numbers in their order.

    ``offset`` and ``size`` in bytes of the file; a bit of ``mask`` says that the filter of that number was left out.
    """

    dtype: str
    chunk_rows: int
    filters: tuple[int, ...]
    offset: NDArray[np.int64]
    size: NDArray[np.int64]
    mask: NDArray[np.uint32]

    def read(self, descriptor: int, start: int, stop: int) -> NDArray[Any]:
        """Read rows ``start`` to ``stop`` (exclusive).

        Raises
        ------
        Unreadable
            What stands there cannot be a chunk of this channel.
        """
        out = np.empty(stop - start, self.dtype)
        rows = self.chunk_rows
        for number in range(start // rows, -(-stop // rows)) if stop > start else ():
            first = number * rows
            low, high = max(start, first), min(stop, first + rows)
            try:
                self._read_chunk(descriptor, number, low - first, high - first, out[low - start : high - start])
            except zlib.error as error:
                raise Unreadable(f"the chunk from row {first} on cannot be decompressed: {error}") from error
        return out

    def _read_chunk(self, descriptor: int, number: int, low: int, high: int, out: NDArray[Any]) -> None:
        first, whole = number * self.chunk_rows, self.chunk_rows * out.itemsize
        if number >= self.offset.size:
            raise Unreadable(f"rows from {first} on were never stored")
        size, offset = int(self.size[number]), int(self.offset[number])
        data = os.pread(descriptor, size, offset)
        if len(data) != size:
            raise Unreadable(f"the chunk from row {first} on lies beyond the end of the file")
        left_out = int(self.mask[number])
        used = [kind for bit, kind in enumerate(self.filters) if not left_out >> bit & 1]
        if _DEFLATE in used:
            stream = zlib.decompressobj()
            # one byte more than there should be: the checksum at the end is read, and what is too long is seen
            data = stream.decompress(data, whole + 1)
            if not stream.eof:
                raise Unreadable(f"the compressed chunk from row {first} on has no end")
        if len(data) != whole:
            raise Unreadable(f"the chunk from row {first} on has {len(data)} bytes, it should have {whole}")
        if _SHUFFLE in used and out.itemsize > 1:
            planes = np.frombuffer(data, np.uint8).reshape(out.itemsize, self.chunk_rows)
            to = out.view(np.uint8).reshape(-1, out.itemsize)
            # plane by plane: the transposed copy in one go takes five times as long
            for byte in range(out.itemsize):
                to[:, byte] = planes[byte, low:high]
        else:
            out[:] = np.frombuffer(data, out.dtype)[low:high]


def look_up(dataset: h5py.Dataset) -> tuple[int, Places | None]:
    """Count the rows before the first whose chunk was never stored, and give the places of the samples.

    The places are None where only the HDF5 library can read them (in a child).
    """
    rows, chunks = int(dataset.shape[0]), dataset.chunks
    if chunks is None:
        return rows, _contiguous(dataset)
    offset, size, mask = _chunks(dataset)
    stored = min(rows, offset.size * int(chunks[0]))
    if not _as_numpy_has_it(dataset):
        return stored, None
    plist = dataset.id.get_create_plist()
    filters = tuple(plist.get_filter(number)[0] for number in range(plist.get_nfilters()))
    if filters not in _PIPELINES:
        return stored, None
    return stored, Places(dataset.dtype.str, chunks[0], filters, offset, size, mask)


def _contiguous(dataset: h5py.Dataset) -> Places | None:
    offset = dataset.id.get_offset()
    if offset is None or offset > _LAST_BYTE or not _as_numpy_has_it(dataset):  # in the object header, or nowhere
        return None
    one = np.array([offset], np.int64)
    rows, size = max(dataset.size, 1), np.array([dataset.nbytes])
    return Places(dataset.dtype.str, rows, (), one, size, np.zeros(1, np.uint32))


def _as_numpy_has_it(dataset: h5py.Dataset) -> bool:
    if dataset.file.userblock_size:
        return False
    return bool(dataset.id.get_type().equal(h5py.h5t.py_create(dataset.dtype)))


def _chunks(dataset: h5py.Dataset) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.uint32]]:
    """Offset, size and mask of the chunks from the first row on, up to the first that was never stored."""
    rows = dataset.chunks[0]
    found: dict[int, Any] = {}

    def keep(info: Any) -> None:
        found[info.chunk_offset[0] // rows] = info

    try:
        dataset.id.chunk_iter(keep)
    except (OSError, RuntimeError):
        _one_by_one(dataset, found)  # a part of the index is gone: as far as it goes
    infos = []
    for number in range(-(-dataset.shape[0] // rows)):
        info = found.get(number)
        if info is None or info.byte_offset is None or info.byte_offset + info.size > _LAST_BYTE:
            break  # never stored, or damaged to an address that no file has
        infos.append(info)
    return (
        np.array([info.byte_offset for info in infos], np.int64),
        np.array([info.size for info in infos], np.int64),
        np.array([info.filter_mask for info in infos], np.uint32),
    )


def _one_by_one(dataset: h5py.Dataset, found: dict[int, Any]) -> None:
    for number in range(-(-dataset.shape[0] // dataset.chunks[0])):
        if number not in found:
            try:
                found[number] = dataset.id.get_chunk_info_by_coord((number * dataset.chunks[0],))
            except (OSError, RuntimeError, ValueError):
                return
