"""Orders of a joint that never turns its output round.

Where no steady part covers a revolution, the orders of the output are not told apart, and what changes slowly over the
angle is a function of it. But what comes several times in each swing has an order all the same: the motor's shaft turns
many times. Its waves are fitted to the rows of all swings together; how large noise is at an order its neighbours say,
so that what is left of anything slow is not taken for one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import finufft
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.mismatch import criteria
from bench.mismatch.orders.periodicity import on_rows
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.regression.excess import levelled
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.waves import Wave, kept_by_mean

PERIODS = 6.0
"""of an order in the travel of a swing, from which it is told from what changes slowly"""
STEPS_A_PERIOD = 3.0
"""rows that an order's period mostly has at least: with fewer a lower one looks alike"""
NEIGHBOURS = 30
"""frequencies on either side, half a line of the longest swing apart, whose median tells the noise at one"""
MOST = 24
"""orders that are told"""
CLIMBS = 2.0
"""widths of a line on either side of an order that was asked, within which its summit is looked for"""
FINE = 64
"""steps of a line's width in which it is"""
TONES = 64
"""frequencies on either side of an order's usual one, half a line of the longest recording apart, at which a tone is
asked in its place
"""
SURELY = 3.0
"""standard deviations by which an order is no multiple of the shaft's, and none of the output's"""
APART = 0.25
"""orders by which a whole one is another than a multiple of the shaft's"""
ACCURACY = 1e-9
"""relative, of the sums over the rows"""


@dataclass(frozen=True, slots=True)
class SwingOrder:
    """An order that stands in the swings: its ``wave``, the standard deviation of its frequency ``std`` in orders, its
    ``gain`` of log-likelihood, the chance that the best of all orders gains as much in noise; whether it is a multiple
    of the motor shaft's.
    """

    wave: Wave
    std: float
    gain: float
    p_value: float
    of_shaft: bool


def bounds(frame: Frame) -> tuple[float, float] | None:
    """The lowest and the highest order per revolution of the output that are looked for in the rows of a frame; None
    where none is. The longest swing says which order comes several times, the rows how quick it may be; and orders
    enough have to lie between to tell noise from one.
    """
    if frame.size < 2 * NEIGHBOURS:
        return None
    steps = np.abs(np.diff(frame.theta))[np.diff(frame.recording) == 0]
    longest = _longest(frame)
    if not steps.size or not longest > 0.0:
        return None
    lowest = 2.0 * np.pi * PERIODS / longest
    highest = 2.0 * np.pi / (STEPS_A_PERIOD * max(float(np.median(steps)), 1e-12))
    return (lowest, highest) if (highest - lowest) * longest / np.pi >= 2 * NEIGHBOURS else None


def _longest(frame: Frame) -> float:
    """The longest swing of a recording, rad of the output."""
    return max((float(np.ptp(frame.theta[frame.recording == k])) for k in np.unique(frame.recording)), default=0.0)


def search(rows: Rows, y: FloatArray, fitted: NDArray[np.bool_]) -> tuple[SwingOrder, ...]:
    """Orders that stand in ``y`` (n,) at the ``fitted`` rows (n,), strongest first."""
    chosen = np.flatnonzero(fitted & (rows.number > 0))
    some, values = rows.take(chosen), y[chosen]
    frame = some.frame
    between = bounds(frame)
    asked = np.zeros(0) if between is None else _asked(frame.ratio, *between)
    if between is None or not asked.size:
        return ()
    width = 2.0 * np.pi / _longest(frame)
    spaced = np.arange(*between, 0.5 * width)
    fit = _Fit(frame, values, some.number.astype(np.float64))
    noise, passed = np.interp(asked, spaced, fit.noise(spaced)), np.zeros(asked.size, dtype=bool)
    while len(fit.orders) < MOST:
        power = np.where(passed, 0.0, fit.power(asked) / noise)
        best = int(np.argmax(power))
        if asked.size * float(np.exp(-power[best])) > criteria.ERROR_RATE_OF_A_CHANNEL:
            break
        order = fit.summit(float(asked[best]), width, float(noise[best]))
        passed[best] = True
        # what is left at an order that was fitted is no wave of it, and what is as well a tone is no order for sure
        if all(abs(order - f) >= 0.5 * APART for f in fit.orders) and fit.beyond_tones(order) > (
            criteria.VERY_STRONG * float(noise[best])
        ):
            fit.add(order)
            noise = np.interp(asked, spaced, fit.noise(spaced))
    noise_at = fit.noise(spaced)
    out = []
    for k, f in enumerate(fit.orders):
        cosine, sine = fit.amplitudes[k]
        # of white noise of unit weight a component's variance is twice that over the weights that its rows keep
        variance = 2.0 * float(np.interp(f, spaced, noise_at)) / fit.kept(f)
        std = float(np.sqrt(variance))
        gain = float(0.5 * (cosine**2 + sine**2) / variance)
        chance = min(1.0, asked.size * float(np.exp(-gain)))
        wave = Wave(f, "1", float(cosine), float(sine), std, std)
        out.append(SwingOrder(wave, fit.std(gain), gain, chance, _of_shaft(f, frame.ratio)))
    return tuple(sorted(out, key=lambda order: -order.gain))


