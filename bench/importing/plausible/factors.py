"""Factors by which channels are wrong when a unit, a side or a sign is."""

from __future__ import annotations

import math

CLOSE = 0.04
"""how near a factor is to a known one that is taken for it (relative)"""
_FACTORS: tuple[tuple[float, str], ...] = (
    (math.degrees(1.0), "degrees taken for radians, or the other way round"),
    (30 / math.pi, "rpm taken for rad/s, or the other way round"),
    (6.0, "rpm taken for degrees per second, or the other way round"),
    (60.0, "minutes taken for seconds, or the other way round"),
    (2 * math.pi, "revolutions taken for radians, or the other way round"),
    (1000.0, "a thousand too much or too little (milli, kilo)"),
    (100.0, "a hundred too much or too little (centi)"),
    (10.0, "ten times too much or too little"),
)


def named(found: float, ratio: float = 1.0) -> list[tuple[float, str]]:
    """Known factors that ``found`` is, whatever its sign, each with what is mistaken where it comes up."""
    known = [*_FACTORS, (abs(ratio), "the other side of the gearbox")] if abs(ratio) > 1.1 else list(_FACTORS)
    return [(f, text) for factor, text in known for f in (factor, 1.0 / factor) if abs(abs(found) / f - 1.0) < CLOSE]


def reason(found: float, ratio: float = 1.0) -> str:
    """Say why a factor that should be 1 may be ``found``, and which scale would be right (half a sentence)."""
    size, words, right = abs(found), [], 1.0 / found
    if abs(size - 1.0) > CLOSE:
        fits = named(found, ratio)
        words += [text for _, text in fits[:1]]
        right = math.copysign(1.0 / fits[0][0], found) if fits else right
    else:
        right = math.copysign(1.0, found)
    if found < 0:
        words.append("a wrong sign")
    likely = " and ".join(words) or "a wrong scale"
    return f"likely {likely}; scale times {right:.4g} would be right"
