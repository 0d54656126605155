"""Validation points to which the simulation would have to be extrapolated: they are fitted, not held out.

The simulation's polynomials of load, speed and temperature (ten columns for each direction) are known there less than
at any fitted point. What is left then says how uncertain they are, not whether physics is missing. A point is such a
one if its leverage in the regression that the fitted recordings make is larger than that of every fitted point: it lies
outside the ellipsoid that holds all of these (hidden extrapolation; Montgomery, Peck and Vining, Introduction to Linear
Regression Analysis, section 3.8). Of a campaign with few recordings most new points are, for ten columns are many then.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch.recordings.dataset import Member
from bench.mismatch.recordings.split import Point
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.polynomial import TERM_COUNT, Standardisation

POINTS = ("constant_velocity", "validation")
"""kinds of recordings at one state in one direction, which are compared: a reversal or a ramp tells of several states,
and less of each
"""
ROWS = 200
"""rows of a recording from which its states are taken, spread over it"""
COLUMNS = 2 * TERM_COUNT
"""of the polynomials of both directions"""
STAY = 0.5
"""share of the validation points that are held out in any case"""


def fitted_too(members: Sequence[Member], frame: Frame) -> tuple[list[Member], list[str]]:
    """Fit the validation points to which the fitted recordings would be extrapolated, the farthest first.

    After each of them the others are asked again. At least half of the points stay held out. ``frame`` holds rows of
    the channel compared. Return the members, and the names of those that are fitted now.
    """
    information = _information(members, frame)
    known = [m for m in members if m.index in information]
    fitted = [m for m in known if not m.held_out]
    points: dict[Point, list[Member]] = {}
    for m in known:
        if m.held_out and m.recording.kind == "validation":
            points.setdefault(m.point, []).append(m)
    moved: list[Member] = []
    for _ in range(int((1.0 - STAY) * len(points))):
        inverse = np.linalg.inv(sum((information[m.index] for m in (*fitted, *moved)), start=np.eye(COLUMNS)))
        leverage = {index: float(np.sum(one * inverse)) for index, one in information.items()}
        compared = [leverage[m.index] for m in (*fitted, *moved) if m.recording.kind in POINTS]
        farthest = max(points, key=lambda p: max(leverage[m.index] for m in points[p]))
        if not compared or max(leverage[m.index] for m in points[farthest]) <= max(compared):
            break
        moved += points.pop(farthest)
    fold = max((m.fold for m in members), default=-1)
    folds = {point: fold + 1 + k for k, point in enumerate(dict.fromkeys(m.point for m in moved))}
    chosen = {m.index for m in moved}
    changed = [replace(m, held_out=False, fold=folds[m.point]) if m.index in chosen else m for m in members]
    return changed, [m.name for m in moved]


def _information(members: Sequence[Member], frame: Frame) -> dict[int, FloatArray]:
    """What each recording says of a quadratic polynomial of torque, speed and temperature in each direction: the mean
    over its rows in motion of the outer product of the regressors (20, 20), by its index.
    """
    usable = (frame.direction != 0.0) & np.isfinite(frame.states).all(axis=1)
    rows = {m.index: _spread(np.flatnonzero((frame.recording == m.index) & usable)) for m in members}
    rows = {index: found for index, found in rows.items() if found.size}
    if not rows:
        return {}
    every = np.concatenate(list(rows.values()))
    inputs = frame.torque[every], np.abs(frame.velocity[every]), frame.temperature[every]
    basis = Standardisation.of(*inputs).basis(*inputs)
    ahead = (frame.direction[every] > 0.0)[:, None]
    columns = np.hstack([basis * ahead, basis * ~ahead])
    ends = np.cumsum([0, *(found.size for found in rows.values())])
    parts = [columns[a:b] for a, b in itertools.pairwise(ends)]
    return {index: part.T @ part / len(part) for index, part in zip(rows, parts, strict=True)}


def _spread(rows: IntArray) -> IntArray:
    """At most ``ROWS`` of the rows, from the first to the last."""
    return rows if rows.size <= ROWS else rows[np.linspace(0, rows.size - 1, ROWS).astype(int)]
