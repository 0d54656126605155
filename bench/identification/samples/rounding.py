"""A torque that was rounded twice: inside the drive, and again to the units of the bus.

Noise smooths one rounding. It does not smooth the second one of values that already stand on a grid of their own: some
codes of the bus take in more steps of the drive than others, and the mean of what is reported is off by up to half a
step of the drive, by an amount that depends on the level and is the same in every recording of that level. Seven parts
in a thousand of an inertia come of it, where all ramps run at the same torque.

The drive's own step shows in how often each code occurs: n steps to a code make it n times as frequent as its
neighbourhood. It is searched in one half of the recordings and has to hold in the other half; then the codes of both
tell it. An error of the step is one of all torques in proportion, the same in every recording, and the more codes there
are the smaller it is: with those of 12 recordings 2e-5, with those of 54 below 1e-6.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.recording import ChannelSpec, Recording

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

FINEST, COARSEST = 0.15, 0.9
"""Steps looked for, in codes: finer ones make all codes alike, coarser ones leave most codes empty."""
LOOKED_AT = 60
"""Recordings whose codes are counted, spread over all there are."""
LOOKED_AT_CLOSELY = 20
"""Steps of the coarse search that are refined before the best is taken."""
MIN_COUNT = 200
"""A code counts that occurs this often, and whose two neighbours do."""
MIN_CODES = 30
SEARCHED = 100
"""Neighbouring codes, those that occur most often, with which the whole range of steps is searched."""
CURVATURE = 0.03
"""Standard deviation of what the distribution's own bend does to a code's logarithm, beside counting statistics."""
MIN_EXPLAINED = 0.5
"""Share of the pattern's square that the step has to explain in the half it was not searched in."""
_PIECE = 4_000_000


@dataclass(frozen=True, slots=True)
class _Pattern:
    """Logarithm of each code's frequency less that of its neighbours' mean: codes (n,), values (n,), weights (n,)."""

    code: IntArray
    value: FloatArray
    weight: FloatArray


def _pattern(counts: Mapping[int, int]) -> _Pattern:
    codes = np.asarray(
        sorted(c for c in counts if min(counts.get(c + i, 0) for i in (-1, 0, 1)) >= MIN_COUNT), dtype=np.int64
    )
    number = np.asarray([[counts[int(c) + i] for i in (-1, 0, 1)] for c in codes], dtype=np.float64).reshape(-1, 3)
    value = np.log(number) @ np.array([-0.5, 1.0, -0.5])
    variance = (1.0 / number) @ np.array([0.25, 1.0, 0.25]) + CURVATURE**2
    return _Pattern(codes, value, 1.0 / variance)


def _expected(code: IntArray, step: FloatArray) -> FloatArray:
    """What steps (m,) of a drive, in codes, do to the logarithms of codes (n,): shape (m, n)."""
    edges = np.floor((code[:, None] + np.array([-1.5, -0.5, 0.5, 1.5])) / step[:, None, None])
    return np.asarray(np.log(np.maximum(np.diff(edges, axis=-1), 0.5)) @ np.array([-0.5, 1.0, -0.5]))


def _explained(pattern: _Pattern, step: FloatArray) -> FloatArray:
    """Share (m,) of the pattern's weighted square that each step takes away; its size is known: nothing is scaled."""
    left = ((pattern.value - _expected(pattern.code, step)) ** 2) @ pattern.weight
    return np.asarray(1.0 - left / max(float(pattern.weight @ pattern.value**2), 1e-300))


