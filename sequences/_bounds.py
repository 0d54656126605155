"""Bounds of options: what lies outside is refused before anything is made of it, in one sentence."""

from __future__ import annotations

LONGEST_S = 48.0 * 3600.0
"""Of any one time an option gives."""


def require(name: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Raise ValueError where an option (SI) lies outside its bounds or is no number."""
    if not low <= value <= high:
        unit = f" {unit}" if unit else ""
        raise ValueError(f"{name} is {value:g}{unit}, it must lie between {low:g} and {high:g}{unit}")


def require_whole(name: str, value: int, low: int, high: int) -> None:
    """Raise ValueError where an option is no whole number within its bounds."""
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        raise ValueError(f"{name} is {value}, it must be a whole number from {low} to {high}")
