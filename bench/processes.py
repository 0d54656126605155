"""A function over many items, on processes of this machine; results in order, the same for any number of processes."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context, parent_process
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")


def over(function: Callable[[T], R], items: Sequence[T], jobs: int = 1, chunk: int = 1) -> Iterator[R]:
    """Map a function over items in ``jobs`` processes, ``chunk`` items at a time; with one job in this process.

    Processes are begun afresh: neither HDF5 nor threads of a transform survive a fork in good order.
    """
    if jobs <= 1:
        yield from map(function, items)
        return
    with workers(min(jobs, len(items))) as pool:
        yield from pool.map(function, items, chunksize=chunk)


def workers(number: int) -> ProcessPoolExecutor:
    """A pool of ``number`` processes (one at least) that end with the one that began them, however that ends."""
    return ProcessPoolExecutor(max(1, number), mp_context=get_context("spawn"), initializer=_end_with_parent)


def _end_with_parent() -> None:
    """End this process when its parent does: a worker whose parent was killed would wait for work for ever."""
    parent = parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, name="end with parent", daemon=True).start()
