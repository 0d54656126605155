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
from bench.mismatch.recordings.split import quadratic
from bench.simulation.frame import FloatArray, Frame, IntArray

POINTS = ("constant_velocity", "validation")
"""kinds of recordings at one state in one direction, which are compared: a reversal or a ramp tells of several states,
and less of each
"""
ROWS = 200
"""rows of a recording from which its states are taken, spread over it"""
STAY = 0.5
"""share of the validation points that are held out in any case"""


def fitted_too(members: Sequence[Member], frame: Frame) -> tuple[list[Member], list[str]]:
    """Fit the validation points to which the fitted recordings would be extrapolated, the farthest first.

    After each of them the others are asked again. At least half of the points stay held out. ``frame`` holds rows of
    the channel compared. Return the members, and the names of those that are fitted now.
    """
    information = _information(members, frame)
    fitted = {m.index for m in members if not m.held_out and m.index in information}
    compared = {m.index for m in members if m.index in fitted and m.recording.kind in POINTS}
    points: dict[tuple[str, float, float, float], list[Member]] = {}
    for m in members:
        if m.held_out and m.recording.kind == "validation" and m.index in information:
            points.setdefault(m.point, []).append(m)
    spare = int((1.0 - STAY) * len(points))
    moved: list[Member] = []
    while compared and spare > 0:
        inverse = np.linalg.inv(
            sum((information[k] for k in fitted), start=np.eye(next(iter(information.values())).shape[0]))
        )
        leverage = {k: float(np.sum(one * inverse)) for k, one in information.items()}
        farthest = max(points, key=lambda p: max(leverage[m.index] for m in points[p]))
        if max(leverage[m.index] for m in points[farthest]) <= max(leverage[k] for k in compared):
            break
        out = points.pop(farthest)
        moved += out
        fitted |= {m.index for m in out}
        compared |= {m.index for m in out}
        spare -= 1
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
    states = frame.states[every] * np.array([1.0, 0.0, 1.0])
    states[:, 1] = np.abs(frame.velocity[every])
    spread = np.maximum(states.std(axis=0), 1e-9 * (1.0 + np.abs(states).max(axis=0)))
    basis = quadratic(*((states - states.mean(axis=0)) / spread).T)
    ahead = (frame.direction[every] > 0.0)[:, None]
    basis = np.hstack([basis * ahead, basis * ~ahead])
    ends = np.cumsum([0, *(found.size for found in rows.values())])
    parts = [basis[a:b] for a, b in itertools.pairwise(ends)]
    return {index: part.T @ part / len(part) for index, part in zip(rows, parts, strict=True)}


def _spread(rows: IntArray) -> IntArray:
    """At most ``ROWS`` of the rows, from the first to the last."""
    return rows if rows.size <= ROWS else rows[np.linspace(0, rows.size - 1, ROWS).astype(int)]
