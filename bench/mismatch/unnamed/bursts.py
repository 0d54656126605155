"""Bursts: blocks of the campaign in which what is left scatters far more than elsewhere.

The logarithm of a block's mean square has a spread of its own, by the noise and by the speed; it is taken from the
blocks themselves (median absolute deviation; of those of a like speed where these scatter far more than all), about the
median of the blocks of a like speed. With its loudest row no louder than the next a block has to be loud as well.
Blocks are of steady motion: starts, reversals and ramps have dynamics that no simulation of the slow physics claims.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri
from scipy.stats import binom

from bench.mismatch import criteria
from bench.mismatch.recordings.rows import settled_rows
from bench.mismatch.regression.sign_blocks import units
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, Frame, IntArray

EVENT_S = 1.0
"""shorter blocks that are looked at as well: what a knock sets ringing decays within about a second, and is lost in a
block of :data:`criteria.BLOCK_S`
"""
FEWEST_BLOCKS = 30
FEWEST_ROWS = 4
"""rows of steady motion in a block below which its mean square tells nothing"""
MOST_LOUDEST = 5
"""blocks that are asked together: what knocks or sticks does so again and again, each time hardly beyond noise"""
SCATTER_MORE = 1.7
"""times as much as all blocks that those of a like speed scatter, from which their own scatter is taken: of fifteen
blocks the median absolute deviation is known to a third
"""
LEAST_LOUDER = 2.0
"""mean square over that of other blocks from which a block counts as louder, whatever its chance"""


@dataclass(frozen=True, slots=True)
class Bursts:
    """The loud blocks: rows of the channel (numbers among all rows), chance of the loudest in noise, how much louder
    (ratio of root mean squares).
    """

    rows: IntArray
    p_value: float
    louder: float


def bursts(search: Search, known: NDArray[np.bool_] | None = None) -> Bursts | None:
    """Loud blocks of what a channel's model leaves, of the length that shows them best; None where too few can tell.
    ``known`` (n,): rows of the channel that are loud by something that was found.
    """
    model = search.model
    problem = model.problem
    rows = np.flatnonzero(problem.train)
    frame = problem.rows.frame.take(rows)
    index = [i for b in model.blocks() for i in b.indices]
    left = model.bank.residual(index, model.fit.coefficients)
    starts = model.bank.whitening.starts
    # a recording's own offset is no burst
    mean = model.bank.whitening.by_recording(model.bank.one * left) / np.maximum(model.bank.energy, 1e-300)
    left = left - np.repeat(mean, np.diff(starts)) * model.bank.one
    settled = np.ones(frame.size) if problem.spec.integral else _well_inside(settled_rows(frame), starts)
    settled = settled if known is None else settled * ~known[rows]
    memory = 3.0 * model.noise.memory
    lengths = dict.fromkeys((max(criteria.BLOCK_S, memory), max(EVENT_S, memory)))
    looks = [
        _loud(units(frame.elapsed, starts, length).starts, left, settled, frame, len(lengths)) for length in lengths
    ]
    found = [look for look in looks if look is not None]
    if not found:
        return None
    clearest = min(found, key=lambda look: look.p_value)
    return replace(clearest, rows=rows[clearest.rows])


def _loud(edges: IntArray, left: FloatArray, settled: FloatArray, frame: Frame, looks: int) -> Bursts | None:
    """Loud blocks between ``edges`` (b + 1,) of a frame's rows; the chance is corrected for the number of looks."""
    number = np.add.reduceat(settled, edges[:-1])
    enough = number >= FEWEST_ROWS
    if enough.sum() < FEWEST_BLOCKS:
        return None
    squares = settled * left**2
    total = np.add.reduceat(squares, edges[:-1])
    speed = np.add.reduceat(np.abs(frame.velocity), edges[:-1]) / np.diff(edges)
    loud, usual, z = _louder(total, number, speed, enough)
    # noise with heavy tails makes a block loud by one row, what knocks or sticks lasts longer: with its loudest row no
    # louder than the next a block has to be loud as well
    loudest = np.maximum.reduceat(squares, edges[:-1])
    next_loudest = np.maximum.reduceat(np.where(squares < np.repeat(loudest, np.diff(edges)), squares, 0.0), edges[:-1])
    lasting = np.minimum(z, _louder(total - loudest + next_loudest, number, speed, enough)[2])
    worst = int(np.argmax(lasting))
    p = _chance(lasting[enough], looks)
    marked = z > -ndtri(criteria.ERROR_RATE_OF_A_CHANNEL / (looks * enough.sum()))
    marked &= enough & (loud - usual > np.log(LEAST_LOUDER))
    inside = np.repeat(marked, np.diff(edges))
    return Bursts(np.flatnonzero(inside), max(p, criteria.LEAST_P), float(np.exp(0.5 * (loud - usual)[worst])))


def _chance(z: FloatArray, looks: int) -> float:
    """Chance that of as many blocks of noise as ``z`` (n,) the loudest, or the two loudest, or so many up to
    :data:`MOST_LOUDEST` are as loud; corrected for these and for the number of ``looks``.
    """
    loudest = np.sort(z)[::-1][:MOST_LOUDEST]
    number = 1.0 + np.arange(loudest.size)
    # so many of n at least, each with the chance of the quietest of them
    chances = np.asarray(binom.sf(number - 1.0, z.size, ndtr(-loudest)))
    return float(min(1.0, looks * loudest.size * float(chances.min())))


def _well_inside(settled: NDArray[np.bool_], starts: IntArray) -> FloatArray:
    """Whether a row and its neighbours in the recording are in steady motion: speeds are smoothed, and what comes a
    moment before a reversal is smeared into the row before it.
    """
    before, after = np.roll(settled, 1), np.roll(settled, -1)
    before[starts[:-1]] = after[starts[1:] - 1] = False
    return np.asarray(settled & before & after, dtype=np.float64)


def _louder(
    total: FloatArray, number: FloatArray, speed: FloatArray, enough: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Logarithm of the mean square of each block, what is usual at its speed, and by how many standard deviations of
    the blocks it is more; minus infinity where a block has not ``enough`` rows.
    """
    loud = np.log(total / np.maximum(number, 1.0) + 1e-300)
    usual, spread = np.zeros(loud.size), np.zeros(loud.size)
    usual[enough] = _like(loud[enough], speed[enough])
    apart = np.abs((loud - usual)[enough])
    # blocks of long recordings, of which there are most, may scatter less than those of short ones at other speeds
    near = _like(apart, speed[enough])
    spread[enough] = 1.4826 * np.where(near > SCATTER_MORE * np.median(apart), near, np.median(apart))
    # short blocks scatter more: as the logarithm of a mean of squares
    spread = np.maximum(spread, np.sqrt(2.0 / np.maximum(number, 1.0)))
    return loud, usual, np.where(enough, (loud - usual) / spread, -np.inf)


def _like(values: FloatArray, speed: FloatArray) -> FloatArray:
    """Median of the values of the blocks of a like speed (a third of all, a sixth to either side in rank)."""
    order = np.argsort(speed)
    width = max(values.size // 3, 15)
    out = np.empty(values.size)
    for rank, k in enumerate(order):
        a = min(max(rank - width // 2, 0), max(values.size - width, 0))
        out[k] = np.median(values[order[a : a + width]])
    return out
