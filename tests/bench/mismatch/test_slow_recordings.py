"""A warm-up that was recorded every other second."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from bench.mismatch.recordings.swing import swing
from bench.simulation.terms import LOAD_TORQUE


@pytest.mark.parametrize(("rate", "seen"), [(0.5, False), (5.0, False), (500.0, True)])
def test_waves_are_averaged_out_of_rows_only_where_samples_are_quicker(rate: float, seen: bool) -> None:
    time = np.arange(int(60.0 * rate)) / rate
    torque = 20.0 * np.sin(2.0 * np.pi * 40.0 * time) + np.random.default_rng(0).normal(size=time.size)
    frame = SimpleNamespace(direction=np.ones(time.size))
    measured = SimpleNamespace(mean=torque, number=np.ones(time.size))
    prepared = SimpleNamespace(frame=frame, measured={LOAD_TORQUE: measured}, sample_rate=rate)
    rate_of_change = swing(prepared)  # type: ignore[arg-type]
    expected = 0.5 * (20.0 * 2.0 * np.pi * 40.0) ** 2
    assert rate_of_change == (pytest.approx(expected, rel=0.1) if seen else 0.0)
