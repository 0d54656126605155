"""Memory that was freed, given back to the operating system.

Reading leaves small arrays that stay between large ones that are gone. The C library keeps those pages for the next
allocation, but what comes next, a bank of regressors, is larger than any of the holes.
"""

from __future__ import annotations

import ctypes
import sys


def give_back() -> None:
    """Return freed pages, where the C library knows how (glibc's malloc_trim); elsewhere nothing is done."""
    if sys.platform.startswith("linux"):
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)
