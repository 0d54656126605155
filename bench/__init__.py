"""The test bench: what the bench is, does, records and knows. ``from bench import connect`` is where scripts begin."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from bench.version import __version__

if TYPE_CHECKING:
    from bench.api import campaign, connect, recordings, steady

__all__ = ["__version__", "campaign", "connect", "recordings", "steady"]


def __getattr__(name: str) -> Any:
    """Load the library when it is asked for: the command line starts without it."""
    if name in __all__:
        from bench import api

        return getattr(api, name)
    raise AttributeError(f"module 'bench' has no attribute '{name}'")
