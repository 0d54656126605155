"""How fast the load torque changes: waves that rows average out count, white noise does not."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.mismatch.recordings.swing import swing

RATE_HZ = 500.0
TIME = np.arange(0.0, 60.0, 1.0 / RATE_HZ)


def prepared(torque: np.ndarray, moving: np.ndarray | None = None) -> Any:
    direction = np.ones(TIME.size) if moving is None else moving.astype(np.float64)
    measured = SimpleNamespace(mean=torque, number=np.full(TIME.size, 4.0))
    return SimpleNamespace(
        frame=SimpleNamespace(direction=direction), measured={"load_torque": measured}, sample_rate=RATE_HZ
    )


@pytest.mark.parametrize("hertz", [26.0, 66.0])
@pytest.mark.parametrize("noise", [0.05, 0.3])
def test_it_is_the_mean_square_of_the_rate(hertz: float, noise: float) -> None:
    rng = np.random.default_rng(3)
    torque = 5.0 * np.sin(2.0 * np.pi * hertz * TIME) + noise * rng.normal(size=TIME.size)
    true = 0.5 * (5.0 * 2.0 * np.pi * hertz) ** 2
    # by how much white noise of so many bins scatters about its level
    scatter = noise**2 * RATE_HZ**2 * 4.0 / np.sqrt(TIME.size)
    assert swing(prepared(torque)) == pytest.approx(true, rel=0.05, abs=10.0 * scatter)


@pytest.mark.parametrize("seed", range(4))
def test_noise_alone_does_not_swing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    of_noise = (0.3 * RATE_HZ) ** 2
    assert swing(prepared(0.3 * rng.normal(size=TIME.size))) < 0.01 * of_noise


def test_what_rows_show_is_theirs() -> None:
    rng = np.random.default_rng(5)
    slow = 5.0 * np.sin(2.0 * np.pi * 2.0 * TIME) + 0.05 * rng.normal(size=TIME.size)
    true = 0.5 * (5.0 * 2.0 * np.pi * 2.0) ** 2
    assert swing(prepared(slow)) < 0.01 * true


def test_only_motion_counts() -> None:
    torque = 5.0 * np.sin(2.0 * np.pi * 26.0 * TIME)
    half = TIME < 30.0
    assert swing(prepared(np.where(half, torque, 0.0), half)) == pytest.approx(swing(prepared(torque)), rel=0.05)
    assert swing(prepared(torque, np.zeros(TIME.size, dtype=bool))) == 0.0
