"""Ring-down: a play that the load torque crosses is flung over, and what is free in it rings and fades.

A torque's rows are as long as a second, so they do not show it. What the model leaves is looked at in steps of
:data:`FINE_S`, from each moment in motion at which the load torque passes zero. A parabola and a decaying oscillation
are fitted to each such window: frequency and decay are common to all, size and phase each window's own. How much more
the oscillation explains than the parabola alone is compared with windows of the same recordings that follow no such
moment, those after starts and reversals with those after starts and reversals. A control loop rings in both.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize

from bench.mismatch import criteria
from bench.mismatch.regression.maxima import tail_probability
from bench.simulation.frame import FloatArray, Frame, IntArray

FINE_S = 0.02
"""steps in which it is looked for"""
WINDOW_S = 2.0
"""after a crossing; of what fades more slowly this shows the begin"""
SHORTEST_S = 1.0
"""window after which the motion may end, or the load cross zero again"""
AFTER_S = 1.5
"""time after a start or a reversal in which the control loops are felt"""
SOON_S = 0.5
"""after a crossing at rest, as where the direction changes"""
SLOWEST_HZ, FASTEST_HZ, RATIO = 1.5, 12.5, 1.06
"""frequencies: three periods in a window, four steps in a period; from one to the next"""
DECAYS_S = (0.1, 0.2, 0.4, 0.8, 1.6)
FEWEST = 4
"""crossings, and controls of each kind, below which nobody can say that they are alike"""
MOST_RECORDINGS = 16
SURROGATES = 199
SURE_OF = 3.0
"""standard deviations of the load torque about zero that are no crossing"""


@dataclass(frozen=True, slots=True)
class Finely:
    """What a model leaves (n,) of one recording in steps of :data:`FINE_S`, with their frame."""

    frame: Frame
    left: FloatArray


@dataclass(frozen=True, slots=True)
class Ringing:
    """What rings after crossings: frequency (Hz), decay (s) and size with their standard deviations; ``rings``:
    recording, times since its begin (k,) and mean squares (k,) of what rings after each crossing.
    """

    frequency: tuple[float, float]
    decay: tuple[float, float]
    size: tuple[float, float]
    rings: tuple[tuple[int, FloatArray, FloatArray], ...]

    def on_rows(self, frame: Frame) -> FloatArray:
        """Root mean square of what rings at each row (n,) of a frame."""
        out = np.zeros(frame.size)
        for recording, times, squares in self.rings:
            at = np.flatnonzero(frame.recording == recording)
            if at.size == 0:
                continue
            middle = 0.5 * (frame.elapsed[at][1:] + frame.elapsed[at][:-1])
            row = np.searchsorted(middle, times)
            out[at] += np.bincount(row, squares, at.size) / np.maximum(np.bincount(row, minlength=at.size), 1.0)
        return np.sqrt(out)


@dataclass(frozen=True, slots=True)
class RingDown:
    """The chance that noise rings as much after crossings; what rings, where that is rare."""

    p_value: float
    ringing: Ringing | None = None


@dataclass(frozen=True, slots=True)
class _Window:
    """What is left (k,) in a window of a recording that begins at ``start`` s; whether a start or reversal is felt in
    it.
    """

    recording: int
    start: float
    left: FloatArray
    lively: bool


def on_grid(frame: Frame, left: FloatArray, recording: int) -> Finely | None:
    """What is ``left`` (n,) at the rows of a ``frame`` in steps of :data:`FINE_S`, for rows of about that length: those
    of a recording, each step as the row next to it; None where it has no rows.
    """
    at = np.flatnonzero(frame.recording == recording)
    if at.size < 2:
        return None
    times = frame.elapsed[at]
    grid = np.arange(times[0], times[-1], FINE_S)
    nearest = at[np.searchsorted(0.5 * (times[1:] + times[:-1]), grid)]
    return Finely(replace(frame.take(nearest), elapsed=grid), left[nearest])


def to_read(frame: Frame) -> IntArray:
    """Recordings in which the load torque passes zero from one row in motion to the next, those with the most first;
    then others that start or reverse, with which these are compared, those with the most first. At most
    :data:`MOST_RECORDINGS`, half of them others; none where the load passes zero in none.
    """
    moving = np.flatnonzero(frame.direction != 0)
    sign, recording = np.sign(frame.torque_level[moving]), frame.recording[moving]
    same = recording[1:] == recording[:-1]
    size = 1 + int(frame.recording.max(initial=0))
    crossed = np.bincount(recording[1:][same & (sign[1:] * sign[:-1] < 0)], minlength=size)
    turned = np.bincount(recording[1:][~same | (np.diff(frame.direction[moving]) != 0)], minlength=size)
    first = np.argsort(-crossed, kind="stable")
    first = first[crossed[first] > 0][: MOST_RECORDINGS // 2]
    if first.size == 0:
        return first
    others = np.argsort(-turned, kind="stable")
    others = others[(crossed[others] == 0) & (turned[others] > 0)]
    return np.concatenate((first, others))[:MOST_RECORDINGS]


def ring_down(
    read: Callable[[int], Finely | None], recordings: Sequence[int], fitted: Sequence[bool]
) -> RingDown | None:
    """Ringing after crossings in some ``recordings``, of which some are ``fitted``: these decide. None where it cannot
    be told. ``read``: what is left of a recording, by its number.
    """
    events: list[_Window] = []
    others: list[_Window] = []
    for number in recordings:
        finely = read(int(number))
        if finely is not None:
            found, rest = _windows(finely)
            events += found
            others += [w for w in rest if fitted[number]]
    deciding = [w for w in events if fitted[w.recording]]
    controls = {kind: [w for w in others if w.lively == kind] for kind in (False, True)}
    deciding = [w for w in deciding if len(controls[w.lively]) >= FEWEST]
    if len(deciding) < FEWEST:
        return None
    gains = _gains(deciding)
    drawn = _surrogates(deciding, controls)
    best = np.unravel_index(int(np.argmax(gains.sum(axis=0))), gains.shape[1:])
    p = tail_probability(drawn, float(gains.sum(axis=0)[best]))
    if p > criteria.ERROR_RATE_OF_A_CHANNEL:
        return RingDown(p)
    first = np.array([_frequencies()[best[0]], DECAYS_S[best[1]]])
    return RingDown(p, _ringing(events, deciding, controls, first))


def _ringing(
    events: Sequence[_Window], deciding: Sequence[_Window], controls: dict[bool, list[_Window]], first: FloatArray
) -> Ringing:
    """What rings after ``events``, by those that are ``deciding``; ``first``: about its frequency and decay."""
    whole = _refined(deciding, first)
    # jackknife over recordings, or over crossings where one recording has all of them
    recordings = {w.recording for w in deciding}
    parts = [[w for w in deciding if w.recording != r] for r in recordings]
    if len(recordings) == 1:
        parts = [[w for w in deciding if w is not one] for one in deciding]
    each = np.array([_refined(part, whole) for part in parts])
    spread = np.sqrt((len(each) - 1.0) / len(each) * np.sum((each - each.mean(axis=0)) ** 2, axis=0))
    noise = {kind: float(np.mean([_ring(w, whole).sum() for w in of])) for kind, of in controls.items() if of}
    sizes: list[float] = []
    rings: list[tuple[int, FloatArray, FloatArray]] = []
    for window in events:
        squares = _ring(window, whole)
        # what noise has of such an oscillation
        squares = squares * max(0.0, 1.0 - noise.get(window.lively, 0.0) / max(float(squares.sum()), 1e-300))
        sizes.append(_size(squares, whole[1]))
        rings.append((window.recording, window.start + FINE_S * np.arange(float(squares.size)), squares))
    size = float(np.sqrt(np.mean(np.square(sizes))))
    error = float(np.std(sizes, ddof=1) / np.sqrt(len(sizes)))
    return Ringing(
        (float(whole[0]), float(spread[0])), (float(whole[1]), float(spread[1])), (size, error), tuple(rings)
    )


def _windows(finely: Finely) -> tuple[list[_Window], list[_Window]]:
    """Windows after crossings, and those that follow none."""
    frame, left = finely.frame, finely.left
    longest, shortest = round(WINDOW_S / FINE_S), round(SHORTEST_S / FINE_S)
    moving = frame.direction != 0
    turned = np.flatnonzero(np.diff(frame.direction) != 0) + 1
    at = crossings(frame)
    ends = np.unique(np.concatenate((turned, at, [frame.size])))
    number = int(frame.recording[0]) if frame.size else 0

    def window(begin: int) -> _Window | None:
        end = min(int(ends[np.searchsorted(ends, begin, side="right")]), begin + longest)
        if end - begin < shortest or not moving[begin:end].all():
            return None
        lively = bool(frame.reversal_time[begin] < AFTER_S)
        return _Window(number, float(frame.elapsed[begin]), left[begin:end], lively)

    found = [w for w in map(window, at.tolist()) if w is not None]
    free = np.ones(frame.size, dtype=bool)
    for k in at:
        free[max(k - longest // 4, 0) : k + 2 * longest] = False
    rest: list[_Window] = []
    begins = np.concatenate((turned, np.arange(0, frame.size, longest)))
    for begin in np.unique(begins).tolist():
        one = window(begin) if free[begin : begin + longest].all() else None
        if one is not None:
            rest.append(one)
    return found, rest


def crossings(frame: Frame) -> IntArray:
    """Steps of a recording in motion at which the load torque has passed zero, or the first after a turn that comes
    soon: it is further from zero before and after than it scatters from one step to the next.
    """
    torque = frame.torque
    if torque.size < 3:
        return np.zeros(0, dtype=np.int64)
    scatter = 1.4826 * float(np.median(np.abs(np.diff(torque)))) / np.sqrt(2.0)
    sure = np.flatnonzero(np.abs(torque) > SURE_OF * scatter)
    sign = np.sign(torque[sure])
    changed = np.flatnonzero(sign[1:] != sign[:-1])
    turned = np.flatnonzero(np.diff(frame.direction) != 0) + 1
    out: list[int] = []
    soon = round(SOON_S / FINE_S)
    for a, b in zip(sure[changed], sure[changed + 1], strict=True):
        k = a + 1 + int(np.argmin(np.abs(torque[a + 1 : b + 1])))
        begins = [k, *turned[(turned > k) & (turned <= k + soon)].tolist()]
        out += [begin for begin in begins if frame.direction[begin] != 0][-1:]
    return np.unique(np.asarray(out, dtype=np.int64))


def _frequencies() -> FloatArray:
    number = int(np.log(FASTEST_HZ / SLOWEST_HZ) / np.log(RATIO)) + 1
    return np.asarray(SLOWEST_HZ * RATIO ** np.arange(number))


def _columns(size: int, frequency: float, decay: float) -> tuple[FloatArray, FloatArray]:
    """Parabola (size, 3), orthonormal, and oscillation (size, 2)."""
    time = FINE_S * np.arange(size)
    slow = np.asarray(np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, size), 3))[0], dtype=np.float64)
    fading = np.exp(-time / decay)
    angle = 2.0 * np.pi * frequency * time
    return slow, np.column_stack([fading * np.cos(angle), fading * np.sin(angle)])


def _stacked(windows: Sequence[_Window]) -> list[tuple[list[int], FloatArray]]:
    """Windows of one size each: which they are, and what is left in them beside a parabola (windows, size)."""
    out = []
    for size in sorted({w.left.size for w in windows}):
        which = [k for k, w in enumerate(windows) if w.left.size == size]
        values = np.array([windows[k].left for k in which])
        slow = _columns(size, 1.0, 1.0)[0]
        out.append((which, values - (values @ slow) @ slow.T))
    return out


def _gain(left: FloatArray, frequency: float, decay: float) -> FloatArray:
    """Gain of log-likelihood of an oscillation beside a parabola in windows (windows, size): (windows,)."""
    slow, ring = _columns(left.shape[1], frequency, decay)
    basis = np.linalg.qr(ring - slow @ (slow.T @ ring))[0]
    share = np.sum((left @ basis) ** 2, axis=1) / np.maximum(np.sum(left**2, axis=1), 1e-300)
    return np.asarray(-0.5 * left.shape[1] * np.log(np.maximum(1.0 - share, 1e-12)))


def _gains(windows: Sequence[_Window]) -> FloatArray:
    """Gain of each window for each frequency and decay (windows, frequencies, decays)."""
    out = np.zeros((len(windows), _frequencies().size, len(DECAYS_S)))
    for which, left in _stacked(windows):
        for i, frequency in enumerate(_frequencies()):
            for j, decay in enumerate(DECAYS_S):
                out[which, i, j] = _gain(left, float(frequency), decay)
    return out


def _surrogates(events: Sequence[_Window], controls: dict[bool, list[_Window]]) -> FloatArray:
    """Largest gain of as many controls of the same kinds, drawn at random (SURROGATES,)."""
    rng = np.random.default_rng(len(events))
    gains = {kind: _gains(windows) for kind, windows in controls.items()}
    kinds = [w.lively for w in events]
    out = np.empty(SURROGATES)
    for k in range(SURROGATES):
        total = sum(gains[kind][rng.integers(len(controls[kind]))] for kind in kinds)
        out[k] = float(np.max(total))
    return out


def _refined(windows: Sequence[_Window], first: FloatArray) -> FloatArray:
    """Frequency and decay that explain most."""

    stacked = _stacked(windows)

    def cost(logarithms: FloatArray) -> float:
        frequency, decay = np.exp(logarithms)
        return -sum(float(np.sum(_gain(left, float(frequency), float(decay)))) for _, left in stacked)

    bounds = [
        (np.log(SLOWEST_HZ / RATIO), np.log(FASTEST_HZ * RATIO)),
        (np.log(0.5 * DECAYS_S[0]), np.log(2.0 * DECAYS_S[-1])),
    ]
    found = minimize(cost, np.log(first), method="Nelder-Mead", bounds=bounds, options={"xatol": 1e-3, "fatol": 1e-3})
    return np.asarray(np.exp(found.x))


def _ring(window: _Window, whole: FloatArray) -> FloatArray:
    """Square of what rings in a window, from step to step."""
    slow, ring = _columns(window.left.size, float(whole[0]), float(whole[1]))
    both = np.column_stack([slow, ring])
    coefficients = np.linalg.lstsq(both, window.left, rcond=None)[0][slow.shape[1] :]
    return np.asarray((ring @ coefficients) ** 2)


def _size(squares: FloatArray, decay: float) -> float:
    """Amplitude at the begin of an oscillation that fades, by its ``squares`` from step to step."""
    fading = np.exp(-2.0 * FINE_S * np.arange(squares.size) / decay)
    return float(np.sqrt(2.0 * squares.sum() / fading.sum()))
