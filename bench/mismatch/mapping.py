"""A function over many items: here, on processes of this machine, or on a Dask cluster; the results are the same."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

from bench import processes
from bench.errors import ConfigurationError

T = TypeVar("T")
R = TypeVar("R")


def over(function: Callable[[T], R], items: Sequence[T], jobs: int = 1, dask: str | None = None) -> Iterator[R]:
    """Map a function over items on processes of this machine, or on the cluster at ``dask``; results in order."""
    if dask is not None:
        yield from _on_dask(function, items, dask)
    else:
        yield from processes.over(function, items, jobs)


def _on_dask(function: Callable[[T], R], items: Sequence[T], address: str) -> Iterator[R]:
    try:
        import distributed
    except ImportError as error:
        raise ConfigurationError(
            "--dask needs the package distributed: install the optional dependencies 'dask'."
        ) from error
    client: Any
    try:
        client = distributed.Client(address)
    except (OSError, ValueError) as error:
        raise ConfigurationError(f"there is no Dask scheduler at {address}: {error}") from error
    with client:
        yield from client.gather([client.submit(function, item, pure=False) for item in items])
