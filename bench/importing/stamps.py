"""What is wrong with time stamps: doubled, backward, irregular, or nothing recorded for a while."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError

GAP = 10.0
"""Steps of time that are longer than so many usual ones are gaps."""
_JITTER = 0.25
"""Share of a usual step by which stamps may be off an even clock and still be taken as they are."""
_WHOLE = 0.05
_SMOOTHER = 0.9
"""Share of its roughness over an even clock that a signal has left over its stamps, up to which these say when it was
sampled: by chance thousands of samples differ by a few per cent."""
_ROUGH = 0.9
"""Quantile of the differences of a signal that tells how rough it is."""
_ASKED = 100_000
"""Samples that are asked for it."""
_HOUR = 3600.0
_MANY = 0.2
_SHAKEN = 0.2
"""Share by which the mean step of a clock that shakes may be off the usual one; more is another rate for a while."""

FloatArray = NDArray[np.float64]
Location = Callable[[int], str]


def in_order(time: FloatArray) -> NDArray[np.bool_]:
    """Mark the stamps that are later than all before them."""
    return np.asarray(time > np.maximum.accumulate(np.concatenate(([-np.inf], time[:-1]))))


def why_not_in_order(time: FloatArray, location: Location) -> str | None:
    """Say in half a sentence where stamps are doubled or go backward, and what would be right; None: nowhere."""
    steps = np.diff(time)
    wrong = np.flatnonzero(~(steps > 0))
    if not wrong.size:
        return None
    index = int(wrong[0]) + 1
    doubled, backward = int(np.sum(steps == 0)), int(np.sum(steps < 0))
    step = steps[index - 1]
    what = "the same as" if step == 0 else f"{-step:g} s before"
    counts = " and ".join(f"{count} {word}" for count, word in ((doubled, "doubled"), (backward, "backward")) if count)
    right = "time should strictly increase; invalid_rows = 'drop' leaves such rows out"
    if doubled > _MANY * steps.size:
        right = "the stamps are coarser than the samples, channels.time.rate (samples per second) would be right"
    elif backward == 1 and abs(step + _HOUR) < 0.05 * _HOUR:
        right = "an hour back is the end of summer time: channels.time.timezone would be right"
    elif backward and -step > 0.5 * float(np.ptp(time)):
        right = "the clock begins anew: start and stop of two recordings should cut there"
    return f"time in {location(index)} is {what} the stamp before ({counts} stamps in all); {right}"


@dataclass(frozen=True, slots=True)
class Evenness:
    """How even a clock is: usual ``step`` in s; ``even`` (lost samples allowed), and whether it ``shakes``
    nevertheless by more than rounding; ``lost`` samples by the time between those that are there, gaps left out;
    ``gaps`` indices after a gap.
    """

    step: float
    even: bool
    shakes: bool
    lost: int
    gaps: NDArray[np.int64]
    shortest: float
    longest: float
    mean: float
    """of all steps but gaps where that is near the usual one: a clock that shakes keeps its rate"""


def evenness(time: FloatArray) -> Evenness:
    """Look at the steps of a clock that strictly increases."""
    steps = np.diff(time)
    usual = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * usual) + 1
    inside = steps[steps <= GAP * usual]
    # samples that were lost leave whole numbers of steps, which is no unevenness
    whole = np.maximum(np.round(inside / usual), 1.0)
    off = np.abs(inside / usual - whole)
    drift = np.abs(_drift(time, usual))
    shakes = bool(off.size and np.max(off) > _WHOLE)
    even = not shakes or bool(np.max(off) <= _JITTER and np.max(drift) <= _JITTER)
    mean = float(inside.mean()) if inside.size else usual
    mean = mean if abs(mean / usual - 1.0) < _SHAKEN else usual
    lost = int(np.sum(whole - 1.0))
    return Evenness(
        usual, even, shakes, lost, gaps, float(steps.min()), float(inside.max()) if inside.size else usual, mean
    )


def _drift(time: FloatArray, usual: float) -> FloatArray:
    """Deviation of each stamp from an even clock of the best rate, in usual steps."""
    index = np.arange(time.size)
    slope, start = np.polyfit(index, time - time[0], 1)
    return np.asarray((time - time[0] - start - slope * index) / usual)


def sampled_when_stamped(time: FloatArray, signals: Iterable[FloatArray]) -> bool:
    """Whether stamps that shake say when each sample was taken, and not only when it was written down: signals that
    move are smoother over them than over an even clock. By what a parabola through three samples misses of the next.
    """
    even = np.arange(time.size, dtype=np.float64)
    shares = []
    for signal in signals:
        rows = _moving(signal)
        over_even = _roughness(even[rows], signal[rows])
        if over_even > 0.0:
            shares.append(_roughness(time[rows], signal[rows]) / over_even)
    return bool(shares) and min(shares) < _SMOOTHER and max(shares) < 1.0 / _SMOOTHER


def _moving(signal: FloatArray) -> slice:
    """Where a signal moves most, of parts that are as long as is asked."""
    parts = [slice(a, a + _ASKED) for a in range(0, max(signal.size - _ASKED // 2, 1), _ASKED)]
    return max(parts, key=lambda rows: float(np.nansum(np.abs(np.diff(signal[rows])))))


def _roughness(time: FloatArray, signal: FloatArray) -> float:
    """Size of a signal's third divided differences, over what white noise of size one has: what a tenth of them exceed,
    so that neither rest nor wild samples count.
    """
    if time.size < 4:
        return 0.0
    at = np.lib.stride_tricks.sliding_window_view(time, 4)
    apart = at[:, :, None] - at[:, None, :]
    apart[:, range(4), range(4)] = 1.0
    weights = 1.0 / np.prod(apart, axis=2)
    missed = np.sum(weights * np.lib.stride_tricks.sliding_window_view(signal, 4), axis=1)
    size = np.abs(missed) / np.sqrt(np.sum(weights**2, axis=1))
    size = size[np.isfinite(size)]
    return float(np.quantile(size, _ROUGH)) if size.size else 0.0


def gap_sentence(time: FloatArray, found: Evenness, location: Location) -> str:
    """Say where the first gap is."""
    index = int(found.gaps[0])
    step = time[index] - time[index - 1]
    return (
        f"nothing stands between {time[index - 1]:.6g} and {time[index]:.6g} s ({location(index)}), "
        f"{step / found.step:.0f} times the usual step of {found.step:g} s ({found.gaps.size} such gaps)"
    )


def even_clock(time: FloatArray, step: float) -> FloatArray:
    """An even clock of this step over the time of another."""
    count = int(np.floor((time[-1] - time[0]) / step + 1e-6)) + 1
    return np.asarray(time[0] + step * np.arange(count))


def refuse_uneven(found: Evenness, where: str) -> RecordingError:
    """Refuse a clock whose steps differ, in one sentence."""
    return RecordingError(
        f"{where}: steps of time differ ({found.shortest:g} to {found.longest:g} s), they should be even; "
        "irregular = 'resample' brings the channels onto an even clock."
    )
