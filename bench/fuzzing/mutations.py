"""Spoiling bytes: flipped, zeroed, cut, inserted."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Spoil = Callable[[bytearray, np.random.Generator], None]

_MOST_PLACES = 8
_LONGEST = 64
_FRONT = 8192
"""Headers stand in front: half of what is spoiled is spoiled there, for samples are most of a recording."""


def mutate(data: bytes, rng: np.random.Generator) -> bytes:
    """Spoil a file in one way, at one place or (every other time) up to eight; it is never what it was."""
    spoil = MUTATIONS[int(rng.integers(len(MUTATIONS)))]
    places = 1 if spoil is cut or rng.random() < 0.5 else int(rng.integers(2, _MOST_PLACES + 1))
    changed = bytearray(data)
    while bytes(changed) == data:
        for _ in range(places):
            spoil(changed, rng)
        spoil = flip  # what was zero already: another way
    return bytes(changed)


def _position(data: bytearray, rng: np.random.Generator) -> int:
    end = len(data) if rng.random() < 0.5 else min(len(data), _FRONT)
    return int(rng.integers(max(end, 1)))


def flip(data: bytearray, rng: np.random.Generator) -> None:
    """Flip one bit."""
    if data:
        data[_position(data, rng)] ^= 1 << int(rng.integers(8))


def zero(data: bytearray, rng: np.random.Generator) -> None:
    """Overwrite up to 64 bytes with zeros."""
    at, length = _position(data, rng), int(rng.integers(1, _LONGEST + 1))
    end = min(at + length, len(data))
    data[at:end] = bytes(end - at)


def cut(data: bytearray, rng: np.random.Generator) -> None:
    """Take away the end, or up to 64 bytes from the middle."""
    at = _position(data, rng)
    end = len(data) if rng.random() < 0.5 else min(at + int(rng.integers(1, _LONGEST + 1)), len(data))
    del data[at:end]


def insert(data: bytearray, rng: np.random.Generator) -> None:
    """Insert up to 64 random bytes."""
    data[(at := _position(data, rng)) : at] = rng.bytes(int(rng.integers(1, _LONGEST + 1)))


MUTATIONS: tuple[Spoil, ...] = (flip, zero, cut, insert)