class _Fit:
    """Orders fitted to values (n,) of some weights at the rows of a frame, beside a level and a line in each recording;
    each row is a mean over the angle that it turns through.
    """

    def __init__(self, frame: Frame, y: FloatArray, weight: FloatArray) -> None:
        self.theta, self.weight, self.root, self.ratio = frame.theta, weight, np.sqrt(weight), frame.ratio
        self.turned, self.time, self.speed = np.abs(frame.velocity) * frame.step, frame.time, np.abs(frame.velocity)
        self.orders: list[float] = []
        self._columns: list[FloatArray] = []
        self._recordings = [np.flatnonzero(frame.recording == k) for k in np.unique(frame.recording)]
        self._y = self._less_lines(y)
        self.rest: FloatArray = self._y
        self.amplitudes: FloatArray = np.zeros((0, 2))

    def _less_lines(self, values: FloatArray) -> FloatArray:
        """Values (n,) less the level and the line of each recording."""
        out = values.copy()
        for rows in self._recordings:
            angle, weight = self.theta[rows], self.weight[rows]
            line = np.column_stack([np.ones(rows.size), angle - np.average(angle, weights=weight)])
            white = line * self.root[rows][:, None]
            out[rows] -= line @ np.linalg.lstsq(white, values[rows] * self.root[rows], rcond=1e-9)[0]
        return out

    def add(self, order: float) -> None:
        """Fit one more order with those that are fitted."""
        self.orders.append(order)
        kept = kept_by_mean(order, self.turned)
        self._columns += [self._less_lines(kept * wave(order * self.theta)) for wave in (np.cos, np.sin)]
        columns = np.column_stack(self._columns)
        white = columns * self.root[:, None]
        beta = np.linalg.lstsq(white, self._y * self.root, rcond=1e-9)[0]
        self.rest, self.amplitudes = self._y - columns @ beta, np.asarray(beta.reshape(-1, 2))

    def kept(self, order: float) -> float:
        """Weight of all rows, less what their means over the angle take of an order."""
        return float(np.sum(self.weight * kept_by_mean(order, self.turned) ** 2))

    def power(self, orders: FloatArray) -> FloatArray:
        """Power of what is left at some orders (k,): of white noise of unit weight its variance."""
        sums = np.zeros(orders.size, dtype=np.complex128)
        for rows in self._recordings:
            # about its own middle: recordings may be many turns apart
            middle = float(np.mean(self.theta[rows]))
            strengths = (self.weight[rows] * self.rest[rows]).astype(np.complex128)
            each = finufft.nufft1d3(self.theta[rows] - middle, strengths, orders, eps=ACCURACY, isign=-1, nthreads=1)
            sums += np.exp(-1j * middle * orders) * each
        return np.asarray(np.abs(sums) ** 2 / float(self.weight.sum()))

    def beyond_tones(self, order: float) -> float:
        """Power at an ``order`` beyond that of a tone of about its frequency, each with a phase of its own in every
        recording. Where the speed hardly varies an order is a tone as well.
        """
        hertz = order * float(np.average(self.speed, weights=self.weight)) / (2.0 * np.pi)
        of_order, of_tones = 0.0, np.zeros(0)
        lasts = max(float(np.ptp(self.time[rows])) for rows in self._recordings)
        tones = 2.0 * np.pi * (hertz + np.arange(-TONES, TONES + 1) / (2.0 * max(lasts, 1e-12)))
        for rows in self._recordings:
            strengths = (self.weight[rows] * self.rest[rows]).astype(np.complex128)
            whole = float(self.weight[rows].sum())
            of_order += abs(np.sum(strengths * np.exp(-1j * order * self.theta[rows]))) ** 2 / whole
            time = self.time[rows] - float(np.mean(self.time[rows]))
            heard = finufft.nufft1d3(time, strengths, tones, eps=ACCURACY, isign=-1, nthreads=1)
            of_tones = np.abs(heard) ** 2 / whole + (of_tones if of_tones.size else 0.0)
        return of_order - float(of_tones.max())

    def noise(self, orders: FloatArray) -> FloatArray:
        """Power of noise at evenly spaced orders (k,), by the median of those about each."""
        return np.asarray(median_filter(self.power(orders), 2 * NEIGHBOURS + 1, mode="mirror") / np.log(2.0))

    def std(self, gain: float) -> float:
        """Standard deviation of an order's frequency that gains so much: one over the root of its information, twice
        the gain times the variance of the angle.
        """
        spread = float(np.average((self.theta - np.average(self.theta, weights=self.weight)) ** 2, weights=self.weight))
        return float(1.0 / np.sqrt(max(2.0 * gain * spread, 1e-300)))

    def summit(self, order: float, width: float, noise: float) -> float:
        """The order at which a line stands that was met at an ``order``, within a few of its widths: a multiple of the
        shaft's, or a whole order of the output, if it is one of these within what is known.
        """
        grid = order + np.arange(-CLIMBS * FINE, CLIMBS * FINE + 1) * width / FINE
        power = self.power(grid[grid > 0.0])
        at = float(grid[grid > 0.0][int(np.argmax(power))])
        std = self.std(float(power.max()) / noise)
        for whole in (self.ratio * round(at / self.ratio) if self.ratio > 1.0 else 0.0, float(round(at))):
            if whole > 0.0 and abs(at - whole) <= max(SURELY * std, width / FINE):
                return whole
        return at


