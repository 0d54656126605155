"""Ring-down: a play that the load torque crosses is flung over, and what is free in it rings and fades.

A torque's rows are as long as a second, so they do not show it. What the model leaves is looked at in short steps from
each moment in motion at which the load torque passes zero (:mod:`bench.mismatch.unnamed.crossings`). Beside a
parabola and what settles a decaying oscillation is fitted to each such window: frequency and decay are common to all,
size and phase each window's own. How much more it explains than a step or a knee at the best place is compared with
windows that follow no such moment, those after starts and reversals with those after starts and reversals: a control
loop rings in both. An order or a tone rings in all windows of a recording, so what quiet windows of the recording show
at the same frequency is taken off.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from bench.mismatch import criteria
from bench.mismatch.regression.maxima import tail_probability
from bench.mismatch.unnamed.crossings import FINE_S, Finely, Window, windows
from bench.simulation.frame import FloatArray, Frame

SLOWEST_HZ, FASTEST_HZ, RATIO = 1.5, 12.5, 1.06
"""frequencies: three periods in a window, four steps in a period; from one to the next"""
DECAYS_S = (0.1, 0.2, 0.4, 0.8, 1.6)
"""from a tenth to most of a window"""
LONGEST_S, INSIDE = 3.2, 0.99
"""decay that a window tells at most; share of it below which it was told"""
SETTLES_S = (0.1, 0.4)
"""time constants with which what is no oscillation settles after a load or a speed has changed"""
FEWEST_PERIODS = 0.5
"""within which it fades to 1/e: what fades sooner swings back by less than a third, and is told from nothing that
settles
"""
FEWEST = 4
"""crossings, and windows of each kind, below which nobody can say that they are alike"""
SURROGATES = 199
MOST_GROUPS = 10
"""that are left out one after another to tell how sure frequency and decay are"""
EVERY = 5
"""steps of time between places of a step or a knee that are tried"""
FIRST_STEP = 0.05
"""of the logarithms of frequency and decay"""


@dataclass(frozen=True, slots=True)
class Ringing:
    """What rings after crossings: frequency (Hz), decay (s; the standard deviation None where it is longer than the
    windows tell) and size with their standard deviations; ``rings``: recording, times since its begin (k,) and mean
    squares (k,) of what rings after each crossing.
    """

    frequency: tuple[float, float]
    decay: tuple[float, float | None]
    size: tuple[float, float]
    rings: tuple[tuple[int, FloatArray, FloatArray], ...]

    def on_rows(self, frame: Frame) -> FloatArray:
        """Root mean square of what rings in each row (n,) of a frame, over the time that the row takes."""
        out = np.zeros(frame.size)
        for recording, times, squares in self.rings:
            at = np.flatnonzero(frame.recording == recording)
            if at.size < 2:
                continue
            middle = 0.5 * (frame.elapsed[at][1:] + frame.elapsed[at][:-1])
            lasts = np.diff(middle, prepend=2.0 * frame.elapsed[at[0]] - middle[0])
            lasts = np.append(lasts, 2.0 * (frame.elapsed[at[-1]] - middle[-1]))
            inside = (times > frame.elapsed[at[0]] - lasts[0]) & (times < frame.elapsed[at[-1]] + lasts[-1])
            row = np.searchsorted(middle, times[inside])
            out[at] += FINE_S * np.bincount(row, squares[inside], at.size) / np.maximum(lasts, FINE_S)
        return np.sqrt(out)


@dataclass(frozen=True, slots=True)
class RingDown:
    """The chance that noise rings as much after crossings; what rings, where that is rare."""

    p_value: float
    ringing: Ringing | None = None


@dataclass(frozen=True, slots=True)
class _Compared:
    """Windows after crossings that decide, those that they are compared with, and the gain of each beyond what quiet
    windows of its recording have (windows, frequencies, decays), a step.
    """

    events: list[Window]
    others: list[Window]
    of_events: FloatArray
    of_others: FloatArray

    def alike(self, event: Window) -> list[int]:
        """Numbers of the windows that an event is compared with: of its kind and recording, or of its kind where its
        recording has too few.
        """
        kind = [k for k, w in enumerate(self.others) if w.lively == event.lively]
        own = [k for k in kind if self.others[k].recording == event.recording]
        return own if len(own) >= FEWEST else kind


def ring_down(recordings: Iterable[Finely], sure: float, fitted: Sequence[bool]) -> RingDown | None:
    """Ringing after a load torque of more than ``sure`` N·m has changed its side in some ``recordings``, of which some
    are ``fitted``: these decide. None where it cannot be told.
    """
    events: list[Window] = []
    others: list[Window] = []
    for finely in recordings:
        found, rest = windows(finely, sure)
        events += found
        others += [w for w in rest if fitted[w.recording]]
    compared = _compared([w for w in events if fitted[w.recording]], others)
    if compared is None:
        return None
    sizes = np.array([w.left.size for w in compared.events])
    gain, first = _clearest(np.tensordot(sizes, compared.of_events, 1))
    p = tail_probability(_surrogates(compared, sizes), gain)
    if p > criteria.ERROR_RATE_OF_A_CHANNEL:
        return RingDown(p)
    return RingDown(p, _ringing(events, compared, np.array(first)))


def _compared(events: list[Window], others: list[Window]) -> _Compared | None:
    """Windows that can be compared: of recordings that have quiet windows, and of kinds of which there are enough; None
    where too few follow a crossing.
    """
    quiet = [w.recording for w in others if not w.lively]
    known = {r for r in quiet if quiet.count(r) >= FEWEST}
    others = [w for w in others if w.recording in known]
    kinds = {kind for kind in (False, True) if sum(w.lively == kind for w in others) >= FEWEST}
    events = [w for w in events if w.recording in known and w.lively in kinds]
    if len(events) < FEWEST:
        return None
    of_events, of_others = _gains(events), _gains(others)
    off_events, off_others = np.zeros_like(of_events), np.zeros_like(of_others)
    for recording in known:
        own = [k for k, w in enumerate(others) if w.recording == recording and not w.lively]
        total = of_others[own].sum(axis=0)
        for k, window in enumerate(events):
            if window.recording == recording:
                off_events[k] = total / len(own)
        for k, window in enumerate(others):
            if window.recording == recording:
                mine = k in own
                off_others[k] = (total - mine * of_others[k]) / (len(own) - mine)
    return _Compared(events, others, of_events - off_events, of_others - off_others)


def _surrogates(compared: _Compared, sizes: np.ndarray[tuple[int], np.dtype[np.int64]]) -> FloatArray:
    """Largest gain of as many windows that follow no crossing, drawn at random (SURROGATES,)."""
    rng = np.random.default_rng(len(compared.events))
    pools = [compared.alike(event) for event in compared.events]
    out = np.empty(SURROGATES)
    for k in range(SURROGATES):
        drawn = [pool[rng.integers(len(pool))] for pool in pools]
        out[k] = _clearest(np.tensordot(sizes, compared.of_others[drawn], 1))[0]
    return out


def _ringing(events: Sequence[Window], compared: _Compared, first: FloatArray) -> Ringing:
    """What rings after ``events``, by those that decide; ``first``: about its frequency and decay."""
    deciding = compared.events
    whole = _refined(deciding, first)
    parts = _groups(deciding)
    each = np.array([_refined([w for w in deciding if w not in part], whole) for part in parts])
    spread = _jackknife(each)
    squares = [_ring(window, whole) for window in events]
    less = [_of_noise(compared, window, whole) for window in events]
    size_of = [_square(one, whole[1], noise) for one, noise in zip(squares, less, strict=True)]
    size = float(np.sqrt(max(float(np.mean(size_of)), 0.0)))
    error = float(np.std(size_of, ddof=1) / np.sqrt(len(size_of))) / max(2.0 * size, 1e-300)
    rings = []
    for window, one, noise in zip(events, squares, less, strict=True):
        share = max(0.0, 1.0 - noise * one.size / max(float(one.sum()), 1e-300))
        rings.append((window.recording, window.start + FINE_S * np.arange(float(one.size)), share * one))
    inside = max(float(each[:, 1].max()), float(whole[1])) < INSIDE * LONGEST_S
    decay = float(whole[1]), float(spread[1]) if inside else None
    return Ringing((float(whole[0]), float(spread[0])), decay, (size, error), tuple(rings))


def _groups(deciding: Sequence[Window]) -> list[list[Window]]:
    """Groups of windows that are left out one after another: recordings, or parts of the one that has all of them."""
    recordings = sorted({w.recording for w in deciding})
    numbers = [w.recording for w in deciding] if len(recordings) > 1 else list(range(len(deciding)))
    order = {number: k % MOST_GROUPS for k, number in enumerate(sorted(set(numbers)))}
    groups: dict[int, list[Window]] = {}
    for window, number in zip(deciding, numbers, strict=True):
        groups.setdefault(order[number], []).append(window)
    return list(groups.values())


def _jackknife(each: FloatArray) -> FloatArray:
    """Standard deviations (k,) by what is found with each group left out (groups, k) (Efron and Stein, Ann. Statist. 9
    (1981) 586).
    """
    number = len(each)
    return np.asarray(np.sqrt((number - 1.0) / number * np.sum((each - each.mean(axis=0)) ** 2, axis=0)))


def _of_noise(compared: _Compared, window: Window, whole: FloatArray) -> float:
    """Mean square that such an oscillation has in windows that follow no crossing, of the recording or else of all."""
    own = [w for w in compared.others if w.recording == window.recording and w.lively == window.lively]
    kind = own or [w for w in compared.others if w.lively == window.lively] or compared.others
    return float(np.mean([_ring(w, whole).mean() for w in kind]))


def _frequencies() -> FloatArray:
    number = int(np.log(FASTEST_HZ / SLOWEST_HZ) / np.log(RATIO)) + 1
    return np.asarray(SLOWEST_HZ * RATIO ** np.arange(number))


def _columns(size: int, frequency: float, decay: float) -> tuple[FloatArray, FloatArray]:
    """What is no oscillation (size, 5), orthonormal, and the oscillation (size, 2)."""
    time = FINE_S * np.arange(size)
    settles = np.exp(-time[:, None] / np.asarray(SETTLES_S))
    slow = np.asarray(np.linalg.qr(np.column_stack([np.vander(np.linspace(-1.0, 1.0, size), 3), settles]))[0])
    fading = np.exp(-time / decay)
    angle = 2.0 * np.pi * frequency * time
    return slow, np.column_stack([fading * np.cos(angle), fading * np.sin(angle)])


@dataclass(frozen=True, slots=True)
class _Stack:
    """Windows of one size: which they are (``which``), what is ``left`` in them beside a parabola and what settles
    (windows, size), and the sum of squares that a step or a knee leaves of that at best (windows,).
    """

    which: list[int]
    left: FloatArray
    beside_step: FloatArray

    def gain(self, frequency: float, decay: float) -> FloatArray:
        """Log-likelihood of an oscillation less that of a step or a knee (windows,), a step of time."""
        slow, ring = _columns(self.left.shape[1], frequency, decay)
        basis = np.linalg.qr(ring - slow @ (slow.T @ ring))[0]
        square = np.sum(self.left**2, axis=1)
        beside = square - np.sum((self.left @ basis) ** 2, axis=1)
        least = np.maximum(1e-12 * square, 1e-300)
        return np.asarray(0.5 * np.log(np.maximum(self.beside_step, least) / np.maximum(beside, least)))


def _stacked(some: Sequence[Window]) -> list[_Stack]:
    """Windows of each size, with what they hold beside what is no oscillation."""
    out = []
    for size in sorted({w.left.size for w in some}):
        which = [k for k, w in enumerate(some) if w.left.size == size]
        values = np.array([some[k].left for k in which])
        slow = _columns(size, 1.0, 1.0)[0]
        left = values - (values @ slow) @ slow.T
        time = np.arange(size, dtype=np.float64)
        at = np.arange(EVERY, size - EVERY, EVERY)
        forms = np.hstack([time[:, None] >= at, np.maximum(time[:, None] - at, 0.0)])
        forms = forms - slow @ (slow.T @ forms)
        forms /= np.linalg.norm(forms, axis=0)
        out.append(_Stack(which, left, np.sum(left**2, axis=1) - np.max((left @ forms) ** 2, axis=1)))
    return out


def _gains(some: Sequence[Window]) -> FloatArray:
    """Gain of each window for each frequency and decay (windows, frequencies, decays), a step of time; 0 of what
    fades at once.
    """
    out = np.zeros((len(some), _frequencies().size, len(DECAYS_S)))
    for stack in _stacked(some):
        for i, frequency in enumerate(_frequencies()):
            for j, decay in enumerate(DECAYS_S):
                if frequency * decay >= FEWEST_PERIODS:
                    out[stack.which, i, j] = stack.gain(float(frequency), decay)
    return out


def _clearest(gain: FloatArray) -> tuple[float, tuple[float, float]]:
    """The largest of some gains (frequencies, decays) at a frequency that explains more than those next to it, with
    frequency and decay; 0 where there is none: what is slower or faster than all of them is no oscillation that is seen
    here.
    """
    of_each = gain.max(axis=1)
    summits = np.zeros(of_each.size, dtype=bool)
    summits[1:-1] = (of_each[1:-1] > of_each[:-2]) & (of_each[1:-1] > of_each[2:])
    i = int(np.argmax(np.where(summits, of_each, -np.inf)))
    frequency, decay = float(_frequencies()[i]), DECAYS_S[int(np.argmax(gain[i]))]
    return (float(max(of_each[i], 0.0)) if summits[i] else 0.0), (frequency, decay)


def _refined(some: Sequence[Window], first: FloatArray) -> FloatArray:
    """Frequency and decay that explain most."""
    stacked = _stacked(some)

    def cost(logarithms: FloatArray) -> float:
        frequency, decay = (float(v) for v in np.exp(logarithms))
        return -float(sum(stack.left.shape[1] * np.sum(stack.gain(frequency, decay)) for stack in stacked))

    lowest = np.log([SLOWEST_HZ / RATIO, 0.5 * DECAYS_S[0]])
    highest = np.log([FASTEST_HZ * RATIO, LONGEST_S])
    start = np.log(first) + FIRST_STEP * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    found = minimize(
        cost,
        np.log(first),
        method="Nelder-Mead",
        bounds=list(zip(lowest.tolist(), highest.tolist(), strict=True)),
        options={"xatol": 1e-3, "fatol": 1e-3, "initial_simplex": np.clip(start, lowest, highest)},
    )
    return np.asarray(np.exp(found.x))


def _ring(window: Window, whole: FloatArray) -> FloatArray:
    """Square of what rings in a window, from step to step."""
    slow, ring = _columns(window.left.size, float(whole[0]), float(whole[1]))
    both = np.column_stack([slow, ring])
    coefficients = np.linalg.lstsq(both, window.left, rcond=None)[0][slow.shape[1] :]
    return np.asarray((ring @ coefficients) ** 2)


def _square(squares: FloatArray, decay: float, noise: float) -> float:
    """Square of the amplitude at the begin of an oscillation that fades, by its ``squares`` from step to step, less the
    mean square that ``noise`` has of it.
    """
    fading = np.exp(-2.0 * FINE_S * np.arange(squares.size) / decay)
    return float(2.0 * (squares.sum() - noise * squares.size) / fading.sum())
