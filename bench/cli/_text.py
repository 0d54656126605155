"""Durations, energies and counts as people read them."""

from __future__ import annotations


def duration_text(seconds: float) -> str:
    """Return seconds as ``42 s``, ``3 min 20 s`` or ``7 h 05 min``."""
    total = round(seconds)
    if total < 60:
        return f"{total} s"
    if total < 3600:
        return f"{total // 60} min {total % 60:02d} s"
    return f"{total // 3600} h {total % 3600 // 60:02d} min"


def clock_text(seconds: float) -> str:
    """Return seconds as ``0:01:20``, for tables."""
    total = round(seconds)
    return f"{total // 3600}:{total % 3600 // 60:02d}:{total % 60:02d}"


def energy_text(joule: float) -> str:
    """Return an energy in kJ or kWh."""
    return f"{joule / 1e3:.0f} kJ" if joule < 3.6e6 else f"{joule / 3.6e6:.2f} kWh"


def count_text(count: int, what: str) -> str:
    """Return ``1 recording``, ``4 recordings``."""
    return f"{count:,} {what}" if count == 1 else f"{count:,} {what}s"
