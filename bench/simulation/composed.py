"""Quantities composed of others: ``aux/cos(angle + elbow)``, ``aux/rate(pressure)``, ``aux/product(current, voltage)``.

What a logger recorded beside the bench need not act as it stands. Gravity and inertia of a chain of joints act by sines
and cosines of sums of angles; leaks and springs by sign, size or rate. Such a function stands in a file by its name,
which says what it is made of; ``angle`` is the output's own.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence

import numpy as np

from bench.errors import ConfigurationError
from bench.simulation.frame import FloatArray, Frame, recording_starts

OWN_ANGLE = "angle"
_NAME = re.compile(r"(\w+)\((.+)\)")
_SIGNS = re.compile(r" ([+-]) ")


def composed(name: str, frame: Frame) -> FloatArray | None:
    """Values (n,) of a composed quantity; None where the name is of no composed one.

    Raises ConfigurationError where it is made of something that the recordings do not have.
    """
    found = _NAME.fullmatch(name)
    if found is None or found[1] not in FUNCTIONS:
        return None
    return FUNCTIONS[found[1]](found[2], frame)


def parts_of(name: str) -> tuple[str, ...]:
    """Names of the auxiliary quantities that a quantity is made of: its own, where it is not composed."""
    found = _NAME.fullmatch(name)
    if found is None or found[1] not in FUNCTIONS:
        return (name,)
    parts = found[2].split(", ") if found[1] == "product" else _SIGNS.split(found[2])[::2]
    return tuple(dict.fromkeys(part for part in parts if part != OWN_ANGLE))


def summed(parts: Sequence[str], signs: Sequence[int]) -> str:
    """Text of a sum of angles; the first sign is taken for plus."""
    rest = (f" {'+' if sign > 0 else '-'} {part}" for part, sign in zip(parts[1:], signs[1:], strict=True))
    return parts[0] + "".join(rest)


def _value(part: str, frame: Frame) -> FloatArray:
    if part == OWN_ANGLE:
        return frame.q
    if part not in frame.aux:
        raise ConfigurationError(f"the recordings have no quantity 'aux/{part}', which the simulation depends on")
    return frame.aux[part]


def _sum(text: str, frame: Frame) -> FloatArray:
    first, *rest = _SIGNS.split(text)
    out = _value(first, frame)
    for sign, part in zip(rest[::2], rest[1::2], strict=True):
        out = out + _value(part, frame) if sign == "+" else out - _value(part, frame)
    return out


def _rate(text: str, frame: Frame) -> FloatArray:
    """Rate of change a second, along each recording."""
    values = _value(text, frame)
    out = np.zeros(frame.size)
    starts = recording_starts(frame)
    for a, b in itertools.pairwise(starts):
        if b - a > 1:
            step = np.gradient(frame.elapsed[a:b])
            out[a:b] = np.gradient(values[a:b]) / np.where(step > 0.0, step, np.inf)
    return out


def _product(text: str, frame: Frame) -> FloatArray:
    first, second = text.split(", ")
    return _value(first, frame) * _value(second, frame)


FUNCTIONS: dict[str, Callable[[str, Frame], FloatArray]] = {
    "cos": lambda text, frame: np.cos(_sum(text, frame)),
    "sin": lambda text, frame: np.sin(_sum(text, frame)),
    "sign": lambda text, frame: np.sign(_value(text, frame)),
    "abs": lambda text, frame: np.abs(_value(text, frame)),
    "rate": _rate,
    "product": _product,
}
"""function -> its values from the text between its brackets"""
