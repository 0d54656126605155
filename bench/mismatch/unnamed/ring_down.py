"""Ring-down: when the load torque changes its sign, the gearbox crosses its play and may swing freely for a moment.

A torque's rows are as long as a second, so they do not show it. What the model leaves is looked at in short steps from
each moment in motion at which the load torque changes its sign (:mod:`bench.mismatch.unnamed.crossings`). Beside a
parabola and what settles a decaying oscillation is fitted to each such window: frequency and decay are common to all,
size and phase each window's own. How much more it explains than a step or a knee at the best place is compared with
reference windows of the same length that follow no such moment, those after starts and reversals with those after
starts and reversals: a control loop rings in both. An order or a tone rings in all windows of a recording, so the mean
gain of its quiet windows is taken off.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from bench.mismatch import criteria
from bench.mismatch.recordings.vibration import Density
from bench.mismatch.regression.maxima import tail_probability
from bench.mismatch.unnamed.crossings import FINE_S, FineResidual, Window, clear_of_zero, to_read, windows
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
"""within which it fades to 1/e: what fades sooner looks like something that settles"""
FEWEST = 4
"""crossings, and windows of each kind, below which nobody can say that they are alike"""
SURROGATES, MORE_SURROGATES = 199, 5800
"""at first, and where these say that it is rare: a rate of 0.05 % is then counted"""
LENGTHS_S = (2.0, 1.5, 1.0)
"""of windows that are compared with each other"""
MOST_GROUPS = 10
"""that are left out one after another to tell how sure frequency and decay are"""
ALL_BY_ONE = 0.05
"""chance that noise rings as much after all crossings but the loudest: above it one makes all of it, and what comes
once is no property of crossings
"""
EVERY = 5
"""steps of time between places of a step or a knee that are tried"""
SURE_HZ, MOST_OFF = 3.0, 0.1
"""standard deviations of its frequency within which what rings may be a ripple, and of the frequency at most"""
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
    size: tuple[float, float | None]
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
    """The chance that noise rings as much after crossings, and after all but the loudest, the larger of the two where
    the first is rare; what rings, where both are.
    """

    p_value: float
    ringing: Ringing | None = None


@dataclass(frozen=True, slots=True)
class _Alike:
    """Windows of one length: those after crossings that decide, and reference windows, with the gain of each
    (k, frequencies, decays) beyond the mean of the quiet reference windows of its recording.
    """

    events: list[Window]
    reference: list[Window]
    of_events: FloatArray
    of_reference: FloatArray

    def pools(self) -> list[list[int]]:
        """Numbers of the reference windows that each event is compared with: those after starts with those after
        starts, of its own recording where that has enough.
        """
        out = []
        for event in self.events:
            kind = [k for k, w in enumerate(self.reference) if w.after_start == event.after_start]
            own = [k for k in kind if self.reference[k].recording == event.recording]
            out.append(own if len(own) >= FEWEST else kind)
        return out


def ring_down(
    frame: Frame,
    densities: Sequence[Density],
    fitted: NDArray[np.bool_],
    read: Callable[[Sequence[int]], Iterable[FineResidual | None]],
    ripples: Sequence[float] = (),
) -> RingDown | None:
    """Ringing after the load torque, whose spectra have ``densities``, has changed its sign in recordings that rows of
    a ``frame`` show, of which some are ``fitted`` (recordings,): these decide. None where it cannot be told. ``read``:
    what is left of recordings, by their numbers. ``ripples``: orders of the control's ripple, which the load torque
    holds: where it is near zero a steep offset follows them.
    """
    clear, chosen = clear_of_zero(densities), fitted.tolist()
    if clear is None:
        return None
    found = read(to_read(frame, clear, chosen).tolist())
    rings = after_crossings((residual for residual in found if residual is not None), clear, chosen)
    if rings is None or rings.ringing is None or not _of_ripple(rings.ringing, frame, ripples):
        return rings
    return None


def _of_ripple(ringing: Ringing, frame: Frame, ripples: Sequence[float]) -> bool:
    """Whether what rings has, after most crossings, the frequency that a ripple of some order of the output shaft has
    at the speed there.
    """
    frequency, std = ringing.frequency
    near_by = (RATIO - 1.0) * frequency, MOST_OFF * frequency
    speeds = []
    for recording, times, _ in ringing.rings:
        at = np.flatnonzero(frame.recording == recording)
        speeds.append(abs(float(np.interp(times[0], frame.elapsed[at], frame.velocity[at]))))
    near = [
        np.abs(order * np.array(speeds) / (2.0 * np.pi) - frequency) < np.clip(SURE_HZ * std, *near_by)
        for order in ripples
    ]
    return any(float(np.mean(one)) > 0.5 for one in near)


def after_crossings(recordings: Iterable[FineResidual], clear: float, fitted: Sequence[bool]) -> RingDown | None:
    """Ringing after a load torque that is ``clear`` of zero, N·m, has changed its sign in some ``recordings``, of which
    some are ``fitted``: these decide. None where it cannot be told.
    """
    events: list[Window] = []
    reference: list[Window] = []
    for residual in recordings:
        found, rest = windows(residual, clear)
        events += found
        reference += [w for w in rest if fitted[w.recording]]
    alike = _alike([w for w in events if fitted[w.recording]], reference)
    deciding = [w for group in alike for w in group.events]
    if len(deciding) < FEWEST:
        return None
    gain, first = _clearest(np.sum([group.of_events.sum(axis=0) for group in alike], axis=0))
    rng = np.random.default_rng(len(deciding))
    drawn = _surrogates(alike, SURROGATES, rng)
    if tail_probability(drawn, gain) < criteria.ERROR_RATE_OF_A_CHANNEL:
        # what decides is counted
        drawn = np.append(drawn, _surrogates(alike, MORE_SURROGATES, rng))
    p = tail_probability(drawn, gain)
    if p >= criteria.ERROR_RATE_OF_A_CHANNEL:
        return RingDown(p)
    of_others = _chance_without_the_loudest(alike, rng)
    if of_others > ALL_BY_ONE:
        return RingDown(max(p, of_others))
    if p >= criteria.ERROR_RATE_OF_A_LOOK:
        return RingDown(p)
    return RingDown(p, _ringing(events, deciding, reference, np.array(first)))


def _alike(events: Sequence[Window], reference: Sequence[Window]) -> list[_Alike]:
    """Windows in groups of one length, the longest that an event, :data:`FEWEST` quiet windows of its recording and as
    many windows of its kind have. What noise gains in a window depends on its length.
    """
    out = []
    rest = list(events)
    for length in LENGTHS_S:
        steps = round(length / FINE_S)
        cut = [replace(w, left=w.left[:steps]) for w in reference if w.left.size >= steps]
        known = {r for r in {w.recording for w in cut} if len(_quiet(cut, r)) >= FEWEST}
        cut = [w for w in cut if w.recording in known]
        kinds = {kind for kind in (False, True) if sum(w.after_start == kind for w in cut) >= FEWEST}
        chosen = [w for w in rest if w.left.size >= steps and w.recording in known and w.after_start in kinds]
        rest = [w for w in rest if w not in chosen]
        if chosen:
            chosen = [replace(w, left=w.left[:steps]) for w in chosen]
            of_events, of_reference = _gains(chosen), _gains(cut)
            usual = {r: of_reference[_quiet(cut, r)].mean(axis=0) for r in known}
            of_events = of_events - np.array([usual[w.recording] for w in chosen])
            out.append(_Alike(chosen, cut, of_events, of_reference - np.array([usual[w.recording] for w in cut])))
    return out


def _quiet(some: Sequence[Window], recording: int) -> list[int]:
    """Numbers of the windows of a recording that are not just after a start."""
    return [k for k, w in enumerate(some) if w.recording == recording and not w.after_start]


def _surrogates(alike: Sequence[_Alike], number: int, rng: np.random.Generator) -> FloatArray:
    """Largest gain (number,) of as many reference windows drawn at random, each beyond a mean of quiet windows that are
    drawn as well: that mean is no surer.
    """
    out = np.zeros((number, _frequencies().size, len(DECAYS_S)))
    for group in alike:
        quiet_of = {r: _quiet(group.reference, r) for r in {w.recording for w in group.reference}}
        gains = group.of_reference.copy()
        for quiet in quiet_of.values():
            # a mean of its own was taken off each
            gains[quiet] *= np.sqrt(len(quiet) / (len(quiet) - 1.0))
        for pool in group.pools():
            out += gains[rng.choice(pool, number)]
        events_of = Counter(w.recording for w in group.events)
        for recording, times in events_of.items():
            quiet = quiet_of[recording]
            drawn = rng.multinomial(len(quiet), np.full(len(quiet), 1.0 / len(quiet)), number) / len(quiet)
            out -= times * np.tensordot(drawn, gains[quiet], 1)
    return np.array([_clearest(gain)[0] for gain in out])


def _chance_without_the_loudest(alike: Sequence[_Alike], rng: np.random.Generator) -> float:
    """Chance that as many reference windows gain as much as events do, each without the one that gains most."""

    def of_others(gains: FloatArray) -> float:
        whole = gains.sum(axis=0)
        i, j = np.unravel_index(int(np.argmax(whole)), whole.shape)
        return float(whole[i, j] - gains[:, i, j].max())

    pools = [(group.of_reference, group.pools()) for group in alike]
    drawn = [
        of_others(np.concatenate([gains[[rng.choice(pool) for pool in of_group]] for gains, of_group in pools]))
        for _ in range(SURROGATES)
    ]
    return tail_probability(np.array(drawn), of_others(np.concatenate([group.of_events for group in alike])))


def _ringing(
    events: Sequence[Window], deciding: Sequence[Window], reference: Sequence[Window], first: FloatArray
) -> Ringing:
    """What rings after ``events``, by those that decide; ``first``: about its frequency and decay."""
    whole = _refined(deciding, first)
    each = np.array([_refined(rest, whole) for rest in _without_each_group(deciding)])
    spread = _jackknife(each)
    noise = _Noise(reference, whole)
    squares = [_square(one, whole[1], noise.of(w)) for w, one in zip(deciding, _rings(deciding, whole), strict=True)]
    size = float(np.sqrt(max(float(np.mean(squares)), 0.0)))
    error = float(np.std(squares, ddof=1) / np.sqrt(len(squares))) / (2.0 * size) if size > 0.0 else None
    rings = []
    for window, one in zip(events, _rings(events, whole), strict=True):
        share = max(0.0, 1.0 - noise.of(window) * one.size / max(float(one.sum()), 1e-300))
        rings.append((window.recording, window.start + FINE_S * np.arange(float(one.size)), share * one))
    inside = max(float(each[:, 1].max()), float(whole[1])) < INSIDE * LONGEST_S
    decay = float(whole[1]), float(spread[1]) if inside else None
    return Ringing((float(whole[0]), float(spread[0])), decay, (size, error), tuple(rings))


def _without_each_group(deciding: Sequence[Window]) -> list[list[Window]]:
    """Windows without those of each recording, or of each part of the one that has all of them; of at most
    :data:`MOST_GROUPS` groups.
    """
    recordings = sorted({w.recording for w in deciding})
    numbers = [recordings.index(w.recording) for w in deciding] if len(recordings) > 1 else list(range(len(deciding)))
    group = np.asarray(numbers) % MOST_GROUPS
    return [[deciding[k] for k in np.flatnonzero(group != g).tolist()] for g in np.unique(group)]


def _jackknife(each: FloatArray) -> FloatArray:
    """Standard deviations (k,) by what is found with each group left out (groups, k) (Efron and Stein, Ann. Statist. 9
    (1981) 586).
    """
    number = len(each)
    return np.asarray(np.sqrt((number - 1.0) / number * np.sum((each - each.mean(axis=0)) ** 2, axis=0)))


class _Noise:
    """Mean square that an oscillation has in reference windows, by recording and kind, or by kind alone."""

    def __init__(self, reference: Sequence[Window], whole: FloatArray) -> None:
        by_kind: dict[tuple[int | None, bool], list[float]] = {}
        for window, squares in zip(reference, _rings(reference, whole), strict=True):
            for recording in (window.recording, None):
                by_kind.setdefault((recording, window.after_start), []).append(float(squares.mean()))
        self._mean = {key: float(np.mean(values)) for key, values in by_kind.items()}

    def of(self, window: Window) -> float:
        """Mean square in windows like one."""
        kind = window.after_start
        return self._mean.get((window.recording, kind), self._mean.get((None, kind), 0.0))


def _frequencies() -> FloatArray:
    number = int(np.log(FASTEST_HZ / SLOWEST_HZ) / np.log(RATIO)) + 1
    return np.asarray(SLOWEST_HZ * RATIO ** np.arange(number))


def _no_oscillation(size: int) -> FloatArray:
    """A parabola and what settles (size, 5), orthonormal."""
    settles = np.exp(-FINE_S * np.arange(size)[:, None] / np.asarray(SETTLES_S))
    return np.asarray(np.linalg.qr(np.column_stack([np.vander(np.linspace(-1.0, 1.0, size), 3), settles]))[0])


def _oscillation(size: int, frequency: float, decay: float) -> FloatArray:
    """Cosine and sine that fade (size, 2)."""
    time = FINE_S * np.arange(size)
    fading, angle = np.exp(-time / decay), 2.0 * np.pi * frequency * time
    return np.column_stack([fading * np.cos(angle), fading * np.sin(angle)])


def _by_size(some: Sequence[Window]) -> list[tuple[list[int], FloatArray]]:
    """Windows of each size: which they are, and what is left in them (windows, size)."""
    out = []
    for size in sorted({w.left.size for w in some}):
        which = [k for k, w in enumerate(some) if w.left.size == size]
        out.append((which, np.array([some[k].left for k in which])))
    return out


@dataclass(frozen=True, slots=True)
class _Stack:
    """Windows of one size: which they are (``which``), what is ``slow`` and no oscillation (size, 5), what is ``left``
    in them beside that (windows, size), and the sum of squares that a step or a knee leaves of it at best (windows,).
    """

    which: list[int]
    slow: FloatArray
    left: FloatArray
    left_by_step: FloatArray

    def gain(self, frequency: float, decay: float) -> FloatArray:
        """Log-likelihood of an oscillation less that of a step or a knee (windows,)."""
        ring = _oscillation(self.left.shape[1], frequency, decay)
        basis = np.linalg.qr(ring - self.slow @ (self.slow.T @ ring))[0]
        square = np.sum(self.left**2, axis=1)
        beside = square - np.sum((self.left @ basis) ** 2, axis=1)
        least = np.maximum(1e-12 * square, 1e-300)
        ratio = np.maximum(self.left_by_step, least) / np.maximum(beside, least)
        return np.asarray(0.5 * self.left.shape[1] * np.log(ratio))


def _stacked(some: Sequence[Window]) -> list[_Stack]:
    """Windows of each size, with what they hold beside what is no oscillation."""
    out = []
    for which, values in _by_size(some):
        size = values.shape[1]
        slow = _no_oscillation(size)
        left = values - (values @ slow) @ slow.T
        time = np.arange(size, dtype=np.float64)
        at = np.arange(EVERY, size - EVERY, EVERY)
        forms = np.hstack([time[:, None] >= at, np.maximum(time[:, None] - at, 0.0)])
        forms = forms - slow @ (slow.T @ forms)
        forms /= np.linalg.norm(forms, axis=0)
        out.append(_Stack(which, slow, left, np.sum(left**2, axis=1) - np.max((left @ forms) ** 2, axis=1)))
    return out


def _gains(some: Sequence[Window]) -> FloatArray:
    """Gain of each window for each frequency and decay (windows, frequencies, decays); 0 of what fades at
    once.
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
        return -float(sum(np.sum(stack.gain(frequency, decay)) for stack in stacked))

    lowest, highest = np.log([SLOWEST_HZ, DECAYS_S[0]]), np.log([FASTEST_HZ, LONGEST_S])
    start = np.log(first) + FIRST_STEP * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    found = minimize(
        cost,
        np.log(first),
        method="Nelder-Mead",
        bounds=list(zip(lowest.tolist(), highest.tolist(), strict=True)),
        options={"xatol": 1e-3, "fatol": 1e-3, "initial_simplex": np.clip(start, lowest, highest)},
    )
    return np.asarray(np.exp(found.x))


def _rings(some: Sequence[Window], whole: FloatArray) -> list[FloatArray]:
    """Square of what rings in each window, from step to step."""
    out = [np.zeros(0)] * len(some)
    for which, values in _by_size(some):
        slow, ring = _no_oscillation(values.shape[1]), _oscillation(values.shape[1], *whole.tolist())
        found = np.linalg.lstsq(np.column_stack([slow, ring]), values.T, rcond=None)[0][slow.shape[1] :]
        for k, one in zip(which, (ring @ found).T, strict=True):
            out[k] = np.asarray(one**2)
    return out


def _square(squares: FloatArray, decay: float, noise: float) -> float:
    """Square of the amplitude at the begin of an oscillation that fades, by its ``squares`` from step to step, less the
    mean square that ``noise`` has of it.
    """
    fading = np.exp(-2.0 * FINE_S * np.arange(squares.size) / decay)
    return float(2.0 * (squares.sum() - noise * squares.size) / fading.sum())
