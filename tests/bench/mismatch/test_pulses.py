"""A pulse's shape over the angle, fitted to noisy rows of all revolutions."""

from typing import Any

import numpy as np
import pytest

from bench.mismatch.peaks import Peak
from bench.mismatch.pulses import at, clusters, fitted
from bench.mismatch.rows import Rows
from bench.simulation.frame import ARRAYS, Frame

NOISE = 2e-6


def _rows(shape: np.ndarray, theta: np.ndarray, rng: np.random.Generator) -> Rows:
    fields: dict[str, Any] = {name: np.zeros(theta.size) for name in ARRAYS}
    fields["theta"] = theta
    fields["recording"] = np.zeros(theta.size, dtype=np.int64)
    return Rows(
        Frame(ratio=185.0, **fields),
        shape + NOISE * rng.normal(size=theta.size),
        np.full(theta.size, 4.0),
        np.zeros(theta.size),
    )


def _found(angle: float, width: float) -> Peak:
    return Peak("pulse", (), "constant", 200.0, angle=angle, width=width, height=1e-5)


@pytest.mark.parametrize("profile", ["triangle", "half_sine", "doublet"])
def test_shapes_that_are_no_gaussian_are_followed(profile: str) -> None:
    rng = np.random.default_rng(5)
    theta = np.tile(np.linspace(0.0, 2.0 * np.pi, 5000, endpoint=False), 12)
    x = (theta - 2.0) / 0.03
    shape = {
        "triangle": np.clip(1.0 - np.abs(x) / 1.8, 0.0, None),
        "half_sine": np.where(np.abs(x) < 1.5, np.cos(np.pi * x / 3.0), 0.0),
        "doublet": np.where(np.abs(x) < 2.0, np.sin(np.pi * x / 2.0), 0.0),
    }[profile]
    rows = _rows(2e-5 * shape, theta, rng)
    found = fitted([_found(2.005, 0.025)], rows, np.ones(theta.size, bool))
    left = 2e-5 * shape - at(found, theta)
    near = np.abs(x) < 3.0
    assert np.sqrt(np.mean(left[near] ** 2)) < 0.08 * np.sqrt(np.mean((2e-5 * shape[near]) ** 2))
    assert sum(p.gain for p in found) == pytest.approx(200.0)


def test_pulses_that_overlap_are_one_place() -> None:
    groups = clusters([_found(1.0, 0.02), _found(1.03, 0.02), _found(4.0, 0.02)])
    assert sorted(len(g) for g in groups) == [1, 2]
