"""A function over many items, on processes of this machine; results in order, the same for any number of processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
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
    with ProcessPoolExecutor(max(1, min(jobs, len(items))), mp_context=get_context("spawn")) as pool:
        yield from pool.map(function, items, chunksize=chunk)
