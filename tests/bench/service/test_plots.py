"""A recording as a page plots it: extremes, means and gaps are those of its samples, whatever stretch is looked at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.recording import Recording, Segment, write_recording
from bench.service.data.plots import plot
from tests.bench.recording.builders import SAMPLE_RATE, columns, header, specs

ROWS = 20_000
LOST = 7_000


@pytest.fixture
def path(tmp_path: Path) -> Path:
    data = columns(0, ROWS)
    data["load_torque"] = data["load_torque"].astype(np.int32)
    # after LOST rows half a second is missing; one sample is a spike
    data["time"] = np.where(np.arange(ROWS) < LOST, data["time"], data["time"] + 1000)
    data["load_torque"][12_345] = 30_000
    path = tmp_path / "p001-1.h5"
    spec = {one.name: one for one in specs()}
    write_recording(
        path, header(), {name: (data[name], spec[name]) for name in spec}, [Segment("steady", 0, ROWS)], accepted=True
    )
    return path


def channel(found: dict[str, Any], name: str, column: str) -> np.ndarray:
    return np.array([np.nan if value is None else value for value in found["channels"][name][column]])


def test_no_extreme_is_lost_and_the_mean_is_the_mean(path: Path) -> None:
    found, torque = plot(path), Recording.open(path).si("load_torque")
    low, mean, high = (channel(found, "load_torque", column) for column in ("low", "mean", "high"))
    assert np.nanmax(high) == pytest.approx(torque.max(), rel=1e-4)
    assert np.nanmin(low) == pytest.approx(torque.min(), rel=1e-4)
    spike = int(np.nanargmax(high))
    # one of some 25 samples: the mean of them is far from the middle of their extremes
    assert mean[spike] < low[spike] + 0.2 * (high[spike] - low[spike])
    assert np.nanmean(mean) == pytest.approx(torque.mean(), rel=1e-2)


def test_a_gap_stands_between_the_parts_before_and_after_it(path: Path) -> None:
    found = plot(path)
    time, mean = np.array(found["time"]), channel(found, "load_torque", "mean")
    (gap,) = np.flatnonzero(np.isnan(mean))
    assert found["gaps"] == 1
    assert time[gap] == pytest.approx((LOST + 500) / SAMPLE_RATE, abs=1e-3)
    assert time[gap - 1] < LOST / SAMPLE_RATE
    assert time[gap + 1] > (LOST + 1000) / SAMPLE_RATE
    assert np.all(np.diff(time) > 0.0)


def test_a_stretch_is_shown_in_its_own_detail(path: Path) -> None:
    found = plot(path, 1.0, 1.2)
    assert found["time"][0] == pytest.approx(1.0)
    assert found["time"][-1] == pytest.approx(1.2)
    # as many parts as samples: each is itself
    assert len(found["time"]) == 401
    torque = Recording.open(path).si("load_torque", 2000, 2401)
    np.testing.assert_allclose(channel(found, "load_torque", "mean"), torque, rtol=1e-4)
    assert found["gaps"] == 0
    assert plot(path, 1e6)["time"] == pytest.approx([(ROWS - 1 + 1000) / SAMPLE_RATE])
