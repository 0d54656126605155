"""The noise of a thermometer, by how its readings scatter about a smooth course, however often it reads."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from bench.mismatch.regression.slow_noise import scattered

RATE, ROW_S, SIGMA = 200, 2.0, 0.02


def problem(held_s: float, seconds: float, recordings: int = 40) -> Any:
    """Recordings of a temperature that rises, whose readings are held for so long."""
    rng = np.random.default_rng(1)
    y, within, number, recording = [], [], [], []
    size = round(ROW_S * RATE)
    for k in range(recordings):
        readings = SIGMA * rng.normal(size=round(seconds / held_s))
        samples = np.repeat(readings, round(held_s * RATE)) + 1e-3 * np.arange(round(seconds * RATE)) / RATE
        rows = samples[: samples.size // size * size].reshape(-1, size)
        y.append(rows.mean(axis=1))
        within.append(rows.var(axis=1))
        number.append(np.full(len(rows), float(size)))
        recording.append(np.full(len(rows), k))
    frame = SimpleNamespace(recording=np.concatenate(recording))
    rows_of_all = SimpleNamespace(
        y=np.concatenate(y), within=np.concatenate(within), number=np.concatenate(number), frame=frame
    )
    return cast("Any", SimpleNamespace(rows=rows_of_all, usable=np.ones(frame.recording.size, dtype=bool)))


@pytest.mark.parametrize("held_s", [1.0 / RATE, 0.1, 0.25, 0.5, 1.0])
@pytest.mark.parametrize("seconds", [30.0, 120.0])
def test_readings_that_are_held_are_as_noisy_as_others(held_s: float, seconds: float) -> None:
    floor, std = scattered(problem(held_s, seconds))
    assert floor == pytest.approx(SIGMA, rel=0.06)
    assert std is not None
    assert abs(floor - SIGMA) < 3.0 * max(std, 0.01 * SIGMA)


def test_a_temperature_that_does_not_scatter_has_no_noise() -> None:
    flat = problem(1.0, 30.0)
    flat.rows.y[:], flat.rows.within[:] = 20.0, 0.0
    assert scattered(flat)[0] < 1e-9 * SIGMA
