"""Quantities composed of others: ``aux/cos(angle + elbow)``, ``aux/rate(pressure)``, ``aux/product(current, voltage)``.

What a logger recorded beside the bench need not act as it stands. Gravity and inertia of a chain of joints act by sines
and cosines of sums of angles, and an inertia that changes acts by its momentum; leaks and springs act by sign, size or
rate. Such a function stands in a file by its name, which says what it is made of; ``angle`` is the output's own.

Rates are smoothed as those of the bench's own channels are: a frame made of a recording holds them by their names,
``rate(pressure)`` and ``acceleration(elbow)``.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence

import numpy as np

from bench.errors import ConfigurationError
from bench.simulation.frame import FloatArray, Frame, recording_starts

OUTPUT_ANGLE = "angle"
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
    if found[1] == "momentum":
        return parts_of(found[2])
    if found[1] == "carried":
        wave, by = found[2].rsplit(", ", 1)
        return tuple(dict.fromkeys((*parts_of(wave), by)))
    parts = found[2].split(", ") if found[1] == "product" else _SIGNS.split(found[2])[::2]
    return tuple(dict.fromkeys(part for part in parts if part != OUTPUT_ANGLE))


def summed(parts: Sequence[str], signs: Sequence[int]) -> str:
    """Text of a sum of angles; the first sign is taken for plus."""
    rest = (f" {'+' if sign > 0 else '-'} {part}" for part, sign in zip(parts[1:], signs[1:], strict=True))
    return parts[0] + "".join(rest)


def _value(part: str, frame: Frame) -> FloatArray:
    if part == OUTPUT_ANGLE:
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
    """Rate of change a second: as the frame holds it, else from row to row along each recording."""
    rate = rate_of(text)
    return frame.aux[rate] if rate in frame.aux else _along(_value(text, frame), frame)


def _acceleration(text: str, frame: Frame) -> FloatArray:
    """Second rate of change, by the same rule."""
    acceleration = acceleration_of(text)
    return frame.aux[acceleration] if acceleration in frame.aux else _along(_rate(text, frame), frame)


def rate_of(name: str) -> str:
    """Name under which a frame holds an auxiliary quantity's rate."""
    return f"rate({name})"


def acceleration_of(name: str) -> str:
    """Name under which a frame holds an auxiliary quantity's second rate."""
    return f"acceleration({name})"


def _along(values: FloatArray, frame: Frame) -> FloatArray:
    out = np.zeros(frame.size)
    starts = recording_starts(frame)
    for a, b in itertools.pairwise(starts):
        if b - a > 1:
            step = np.gradient(frame.elapsed[a:b])
            out[a:b] = np.gradient(values[a:b]) / np.where(step > 0.0, step, np.inf)
    return out


def _momentum(text: str, frame: Frame) -> FloatArray:
    """Torque of an inertia c*cos(s) or c*sin(s) that changes with a sum s of angles, for c = 1 kg·m² at the motor.

    By Lagrange's equation d(J*w)/dt - w*w*u*(dJ/dq)/2: of its own angle's part of the change half is felt.
    """
    found = _wave(text, "momentum(cos(angle + q2))")
    angle, changing = _sum(found[2], frame), np.zeros(frame.size)
    first, *rest = _SIGNS.split(found[2])
    for sign, part in zip(("+", *rest[::2]), (first, *rest[1::2]), strict=True):
        momentum_rate = 0.5 * frame.velocity if part == OUTPUT_ANGLE else _rate(part, frame)
        changing = changing + momentum_rate if sign == "+" else changing - momentum_rate
    value, slope = (np.cos(angle), -np.sin(angle)) if found[1] == "cos" else (np.sin(angle), np.cos(angle))
    return np.asarray(frame.acceleration * value + frame.omega * changing * slope)


def _carried(text: str, frame: Frame) -> FloatArray:
    """Torque on a body that another joint carries about, for 1 kg·m²: of ``cos(s), q2`` the inertia of the body on an
    arm that turns by q2, at an angle s to it (a double pendulum's coupling, with its centrifugal part).
    """
    wave, _, by = text.rpartition(", ")
    found = _wave(wave, "carried(cos(angle), q2)")
    angle, speed, acceleration = _sum(found[2], frame), _rate(by, frame), _acceleration(by, frame)
    if found[1] == "cos":
        return np.asarray(np.cos(angle) * acceleration + np.sin(angle) * speed * speed)
    return np.asarray(np.sin(angle) * acceleration - np.cos(angle) * speed * speed)


def _wave(text: str, such: str) -> re.Match[str]:
    found = _NAME.fullmatch(text)
    if found is None or found[1] not in ("cos", "sin"):
        raise ConfigurationError(f"'{text}' should be a sine or cosine, as in {such}")
    return found


def _product(text: str, frame: Frame) -> FloatArray:
    first, second = text.split(", ")
    return _value(first, frame) * _value(second, frame)


FUNCTIONS: dict[str, Callable[[str, Frame], FloatArray]] = {
    "cos": lambda text, frame: np.cos(_sum(text, frame)),
    "sin": lambda text, frame: np.sin(_sum(text, frame)),
    "sign": lambda text, frame: np.sign(_value(text, frame)),
    "abs": lambda text, frame: np.abs(_value(text, frame)),
    "rate": _rate,
    "acceleration": _acceleration,
    "momentum": _momentum,
    "carried": _carried,
    "product": _product,
}
"""function -> its values from the text between its brackets"""
