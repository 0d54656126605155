"""Bursts: blocks of the campaign in which what is left scatters far more than elsewhere.

The logarithm of a block's mean square has a spread of its own, by the noise and by the speed; it is taken from the
blocks themselves (median absolute deviation), about the median of the blocks of a like speed. Blocks are of steady
motion: starts, reversals and ramps have dynamics that no simulation of the slow physics claims.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, ndtri

from bench.mismatch import criteria
from bench.mismatch.recordings.rows import settled_rows
from bench.mismatch.regression.scan import units
from bench.mismatch.regression.search import Search
from bench.simulation.frame import FloatArray, IntArray

FEWEST_BLOCKS = 30
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


def bursts(search: Search) -> Bursts | None:
    """Loud blocks of what a channel's model leaves; None where the recordings are too few blocks to tell."""
    model = search.model
    problem = model.problem
    rows = np.flatnonzero(problem.train)
    frame = problem.rows.frame.take(rows)
    index = [i for b in model.blocks() for i in b.place]
    left = model.bank.residual(index, model.fit.coefficients)
    starts = model.bank.whitening.starts
    # a recording's own offset is no burst
    mean = model.bank.whitening.by_recording(model.bank.one * left) / np.maximum(model.bank.energy, 1e-300)
    left = left - np.repeat(mean, np.diff(starts)) * model.bank.one
    blocks = units(frame.elapsed, starts, max(criteria.BLOCK_S, 3.0 * model.noise.memory))
    edges = blocks.starts
    settled = settled_rows(frame).astype(np.float64)
    if problem.spec.integral:
        settled = np.ones(frame.size)
    number = np.add.reduceat(settled, edges[:-1])
    enough = number >= 4
    if enough.sum() < FEWEST_BLOCKS:
        return None
    loud = np.log(np.add.reduceat(settled * left**2, edges[:-1]) / np.maximum(number, 1.0) + 1e-300)
    speed = np.add.reduceat(np.abs(frame.velocity), edges[:-1]) / np.diff(edges)
    usual = np.zeros(loud.size)
    usual[enough] = _like(loud[enough], speed[enough])
    spread = 1.4826 * np.median(np.abs((loud - usual)[enough])) * np.ones(loud.size)
    # short blocks scatter more: as the logarithm of a mean of squares
    spread = np.maximum(spread, np.sqrt(2.0 / np.maximum(number, 1.0)))
    z = np.where(enough, (loud - usual) / spread, -np.inf)
    worst = int(np.argmax(z))
    p = max(float(-np.expm1(enough.sum() * np.log1p(-ndtr(-z[worst])))), criteria.LEAST_P)
    marked = z > -ndtri(criteria.ERROR_RATE_OF_A_CHANNEL / enough.sum())
    marked &= enough & (loud - usual > np.log(LEAST_LOUDER))
    own = np.concatenate([rows[a:b] for a, b, m in zip(edges[:-1], edges[1:], marked, strict=True) if m] or [rows[:0]])
    return Bursts(own, p, float(np.exp(0.5 * (loud - usual)[worst])))


def _like(loud: FloatArray, speed: FloatArray) -> FloatArray:
    """Median of the blocks of a like speed (a third to either side in rank)."""
    order = np.argsort(speed)
    width = max(loud.size // 3, 15)
    out = np.empty(loud.size)
    for place, k in enumerate(order):
        a = min(max(place - width // 2, 0), max(loud.size - width, 0))
        out[k] = np.median(loud[order[a : a + width]])
    return out
