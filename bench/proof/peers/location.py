"""Location of a peer's columns: peers report none, so it is computed for them as the report's page defines it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.proof.peers.candidates import Floats, Problem

_SHARE = 0.9
_RANGES = ("velocity", "load_torque", "temperature")
_STRONGEST = 3


def location_of(problem: Problem, picked: NDArray[np.int64], effect: str) -> dict[str, Any]:
    """Conditions and strongest recordings of what one effect's columns add, after a fit with all that were picked."""
    if not problem.states:
        return {"conditions": {}, "recordings": []}
    train = problem.train
    x = problem.columns[:, picked]
    weights = np.linalg.lstsq(x[train], problem.y[train], rcond=None)[0]
    mine = np.array([problem.effects[i] == effect for i in picked])
    energy = problem.states["weight"] * (x[:, mine] @ weights[mine]) ** 2
    forward = float(energy[problem.states["direction"] > 0.0].sum()) / max(float(energy.sum()), 1e-300)
    direction = "positive" if forward > 0.95 else "negative" if forward < 0.05 else "both"
    conditions: dict[str, Any] = {name: narrowest(problem.states[name], energy) for name in _RANGES}
    sums = np.bincount(problem.recording, weights=energy, minlength=len(problem.names))
    strongest = [problem.names[i] for i in np.argsort(-sums)[:_STRONGEST]]
    return {"conditions": conditions | {"direction": direction}, "recordings": strongest}


def narrowest(values: Floats, energy: Floats) -> list[float]:
    """The shortest [low, high] of ``values`` (M,) that holds nine tenths of the energy (M,)."""
    order = np.argsort(values, kind="stable")
    x, sums = values[order], np.append(0.0, np.cumsum(energy[order]))
    stops = np.searchsorted(sums, sums[:-1] + (_SHARE - 1e-12) * sums[-1])
    starts = np.flatnonzero(stops <= x.size)
    best = starts[int(np.argmin(x[stops[starts] - 1] - x[starts]))]
    return [float(x[best]), float(x[stops[best] - 1])]
