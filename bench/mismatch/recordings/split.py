"""Which recordings are held out: whole operating points that others spare, and the validation points."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from bench.mismatch.recordings.pieces import Piece
from bench.recording import Recording

Point = tuple[str, float, float, float]
HELD_OUT_SHARE = 0.2
FEWEST_OF_A_KIND = 6
"""kinds with fewer recordings (heatings, reversals, ramps) all train: each of them is too telling to be spared"""
HELD_OUT_BESIDE_VALIDATION = 0.1
COARSEST_LOAD = 1.0
"""N·m (N) within which two load torques are one operating point, on a bench of hundreds of them"""
FINEST_SHARE = 0.01
"""the same as a share of the largest load, where that is less"""
FEWEST_POINTS = 3
"""operating points of a kind from which one can be spared"""
_Point = tuple[str, float, float, float, int]
"""a point, and the number of the recording where that is a point by itself, else ``REPEATED``"""
REPEATED = -1


def load_step(recordings: Sequence[Recording]) -> float:
    """N·m (N) within which two load torques are one operating point: a whole one, and a hundredth of the largest load
    where that is less, as a small servo's are.
    """
    loads = [abs(r.setpoint.load_torque) for r in recordings if np.isfinite(r.setpoint.load_torque)]
    largest = max(loads, default=0.0)
    return min(COARSEST_LOAD, FINEST_SHARE * largest) if largest > 0.0 else COARSEST_LOAD


def point_of(recording: Recording, step: float) -> Point:
    """The operating point of a recording: kind, load torque within ``step``, velocity and temperature, rounded."""
    setpoint = recording.setpoint
    clean = [v if np.isfinite(v) else 0.0 for v in (setpoint.load_torque, setpoint.velocity, setpoint.temperature)]
    return recording.kind, round(clean[0] / step) * step, round(clean[1], 4), round(clean[2] / 4.0)


def _named(recording: Recording) -> bool:
    """Whether a recording says what it was set to."""
    setpoint = recording.setpoint
    return any(np.isfinite(v) for v in (setpoint.load_torque, setpoint.velocity, setpoint.temperature))


def _points(recordings: Sequence[Recording]) -> list[_Point]:
    step = load_step(recordings)
    return [(*point_of(r, step), REPEATED if _named(r) else number) for number, r in enumerate(recordings)]


def none_spared(recordings: Sequence[Recording]) -> str:
    """Say why no recording is held out, where :func:`split` holds none."""
    points = _points(recordings)
    kinds = {kind: {p for p in points if p[0] == kind} for kind in dict.fromkeys(p[0] for p in points)}
    listed = ", ".join(
        f"{sum(p[0] == kind for p in points)} recordings of kind '{kind}' at {len(members)} operating"
        f" point{'s' if len(members) > 1 else ''}"
        for kind, members in kinds.items()
    )
    return (
        f"nothing could be held out: {listed}; it takes {FEWEST_OF_A_KIND} recordings of a kind at {FEWEST_POINTS}"
        " points, and recordings of one setpoint are one point (without a setpoint each is one by itself)"
    )


def split(recordings: Sequence[Recording]) -> tuple[list[bool], list[int]]:
    """Choose held-out recordings by whole operating points, and a fold for each of the others.

    Validation points are held out (:mod:`bench.mismatch.recordings.extrapolated` says which of them are fitted after
    all). Of the other kinds a fifth of the points is (a tenth of the constant-velocity points where there are five
    validation points or more), spread evenly along the campaign, of each stretch the one that the others spare best,
    and none of a kind that has fewer than six recordings. A recording that names no setpoint (most imported ones) is a
    point by itself: nothing says that it repeats another.
    """
    points = _points(recordings)
    held: list[bool] = [r.kind == "validation" for r in recordings]
    validation = sum(held)
    if all(held):
        held = [i % 3 == 1 for i in range(len(held))]
    kinds: dict[str, list[_Point]] = {}
    for i, point in enumerate(points):
        if not held[i] and point not in kinds.setdefault(point[0], []):
            kinds[point[0]].append(point)
    chosen: set[_Point] = set()
    for kind, members in kinds.items():
        count = sum(1 for i, p in enumerate(points) if p[0] == kind and not held[i])
        if count < FEWEST_OF_A_KIND or len(members) < FEWEST_POINTS:
            continue
        # repeats of a point tell the noise: points with repeats stay in training
        single = [p for p in members if sum(q == p for q in points) == 1 or len(members) < 6]
        enough = kind == "constant_velocity" and validation >= 5
        share = HELD_OUT_BESIDE_VALIDATION if enough else HELD_OUT_SHARE
        number = max(1, round(share * len(members)))
        # where too few stand alone, some go with their repeats
        chosen.update(_spread(single if len(single) >= max(number, 3) else members, number))
    held = [h or points[i] in chosen for i, h in enumerate(held)]
    folds: dict[_Point, int] = {}
    fold = [folds.setdefault(points[i], len(folds)) if not held[i] else -1 for i in range(len(points))]
    return held, fold


def _spread(members: Sequence[_Point], number: int) -> list[_Point]:
    """A number of points, one of each stretch of the campaign: the one that those left in training spare best."""
    pool = list(members)
    ends = [round(k * len(pool) / number) for k in range(number + 1)]
    out: list[_Point] = []
    for first, last in itertools.pairwise(ends):
        alone = _leverage([p for p in pool if p not in out])
        out.append(min(pool[first:last], key=lambda p: (alone[p], p)))
    return out


def _leverage(points: Sequence[_Point]) -> dict[_Point, float]:
    """How far each point speaks for itself alone, 0 to 1, where torque, speed and temperature act by a quadratic
    polynomial in each direction (bench-physics, "Nominal simulation"): leverages of that regression (Hoaglin and
    Welsch, The American Statistician 32 (1978) 17), with a prior as heavy as a point.
    """
    states = np.array([[p[1], abs(p[2]), p[3]] for p in points])
    spread = np.maximum(states.std(axis=0), 1e-9 * (1.0 + np.abs(states).max(axis=0)))
    a, b, c = ((states - states.mean(axis=0)) / spread).T
    basis = np.column_stack([np.ones(len(points)), a, b, c, a * a, b * b, c * c, a * b, a * c, b * c])
    forward = np.array([p[2] >= 0.0 for p in points])
    out = np.zeros(len(points))
    for side in (forward, ~forward):
        rows = basis[side]
        out[side] = np.einsum("ni,ij,nj->n", rows, np.linalg.inv(rows.T @ rows + np.eye(rows.shape[1])), rows)
    return dict(zip(points, out.tolist(), strict=True))


HELD_OUT_BLOCK = 4
"""every fourth block of a folder that has too few recordings to hold any out"""


def split_blocks(pieces: Sequence[Piece]) -> tuple[list[bool], list[int]]:
    """Held-out blocks where recordings are cut: the validation recordings, else every fourth block; a fold a block."""
    held = [piece.recording.kind == "validation" for piece in pieces]
    if not any(held) or all(held):
        held = [number % HELD_OUT_BLOCK == HELD_OUT_BLOCK - 2 for number in range(len(pieces))]
    return held, [-1 if out else number for number, out in enumerate(held)]
