"""The transmission error's slow part: its rows without what is periodic, averaged in time, and their noise."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.orders.revolutions import Revolution, Seen, scattered
from bench.mismatch.recordings.rows import LIVELY_S, SLOW_S, Rows, blocks, changed, changes, lively, reduced
from bench.mismatch.regression.noise import MEMORIES_S, Mixture, fitted, of_samples
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.terms.base import top

FEWEST_ON_A_LINE = 3
"""rows of a steady part whose load is told from a straight line"""
TELLS = 10.0
"""times what a load wavers that loads differ by, for them to tell their compliance"""
LOWEST_ORDER = 3
"""below it a revolution cannot tell noise from drift"""


def offset_rows(rows: Rows, y: FloatArray, inside: NDArray[np.bool_]) -> tuple[Rows, NDArray[np.bool_], IntArray]:
    """Average rows in time, ``y`` (n,) in place of what was measured; which blocks are ``inside``; each block's first
    row.
    """
    frame = rows.frame
    width = np.where(lively(frame), LIVELY_S, SLOW_S)
    change = changed(frame.recording, frame.steady, frame.direction, inside)
    step = frame.step.copy()
    step[np.append(True, frame.recording[1:] != frame.recording[:-1])] = 0.0
    limits = changes(top(frame.torque), top(frame.velocity))
    edges = blocks(step / width, step / LIVELY_S, np.cumsum(change), frame.velocity, frame.torque_level, limits)
    total = np.add.reduceat(rows.number, edges)
    mean = np.add.reduceat(y * rows.number, edges) / np.maximum(total, 1.0)
    return Rows(reduced(frame, edges), mean, total), inside[edges], edges


def at_level(rows: Rows, calibrated: NDArray[np.bool_]) -> Rows:
    """Rows as under a load that goes along a straight line in each steady part: what it wavers about that acts by the
    compliance, which the loads of the ``calibrated`` rows (n,) tell, and is taken off. An unbalance wavers once a
    revolution, as an order does, so what the series leaves of it says nothing of how the compliance changes with load,
    speed and temperature. A load that goes further than from one row to the next stays as it is, and so do all where
    the loads differ by too little to tell the compliance.
    """
    frame = rows.frame
    line = _straight(frame, rows.number)
    waver = frame.torque - line
    chosen = np.flatnonzero(calibrated & (rows.number > 0))
    if chosen.size == 0:
        return rows
    if not waver.any() or np.std(line[chosen]) < TELLS * float(np.sqrt(np.mean(waver[chosen] ** 2))):
        return rows
    ahead = frame.last_direction[chosen] > 0
    weight = np.sqrt(rows.number[chosen])
    columns = np.column_stack([line[chosen], ahead, ~ahead]) * weight[:, None]
    slope = np.linalg.lstsq(columns, rows.y[chosen] * weight, rcond=None)[0][0]
    level = np.where(frame.kept > 0.0, frame.torque_level, line)
    return replace(rows, y=rows.y - slope * waver, frame=replace(frame, torque=line, torque_level=level))


def _straight(frame: Frame, number: FloatArray) -> FloatArray:
    """The load torque (n,), in each steady part its straight line over time, if it is never further from that than rows
    may differ (:func:`bench.mismatch.recordings.rows.changes`), and stays on one side of zero.
    """
    out = frame.torque.copy()
    most = float(changes(top(frame.torque), 0.0)[1])
    edges = [0, *np.flatnonzero(changed(frame.recording, frame.steady, frame.direction)).tolist(), frame.size]
    for a, b in itertools.pairwise(edges):
        if frame.steady[a] < 0.5 or b - a < FEWEST_ON_A_LINE or not number[a:b].any():
            continue
        weight = np.sqrt(number[a:b])
        columns = np.column_stack([np.ones(b - a), frame.elapsed[a:b] - frame.elapsed[a]])
        line = columns @ np.linalg.lstsq(columns * weight[:, None], frame.torque[a:b] * weight, rcond=None)[0]
        off = float(np.abs(frame.torque[a:b] - line).max())
        # a play that the waver crosses moves by more than the compliance says
        if off < most and float(np.abs(line).min()) > off:
            out[a:b] = line
    return out


def mixture(seen: Seen, revolutions: Sequence[Revolution], rows: Rows, inner: FloatArray, rate: float) -> Mixture:
    """Noise of the samples from what the revolutions leave at every order, and inside the rows.

    Medians over orders and revolutions: a line that is not known yet is in one of them. ``inner`` (n,): variance of the
    samples inside each row about what is known there; ``rate``: samples a second.
    """
    frequency: list[FloatArray] = []
    density: list[FloatArray] = []
    orders = np.arange(seen.left.shape[1])
    known = [round(f) for f in seen.orders if f < orders.size - 0.5]
    free = np.setdiff1d(orders[LOWEST_ORDER:], known)
    for revolution, left in zip(revolutions, scattered(seen.left, revolutions), strict=True):
        hertz = abs(revolution.velocity) / (2.0 * np.pi)
        frequency.append(free * hertz)
        # a component of the spectrum is noise of density P over the time T: |R|^2 = 2*P/T
        density.append(0.5 * np.abs(left[free]) ** 2 * revolution.revolutions / hertz)
    at, level = np.concatenate(frequency), np.concatenate(density)
    edges = np.geomspace(at.min(), at.max() * 1.0001, 25)
    number = np.digitize(at, edges) - 1
    centre, median = [], []
    for b in range(edges.size - 1):
        levels = level[number == b]
        if levels.size >= 20:
            centre.append(float(np.sqrt(edges[b] * edges[b + 1])))
            median.append(float(np.median(levels)) / np.log(2.0))
    found = fitted(np.asarray(centre), np.asarray(median), rate)
    good = rows.number > 1.5
    spread = of_samples(inner[good], rows.number[good])
    # parts that change slowly against a row do not scatter inside it
    duration = float(np.median(rows.frame.count[good])) / rate if good.any() else 0.0
    slow = sum(v for v, m in zip(found.parts, MEMORIES_S, strict=True) if m > duration)
    quick = sum(found.parts) - slow
    return Mixture(max(found.white, spread - quick), found.parts, rate)
