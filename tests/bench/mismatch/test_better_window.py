"""The window of the rates, asked again with all that was found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.mismatch.better_window import LEAST_COMPARED, better_window, left, over, smoothed_over
from bench.mismatch.given import says_span, with_span
from bench.mismatch.prediction import predict
from bench.mismatch.recordings.loading import load
from bench.mismatch.run import run
from bench.simulation.model import Simulation
from tests.bench.importing import builders

CHANNELS = """
motor_angle = {variable = "q", unit = "rad"}
motor_torque = {variable = "M", unit = "N*m"}
"""
INERTIA = 0.2


def arm(folder: Path, noise: float, seconds: float = 12.0) -> Path:
    """Eight recordings of an arm whose encoder has ``noise`` (rad): inertia, friction, gravity."""
    rng = np.random.default_rng(6)
    rates, sizes = np.array([2.6, 4.9]), np.array([0.9, 0.5])
    for number in range(8):
        time = np.arange(round(200.0 * seconds)) / 200.0
        waves = rates * time[:, None] + rng.uniform(0.0, 6.0, 2)
        angle, speed = np.sin(waves) @ sizes, np.cos(waves) @ (rates * sizes)
        torque = -INERTIA * (np.sin(waves) @ (rates**2 * sizes)) + 0.1 * np.sign(speed) + 0.05 * speed
        torque += 1.5 * np.sin(angle) + rng.normal(0.0, 0.02, time.size)
        builders.csv(folder / f"a{number}.csv", t=time, q=angle + rng.normal(0.0, noise, time.size), M=torque)
    builders.run(folder, CHANNELS, file="*.csv")
    return folder / "out"


@pytest.mark.slow
def test_noise_that_is_little_of_an_acceleration_and_much_of_the_rest_asks_for_a_longer_window(tmp_path: Path) -> None:
    folder = arm(tmp_path, 6e-4)
    assert load(folder).folder.manner.smoothing == 0.06
    report = run(folder, tmp_path / "report")
    assert report.data.folder.manner.smoothing > 0.06
    assert any(
        "instead of 0.06 s: with what was found, less of the motor torque is left so" in n for n in report.data.notes
    )
    assert {f.effect for f in report.findings} == {"load.unbalance"}
    (outcome,) = report.outcomes
    after = outcome.rmse["after"]
    assert after is not None
    # as it was, 60 ms leave 0.2 N·m of the noise of the acceleration
    assert after < 0.06
    # the file says it, and is compared and predicts with it
    improved = Simulation.load(tmp_path / "report" / "model.json")
    assert says_span(improved) == report.data.folder.manner.smoothing
    again = run(folder, tmp_path / "again", tmp_path / "report" / "model.json")
    assert again.data.folder.manner.smoothing == report.data.folder.manner.smoothing
    assert again.findings == ()
    one = next(m for m in report.data.members if m.held_out).recording
    predicted = predict(improved, one)["motor_torque"]
    off = (one.si("motor_torque") - predicted)[100:-100]
    assert float(np.sqrt(np.median(off**2))) < 0.06


@pytest.mark.slow
def test_a_window_that_serves_is_kept(tmp_path: Path) -> None:
    folder = arm(tmp_path, 1e-6)
    report = run(folder, tmp_path / "report")
    assert report.data.folder.manner.smoothing <= 0.06
    assert not any("less of the motor torque is left so" in note for note in report.data.notes)


def test_only_samples_that_both_windows_compare_count() -> None:
    first = {0: (np.array([1.0, 1.0, 9.0, 1.0]), np.array([True, True, False, True]))}
    second = {0: (np.array([2.0, 2.0, 0.1, 2.0]), np.array([True, True, True, True]))}
    assert over(first, second) == float("inf")  # three of four are fewer than are asked for
    many = {0: (np.ones(40), np.ones(40, dtype=bool))}
    fewer = {0: (np.append(np.full(38, 2.0), [50.0, 50.0]), np.append(np.ones(38, dtype=bool), [False, False]))}
    assert LEAST_COMPARED * 40 <= 38
    assert over(many, fewer) == pytest.approx(0.5)
    assert over(fewer, many) == pytest.approx(2.0)
    assert over(many, {}) == float("inf")


@pytest.mark.parametrize("wrong", ["0.1", 0.0, -1.0, True, float("inf")])
def test_a_window_that_is_none_is_refused(wrong: object) -> None:
    model = Simulation.nominal()
    assert says_span(model) is None
    assert says_span(with_span(model, 0.12)) == 0.12
    term = with_span(model, 0.12).terms["motor.inertia"]
    with pytest.raises(ConfigurationError, match=r"'rates_smoothed_s': .* it should be a positive number of seconds"):
        says_span(model.with_term(replace(term, extra={"rates_smoothed_s": wrong})))


def test_where_the_motor_torque_is_not_said_nothing_is_asked(tmp_path: Path) -> None:
    data = load(arm(tmp_path, 1e-6, seconds=3.0))
    nominal = Simulation.nominal()
    assert left(data, nominal) is None
    assert better_window(data, nominal) is None
    assert better_window(replace(data, rows={}), nominal) is None
    assert smoothed_over(data, 0.5).folder.manner.smoothing == 0.5
