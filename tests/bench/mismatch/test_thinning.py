"""Groups of samples: no mean and no scatter is lost, and a recording at 2 kHz says the same with and without them."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.mismatch.recordings import thinning as module
from bench.mismatch.recordings.loading import load
from bench.mismatch.recordings.read_again import runs_of
from bench.mismatch.recordings.thinning import Thinning, group_of
from bench.mismatch.recordings.vibration import density_of
from bench.recording import write_recording
from bench.recording.header import ChannelSpec, Gearbox, RecordingHeader, Segment, Setpoint

RATE = 2000.0


@pytest.mark.parametrize(
    ("rate", "span", "group"),
    [(500.0, 0.06, 1), (1000.0, 0.06, 2), (2000.0, 0.06, 4), (2000.0, 0.015, 1), (1000.0, 0.015, 1), (100.0, 0.06, 1)],
)
def test_a_window_keeps_thirty_samples(rate: float, span: float, group: int) -> None:
    assert group_of(rate, span) == group


@given(st.integers(1, 6), st.integers(7, 60), st.integers(0, 2**32 - 1))
def test_means_and_squares_add_up(group: int, size: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    signal, valid = rng.normal(3.0, 1.0, size), rng.random(size) > 0.2
    told = Thinning(group).measured(signal, valid)
    kept = signal[: size // group * group][valid[: size // group * group]]
    assert told.number.sum() == kept.size
    mean = np.sum(told.mean * told.number) / max(told.number.sum(), 1)
    assert mean == pytest.approx(kept.mean() if kept.size else 0.0, abs=1e-12)
    squares = np.sum(told.number * (told.mean - mean) ** 2) + told.scatter.sum()
    assert squares == pytest.approx(np.sum((kept - mean) ** 2), abs=1e-9)


def test_products_inside_groups() -> None:
    rng = np.random.default_rng(2)
    one, other = rng.normal(size=12), rng.normal(size=12)
    valid = np.ones(12, dtype=bool)
    valid[5] = False
    inner = Thinning(4).inner(one, other, valid)
    rows = [4, 6, 7]
    expected = np.sum((one[rows] - one[rows].mean()) * (other[rows] - other[rows].mean()))
    assert inner[1] == pytest.approx(expected)
    assert Thinning(1).inner(one, other, valid).sum() == 0.0


def test_values_of_groups_go_back_to_samples() -> None:
    assert Thinning(3).spread(np.array([1.0, 2.0]), 8).tolist() == [1, 1, 1, 2, 2, 2, 2, 2]


def _write(folder: Path, number: int) -> None:
    rng = np.random.default_rng(number)
    n = int(30 * RATE) + 3
    time = np.arange(n) / RATE
    speed = 0.15 * (-1.0) ** number
    theta = speed * time
    motor = 185.0 * theta
    torque = 0.54 + 0.5 * np.sign(speed) + 0.05 * np.cos(24 * motor) + rng.normal(0, 0.02, n)
    torque += 0.03 * np.sin(2 * np.pi * 37.0 * time)
    torque[1000] += 40.0  # a wild sample
    values = {
        "time": time,
        "motor_angle": np.floor(motor * 8192 / (2 * np.pi)) * 2 * np.pi / 8192,
        "load_angle": theta - 100.0 / 4e6 + 2e-5 * np.sin(276 * theta) + rng.normal(0, 2e-6, n),
        "motor_torque": torque,
        "load_torque": 100.0 + 8.0 * np.sign(speed) + rng.normal(0, 1.0, n),
        "load_motor_torque": np.full(n, 100.0),
        "temperature": 25.0 + rng.normal(0, 0.01, n),
    }
    header = RecordingHeader(
        recording_id=f"r{number}",
        campaign_id="c",
        kind="constant_velocity",
        started_at=datetime(2026, 1, 1, 0, number, tzinfo=UTC),
        sample_rate=RATE,
        source="emulator",
        setpoint=Setpoint(100.0, speed, 25.0),
        gearbox=Gearbox(185.0, 24, 96, 45, 46),
        zero_id="z",
    )
    channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
    write_recording(folder / f"r{number}.h5", header, channels, [Segment("steady", 0, n)], [])


def test_a_recording_at_2_khz_says_the_same_in_groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(6):
        _write(tmp_path, number)
    grouped = load(tmp_path)
    monkeypatch.setattr(module, "SAMPLES_A_WINDOW", 1e9)
    whole = load(tmp_path)
    for channel in ("motor_torque", "load_torque"):
        # samples that make no group at the end, and the wild ones
        assert grouped.rows[channel].number.sum() == pytest.approx(whole.rows[channel].number.sum(), rel=2e-3)
        means = [np.average(d.rows[channel].y, weights=d.rows[channel].number) for d in (grouped, whole)]
        assert means[0] == pytest.approx(means[1], rel=2e-3)
    # inside rows over the angle a fast order leans on the angle: groups keep that, too
    angles = [d.rows["transmission_error"] for d in (grouped, whole)]
    slopes = [np.sum(r.lean * r.number) / np.sum(r.sweep * r.number) for r in angles]
    assert slopes[0] == pytest.approx(slopes[1], rel=0.05, abs=2e-5)
    # ripple and tones are read from the samples themselves
    order = [np.array([s.amplitude[24] for s in d.shaft]) for d in (grouped, whole)]
    assert np.abs(order[0] - order[1]).max() < 2e-4
    assert np.abs(order[0]).min() > 0.04
    heard = [d.density["motor_torque"] for d in (grouped, whole)]
    assert len(heard[0]) == len(heard[1])
    for one, other in zip(*heard, strict=True):
        assert np.median(one.power) == pytest.approx(np.median(other.power), rel=0.02)
    # and are the same when some recordings are read again
    again = [density_of(run) for run in runs_of(grouped, "motor_torque", [4, 1])]
    assert [one.recording for one in again if one is not None] == [1, 4]
    for one, number in zip(again, (1, 4), strict=True):
        assert one is not None
        assert one.power == pytest.approx(heard[0][number].power, rel=1e-4)
