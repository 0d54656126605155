"""Identification: from recordings to the paper's model, reproduced, and a better one beside it."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bench.identification.identify import Identification, Options, identify_folder, with_proposed_orders
    from bench.identification.summary import to_json, to_simulation

__all__ = ["Identification", "Options", "identify_folder", "to_json", "to_simulation", "with_proposed_orders"]

_SUMMARY = ("to_json", "to_simulation")


def __getattr__(name: str) -> Any:
    # the mismatch analysis shares single modules of this package: it does not wait for all that identification imports
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("bench.identification." + ("summary" if name in _SUMMARY else "identify")), name)
