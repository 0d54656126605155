"""Cutting recordings: every sample is in exactly one piece, and there are enough pieces where that is possible."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
LEAST_REVOLUTIONS = 2.0
"""A piece of fewer says nothing of what comes once a revolution."""
LEAST_SAMPLES = 50
_STEPS_PER_SECOND = 20.0
_LAST = 0.1
"""Share of a piece that may be missing of the last one."""


@dataclass(frozen=True, slots=True)
class Cut:
    """Pieces of the samples 0 to N, one after another; ``note`` says where they are not what was asked for."""

    pieces: tuple[slice, ...]
    note: str = ""


def travelled(angle: FloatArray, time: FloatArray) -> FloatArray:
    """Angle run through (N,), never falling: twenty steps a second, so that an encoder's noise adds up to little."""
    if angle.size < 2:
        return np.zeros(angle.size)
    count = max(2, min(angle.size, int((time[-1] - time[0]) * _STEPS_PER_SECOND) + 1))
    knots = np.unique(np.linspace(0, angle.size - 1, count).astype(np.int64))
    run = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(angle[knots])))))
    return np.asarray(np.interp(np.arange(angle.size), knots, run))


def cut(progress: FloatArray, length: float, at_least: int, least: float, unit: str) -> Cut:
    """Cut N samples into pieces over which ``progress`` grows by ``length``.

    Parameters
    ----------
    progress : (N,) never falling, from 0: revolutions run through, or seconds.
    at_least : pieces that should come of it; where there would be fewer they are made shorter.
    least : shortest length that a piece may get by that.
    unit : of the length, for the note.

    What is left at the end joins the last piece where it is less than half of one.
    """
    size = progress.size
    total = float(progress[-1]) if size else 0.0
    piece_length = length
    if total < (at_least - _LAST) * length:
        shorter = total / at_least
        whole = math.floor(shorter) if shorter >= 1.0 and unit == "revolutions" else shorter
        piece_length = min(length, max(whole, least))
    count = max(1, math.floor(total / piece_length + 1e-9)) if piece_length > 0 else 1
    rest = total - count * piece_length
    if rest >= 0.5 * piece_length and count * piece_length < total:
        count += 1
    bounds = [0, *(int(np.searchsorted(progress, piece_length * k, side="left")) for k in range(1, count)), size]
    kept = [0]
    for bound in bounds[1:-1]:
        if bound - kept[-1] >= LEAST_SAMPLES and size - bound >= LEAST_SAMPLES:
            kept.append(bound)
    kept.append(size)
    pieces = tuple(slice(a, b) for a, b in itertools.pairwise(kept))
    return Cut(pieces, _note(len(pieces), piece_length, length, at_least, total, unit))


def _note(count: int, piece_length: float, length: float, at_least: int, total: float, unit: str) -> str:
    if piece_length < length * (1.0 - 1e-9):
        first = (
            f"cut into pieces of {piece_length:.4g} {unit} and not of {length:g} {unit}, because pieces.at_least wants "
            f"{at_least} pieces of these {total:.4g} {unit}"
        )
        return first if count >= at_least else f"{first}; there are {count} even so"
    if count < at_least:
        return f"{total:.4g} {unit} make {count} piece{'s' * (count != 1)}, fewer than the {at_least} asked for"
    return ""


def at(bounds: list[int], size: int) -> list[slice]:
    """Stretches between the indices given, of samples 0 to ``size``."""
    edges = [0, *bounds, size]
    return [slice(a, b) for a, b in itertools.pairwise(edges)]