def _asked(ratio: float, lowest: float, highest: float) -> FloatArray:
    """Orders that are asked: whole ones of the output, and multiples of the motor shaft's."""
    whole = np.arange(np.ceil(lowest), np.floor(highest) + 1.0)
    if not ratio > 1.0:
        return np.asarray(whole)
    shaft = ratio * np.arange(max(np.ceil(lowest / ratio), 1.0), np.floor(highest / ratio) + 1.0)
    others = whole[np.abs(whole - ratio * np.round(whole / ratio)) > APART]
    return np.sort(np.concatenate([others, shaft]))


def _of_shaft(order: float, ratio: float) -> bool:
    """Whether an order is a multiple of the motor shaft's."""
    return ratio > 1.0 and abs(order / ratio - round(order / ratio)) < 1e-9


def borne_out(
    found: Sequence[SwingOrder], rows: Rows, y: FloatArray, held_out: NDArray[np.bool_]
) -> tuple[SwingOrder, ...]:
    """Orders of ``y`` (n,) without those with which rows held out (n,) are predicted worse, but for their levels."""
    held = np.flatnonzero(held_out & (rows.number > 0))
    some, number = rows.take(held), rows.number[held]

    def left(orders: Sequence[SwingOrder]) -> float:
        rest = levelled(y[held] - evaluated(orders, some), some.frame, number)
        return float(number @ rest**2)

    kept = list(found)
    for order in reversed(found):
        others = [o for o in kept if o is not order]
        if held.size and left(kept) > left(others):
            kept = others
    return tuple(kept)


def evaluated(found: Sequence[SwingOrder], rows: Rows) -> FloatArray:
    """Sum of orders, as means over the rows (n,), in the channel's unit."""
    return on_rows([order.wave for order in found], rows, rows.frame.theta)
