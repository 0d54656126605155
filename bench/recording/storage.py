"""What of a dataset is really stored: HDF5 reads chunks that were never written as zeros, without a word."""

from __future__ import annotations

import h5py


def first_missing_row(dataset: h5py.Dataset) -> int | None:
    """Give the first row whose chunk was never stored; None where all are there or the dataset is not chunked."""
    if dataset.chunks is None or not dataset.shape[0]:
        return None
    (rows,) = dataset.chunks
    stored = {info.chunk_offset[0] for info in _chunks(dataset)}
    expected = range(0, dataset.shape[0], rows)
    if len(stored) >= len(expected):
        return None
    return next((start for start in expected if start not in stored), None)


def _chunks(dataset: h5py.Dataset) -> list[h5py.h5d.StoreInfo]:
    found: list[h5py.h5d.StoreInfo] = []
    dataset.id.chunk_iter(found.append)
    return found
