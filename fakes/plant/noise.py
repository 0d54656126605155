"""A seeded compiled generator of normal numbers whose whole state is four words, so that a snapshot can hold it.

xoshiro256+ (Blackman and Vigna, 2018) for the bits, the ziggurat with 128 layers (Marsaglia and Tsang, 2000) for the
normal distribution.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

_LAYERS = 128
_EDGE = 3.442619855899
"""start of the tail: the abscissa r of the 128-layer ziggurat"""
_AREA = 9.91256303526217e-3
"""area of each layer under exp(-x²/2)"""
_UNIT = 1.0 / 9007199254740992.0  # 2^-53


def _layers() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the abscissae x (129,) of the layers, descending, and the density exp(-x²/2) at each."""
    x = np.empty(_LAYERS + 1)
    x[0] = _AREA / math.exp(-0.5 * _EDGE * _EDGE)
    x[1] = _EDGE
    for i in range(2, _LAYERS):
        x[i] = math.sqrt(-2.0 * math.log(_AREA / x[i - 1] + math.exp(-0.5 * x[i - 1] ** 2)))
    x[_LAYERS] = 0.0
    return x, np.exp(-0.5 * x * x)


_X, _DENSITY = _layers()


def seed_words(seed: int) -> NDArray[np.uint64]:
    """Return the generator's first state, (4,) words, from any integer seed of 0 or more."""
    return np.random.SeedSequence(seed).generate_state(4, np.uint64).astype(np.uint64)


@njit(cache=True, error_model="numpy")
def _next(words: NDArray[np.uint64]) -> Any:
    """Advance the generator, 64 new bits."""
    result = words[0] + words[3]
    shifted = words[1] << np.uint64(17)
    words[2] ^= words[0]
    words[3] ^= words[1]
    words[1] ^= words[2]
    words[0] ^= words[3]
    words[2] ^= shifted
    words[3] = (words[3] << np.uint64(45)) | (words[3] >> np.uint64(19))
    return result


@njit(cache=True, error_model="numpy")
def _uniform(words: NDArray[np.uint64]) -> float:
    """Return a uniform number in (0, 1)."""
    return (float(_next(words) >> np.uint64(11)) + 0.5) * _UNIT


@njit(cache=True, error_model="numpy")
def _tail_magnitude(words: NDArray[np.uint64]) -> float:
    """Return the magnitude of a normal number in the tail beyond the last layer (Marsaglia's method)."""
    while True:
        x = -math.log(_uniform(words)) / _EDGE
        y = -math.log(_uniform(words))
        if y + y > x * x:
            return _EDGE + x


@njit(cache=True, error_model="numpy")
def normal(words: NDArray[np.uint64]) -> float:
    """Return a standard normal number and advance ``words`` (4,)."""
    while True:
        bits = _next(words)
        # the lowest bits of xoshiro256+ are its weakest: layer and sign from the middle, magnitude from the top
        layer = int((bits >> np.uint64(3)) & np.uint64(_LAYERS - 1))
        x = float(bits >> np.uint64(11)) * _UNIT * _X[layer]
        negative = (bits >> np.uint64(10)) & np.uint64(1)
        if x >= _X[layer + 1]:
            if layer == 0:
                x = _tail_magnitude(words)
            else:
                height = _DENSITY[layer] + _uniform(words) * (_DENSITY[layer + 1] - _DENSITY[layer])
                if height >= math.exp(-0.5 * x * x):
                    continue
        return float(-x if negative else x)
