"""A linear axis in its own words: metres and newtons where a shaft has radians and newton metres.

Inside, both are numbers; a recording's header says which they are. Texts and units are put into the axis' own on the
way out, in one place.
"""

from __future__ import annotations

import re
from typing import Any

_WORDS: tuple[tuple[re.Pattern[str], str], ...] = (
    (re.compile(r"\bN[*·]m\b"), "N"),
    (re.compile(r"\bkg[*·]m(?:\^2|²)"), "kg"),
    (re.compile(r"\b(?<!_)rad\b"), "m"),
    (re.compile(r"\boutput angle\b"), "position"),
    (re.compile(r"\bper output revolution\b"), "per 2π m"),
    (re.compile(r"\bat the motor shaft\b"), "at the motor"),
    (re.compile(r"\bf\(angle="), "f(position="),
)


def in_metres(text: str) -> str:
    """A text about a shaft as one about a linear axis."""
    for pattern, word in _WORDS:
        text = pattern.sub(word, text)
    return text


def all_in_metres(value: Any, kept: frozenset[str] = frozenset(("file", "recordings", "effect", "channel"))) -> Any:
    """The same of every text in nested lists and mappings, but for the values of the keys ``kept``."""
    if isinstance(value, str):
        return in_metres(value)
    if isinstance(value, list):
        return [all_in_metres(own, kept) for own in value]
    if isinstance(value, dict):
        return {key: own if key in kept else all_in_metres(own, kept) for key, own in value.items()}
    return value