def _search(pattern: _Pattern) -> float:
    """Step that explains the pattern best, in codes."""
    # neighbours: of every n-th code alone, steps whose patterns differ by 1/n of a code look alike
    weight = np.convolve(pattern.weight, np.ones(min(SEARCHED, pattern.code.size)), mode="valid")
    first = int(np.argmax(weight))
    some = slice(first, first + SEARCHED)
    all_codes, pattern = pattern, _Pattern(pattern.code[some], pattern.value[some], pattern.weight[some])
    furthest = float(np.abs(pattern.code).max()) + 1.0
    # grid so fine that the furthest code's own step moves by a tenth of itself only
    inverse = np.arange(1.0 / COARSEST, 1.0 / FINEST, 0.1 / furthest)
    size = max(_PIECE // max(pattern.code.size, 1), 1)
    parts = [inverse[i : i + size] for i in range(0, inverse.size, size)]
    score = np.concatenate([_explained(pattern, 1.0 / part) for part in parts])
    # a pattern of many codes is narrower than the grid: the best few are looked at closely
    near = [_refined(pattern, float(1.0 / inverse[k])) for k in np.argsort(-score)[:LOOKED_AT_CLOSELY]]
    best, _ = max(near, key=lambda found: found[1])
    return _refined(all_codes, best)[0]


def _refined(pattern: _Pattern, step: float) -> tuple[float, float]:
    """Step near ``step`` that explains the pattern best, in codes, and the share that it explains."""
    furthest = float(np.abs(pattern.code).max()) + 1.0
    near = 1.0 / step + np.linspace(-0.2, 0.2, 401) / furthest
    score = _explained(pattern, 1.0 / near)
    # within the counting of codes many steps do the same: their middle
    return float(1.0 / near[score >= score.max() - 1e-9].mean()), float(score.max())


def _counts(recordings: Sequence[Recording], channel: str) -> Counter[int]:
    """How often each code occurs."""
    out: Counter[int] = Counter()
    for recording in recordings:
        codes, number = np.unique_counts(recording.raw(channel))
        out.update(dict(zip(codes.tolist(), number.tolist(), strict=True)))
    return out


def find_step(recordings: Sequence[Recording], channel: str = "motor_torque") -> float | None:
    """Step of the drive behind a channel's codes, in the channel's unit; None where none shows.

    Looks at up to 60 recordings in motion, searches in every other one and verifies in the others. Channels that are
    not whole numbers in the file have none.
    """
    usable = [
        r
        for r in recordings
        if r.setpoint.velocity != 0.0
        and channel in r.specs
        and np.issubdtype(np.dtype(r.specs[channel].dtype), np.integer)
    ]
    usable = [r for r in usable if r.specs[channel].scale == usable[0].specs[channel].scale]
    usable.sort(key=lambda r: (r.setpoint.load_torque, r.setpoint.velocity))
    if len(usable) > LOOKED_AT:
        usable = [usable[i] for i in np.linspace(0, len(usable) - 1, LOOKED_AT).astype(int)]
    halves = [_counts(usable[i::2], channel) for i in (0, 1)]
    search, verify = (_pattern(half) for half in halves)
    if min(search.code.size, verify.code.size) < MIN_CODES:
        return None
    step = _search(search)
    if _explained(verify, np.array([step]))[0] < MIN_EXPLAINED:
        return None
    return _refined(_pattern(halves[0] + halves[1]), step)[0] * abs(usable[0].specs[channel].scale)


def rounded_twice(spec: ChannelSpec | None, step: float) -> bool:
    """Whether a channel of whole numbers is coarser than the drive's ``step``, in its unit, as far as that is seen."""
    if spec is None or not np.issubdtype(np.dtype(spec.dtype), np.integer):
        return False
    return FINEST <= step / abs(spec.scale) <= COARSEST


def with_single_rounding(codes: NDArray[np.integer], spec: ChannelSpec, step: float) -> FloatArray:
    """Values (n,) of ``codes`` (n,) in the channel's unit, as if the drive's ``step`` were the only rounding.

    Each code is read as the mean of the drive's steps that it takes in; one that takes in none as it is.
    """
    share = step / abs(spec.scale)
    whole = codes.astype(np.int64)
    low, high = int(whole.min(initial=0)), int(whole.max(initial=0))
    # a table where codes come often; a wild one may lie anywhere in 32 bits
    in_table = high - low <= whole.size
    every = np.arange(low, high + 1) if in_table else whole
    first, after = np.ceil((every - 0.5) / share), np.ceil((every + 0.5) / share)
    mean = np.where(after > first, 0.5 * (first + after - 1.0) * share, every) * spec.scale + spec.offset
    return np.asarray(mean[whole - low] if in_table else mean)
