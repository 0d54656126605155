"""Orders of a joint that never turns its output round, in the transmission error and in the motor torque."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.mismatch.discovery import AMBIGUOUS, NAMED
from bench.mismatch.orders import reported_swings
from bench.mismatch.orders.swings import PERIODS, borne_out, bounds, evaluated, search
from bench.mismatch.recordings.rows import Rows
from bench.mismatch.run import run
from bench.simulation.frame import FloatArray, Frame
from tests.bench.importing import builders
from tests.bench.mismatch.regression.test_free_motion import swinging

NOISE = 0.01
ROWS = 4000


def swings(size: float = 0.7, ratio: float = 50.0, seed: int = 1) -> Frame:
    """Six recordings of sines, each a few tenths of a revolution."""
    frame = swinging(pieces=6, size=size).take(np.sort(np.random.default_rng(seed).integers(0, 600, ROWS)))
    time = np.linspace(0.0, 60.0, ROWS)
    angle = size * np.sin(0.9 * time) + 0.3 * size * np.sin(2.3 * time)
    speed = np.gradient(angle, time)
    return replace(
        frame,
        ratio=ratio,
        recording=np.repeat(np.arange(6), ROWS // 6 + 1)[:ROWS],
        time=time,
        theta=angle,
        q=angle,
        velocity=speed,
        direction=np.sign(speed),
        step=np.full(ROWS, time[1] - time[0]),
        count=np.full(ROWS, 1.0),
    )


def rows_of(frame: Frame, y: FloatArray) -> Rows:
    return Rows(frame, y, np.full(frame.size, 3.0))


def noise(frame: Frame, seed: int = 3) -> FloatArray:
    return np.random.default_rng(seed).normal(0.0, NOISE, frame.size)


EVERY = np.ones(ROWS, dtype=bool)


def test_an_order_of_the_shaft_and_one_of_the_output_are_found_with_their_sizes() -> None:
    frame = swings()
    y = 0.02 * np.cos(50.0 * frame.theta) + 0.008 * np.sin(37.0 * frame.theta) + noise(frame)
    found = search(rows_of(frame, y), y, EVERY)
    assert [(o.wave.order, o.of_shaft) for o in found] == [(50.0, True), (37.0, False)]
    assert found[0].wave.cosine == pytest.approx(0.02, abs=4.0 * (found[0].wave.cosine_std or 0.0))
    assert found[1].wave.sine == pytest.approx(0.008, abs=4.0 * (found[1].wave.sine_std or 0.0))
    assert found[0].p_value < 1e-6
    left = y - evaluated(found, rows_of(frame, y))
    assert np.std(left) == pytest.approx(NOISE, rel=0.05)


@pytest.mark.parametrize("seed", range(6))
def test_noise_and_what_changes_slowly_have_no_order(seed: int) -> None:
    frame = swings(seed=seed)
    y = noise(frame, seed) + 0.1 * frame.q**2 + 0.05 * np.tanh(4.0 * frame.q)
    assert search(rows_of(frame, y), y, EVERY) == ()


def test_rows_that_average_an_order_out_do_not_make_it_smaller() -> None:
    """Each row is a mean over what it turns through: half a period of the order where it is fast."""
    frame = swings(size=1.4)
    turned = np.abs(frame.velocity) * frame.step
    order = float(round(np.pi / turned.max()))
    y = 0.02 * np.sinc(order * turned / (2.0 * np.pi)) * np.cos(order * frame.theta) + noise(frame)
    (found,) = search(rows_of(frame, y), y, EVERY)
    assert found.wave.order == order
    assert found.wave.cosine == pytest.approx(0.02, abs=4.0 * (found.wave.cosine_std or 0.0))


def test_an_order_that_recordings_held_out_do_not_have_is_not_told() -> None:
    """It stands in the first five of six recordings with one phase, in the last with the other."""
    frame = swings()
    held = frame.recording == 5
    y = 0.02 * np.where(held, -1.0, 1.0) * np.cos(50.0 * frame.theta) + 0.02 * np.sin(37.0 * frame.theta)
    rows = rows_of(frame, y + noise(frame))
    found = search(rows, rows.y, ~held)
    assert {o.wave.order for o in found} == {50.0, 37.0}
    assert [o.wave.order for o in borne_out(found, rows, rows.y, held)] == [37.0]
    assert borne_out(found, rows, rows.y, ~EVERY) == found


def test_where_too_few_orders_tell_the_noise_none_is_asked() -> None:
    frame = swings(size=0.7).take(np.arange(0, ROWS, 40))
    assert bounds(frame) is None
    y = 0.05 * np.cos(30.0 * frame.theta)
    assert search(rows_of(frame, y), y, EVERY[: frame.size]) == ()


@pytest.mark.parametrize("turns", [0, 5, 20, 3000])
def test_recordings_that_begin_turns_apart_tell_the_same_orders(turns: int) -> None:
    frame = swings()
    theta = frame.theta + 2.0 * np.pi * turns * frame.recording
    y = 0.02 * np.cos(50.0 * theta) + 0.008 * np.sin(37.0 * theta) + noise(frame)
    apart = replace(frame, theta=theta)
    found = search(rows_of(apart, y), y, EVERY)
    assert [o.wave.order for o in found] == [50.0, 37.0]
    assert found[0].wave.cosine == pytest.approx(0.02, abs=4.0 * (found[0].wave.cosine_std or 0.0))


@pytest.mark.parametrize("order", [52.4, 73.5])
def test_an_order_between_two_whole_ones_is_told_where_it_is(order: float) -> None:
    frame = swings()
    y = 0.02 * np.cos(order * frame.theta + 0.7) + noise(frame)
    (found,) = search(rows_of(frame, y), y, EVERY)
    assert found.wave.order == pytest.approx(order, abs=4.0 * found.std)
    assert 0.0 < found.std < 0.3
    assert not found.of_shaft
    assert np.hypot(found.wave.cosine, found.wave.sine) == pytest.approx(0.02, rel=0.1)


def test_amplitudes_of_orders_that_rows_average_scatter_by_what_is_said_of_them() -> None:
    frame = swings(size=1.4)
    turned = np.abs(frame.velocity) * frame.step
    order = float(round(np.pi / turned.max()))
    kept = np.sinc(order * turned / (2.0 * np.pi))
    off = []
    for seed in range(30):
        y = 0.02 * kept * np.cos(order * frame.theta) + noise(frame, seed)
        (found,) = search(rows_of(frame, y), y, EVERY)
        off.append((found.wave.cosine - 0.02) / (found.wave.cosine_std or 1.0))
    assert 0.7 < float(np.std(off)) < 1.35


@pytest.mark.parametrize("varies", [True, False])
def test_what_may_as_well_be_a_tone_is_no_order(varies: bool) -> None:
    """Of a motion at one speed nothing tells an order from a tone; of one that varies both are told apart."""
    frame = swings()
    time = np.linspace(0.0, 60.0, ROWS)
    if not varies:
        angle = 0.3 * (time % 10.0) - 1.5
        frame = replace(frame, theta=angle, q=angle, velocity=np.full(ROWS, 0.3), direction=np.ones(ROWS))
    y = 0.02 * np.cos(50.0 * frame.theta) + noise(frame)
    assert [o.wave.order for o in search(rows_of(frame, y), y, EVERY)] == ([50.0] if varies else [])
    tone = 0.02 * np.cos(2.0 * np.pi * 3.1 * time) + noise(frame)
    assert search(rows_of(frame, tone), tone, EVERY) == ()


def test_the_longest_swing_and_the_rows_bound_the_orders() -> None:
    frame = swings()
    lowest, highest = bounds(frame) or (0.0, 0.0)
    longest = max(float(np.ptp(frame.theta[frame.recording == k])) for k in range(6))
    assert lowest * longest == pytest.approx(2.0 * np.pi * PERIODS)
    assert highest * float(np.median(np.abs(np.diff(frame.theta)))) < np.pi
    assert bounds(frame.take(np.arange(20))) is None
    assert bounds(replace(frame, theta=np.zeros(ROWS))) is None


def test_an_order_of_the_shaft_may_be_the_encoders_and_one_of_the_output_may_not() -> None:
    frame = swings()
    y = 0.02 * np.cos(50.0 * frame.theta) + 0.02 * np.sin(37.0 * frame.theta) + noise(frame)
    rows = rows_of(frame, y)
    shaft, output = reported_swings.discoveries(search(rows, y, EVERY), rows, rows.number, NOISE, ())
    assert (shaft.effect, shaft.status, shaft.orders) == ("te.harmonic", AMBIGUOUS, (50.0,))
    assert [(a.effect, a.as_good) for a in shaft.alternatives] == [("sensor.motor_encoder", True)]
    assert (output.effect, output.status, output.orders) == ("te.harmonic", NAMED, (37.0,))
    assert reported_swings.discoveries(search(rows, y, EVERY), rows, rows.number, 1.0, ()) == []


@pytest.mark.parametrize(
    ("ratio", "order", "effect"),
    [
        (1.0, 42.0, "motor.torque_ripple"),
        (7.0, 42.0, "motor.torque_ripple"),
        (7.0, 35.0, "unknown"),
        (9.0, 40.0, "unknown"),
    ],
)
def test_ripple_of_the_motor_stands_at_multiples_of_six_turns(ratio: float, order: float, effect: str) -> None:
    frame = swings(ratio=ratio)
    y = 0.02 * np.cos(order * frame.theta) + noise(frame)
    rows = rows_of(frame, y)
    (found,) = reported_swings.of_torque(search(rows, y, EVERY), rows, rows.number, NOISE)
    assert found.effect == effect
    assert found.orders == (order,)
    values = {str(p["symbol"]): p["value"] for p in found.parameters}
    assert values["a_r"] == pytest.approx(0.02, rel=0.1)
    assert values["n"] == pytest.approx(order / ratio)


@pytest.mark.slow
def test_a_joint_with_two_encoders_that_swings_shows_what_its_motors_encoder_misreads(tmp_path: Path) -> None:
    """Seven recordings of a third of a revolution: windup by the load, a magnet off centre, and the right held-out
    error of the file that is written.
    """

    rng = np.random.default_rng(11)
    for number in range(7):
        time = np.arange(2400) / 100.0
        angle = (0.8 + 0.05 * number) * np.sin(0.7 * time + number) + 0.2 * np.sin(2.1 * time)
        torque = 6.0 * np.sin(0.45 * time + number)
        error = 4e-4 * np.sin(30.0 * angle + 0.3) - 2e-4 * torque / 6.0 + rng.normal(0.0, 1e-4, time.size)
        builders.csv(
            tmp_path / f"a{number}.csv",
            t=time,
            q=30.0 * angle,
            p=angle + error,
            L=torque,
            M=torque / 30.0 + 0.02 * np.sign(np.cos(0.7 * time + number)) + rng.normal(0.0, 0.01, time.size),
        )
    channels = """
motor_angle = {variable = "q", unit = "rad"}
load_angle = {variable = "p", unit = "rad"}
load_torque = {variable = "L", unit = "N*m"}
motor_torque = {variable = "M", unit = "N*m"}
"""
    imported = builders.run(tmp_path, channels, file="*.csv", ratio=30.0)
    assert len(imported) == 7
    folder = imported[0].recording.path.parent  # type: ignore[union-attr]
    run(folder, tmp_path / "report")
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    (found,) = [f for f in report["findings"] if f["channel"] == "transmission_error"]
    assert found["effect"] == "te.harmonic"
    assert found["status"] == "ambiguous"
    values = {p["symbol"]: p["value"] for p in found["parameters"]}
    assert values["f"] == 30.0
    assert values["a"] == pytest.approx(4e-4, rel=0.05)
    channel = next(c for c in report["channels"] if c["channel"] == "transmission_error")
    assert channel["held_out_rmse_after"] == pytest.approx(1e-4, rel=0.1)
    assert channel["held_out_rmse_before"] > 2.5e-4


@pytest.mark.slow
def test_low_orders_of_unsteady_motion_stand_in_the_file_with_their_sizes(tmp_path: Path) -> None:
    """More than a revolution to and fro, never at a steady speed: what is found is predicted, and found no more."""
    rng = np.random.default_rng(12)
    for number in range(7):
        time = np.arange(3000) / 100.0
        angle = (3.8 + 0.1 * number) * np.sin(0.4 * time + number) + 0.3 * np.sin(1.3 * time)
        load = 5.0 * np.sin(0.9 * time + number)
        error = 3e-4 * np.cos(2.0 * angle) + 2e-4 * np.sin(31.0 * angle) - 3e-5 * load
        error += rng.normal(0.0, 1e-4, time.size)
        driven = load / 12.0 + 0.02 * np.sign(np.gradient(angle)) + rng.normal(0.0, 0.01, time.size)
        builders.csv(tmp_path / f"a{number}.csv", t=time, q=12.0 * angle, p=angle + error, L=load, M=driven)
    channels = """
motor_angle = {variable = "q", unit = "rad"}
load_angle = {variable = "p", unit = "rad"}
load_torque = {variable = "L", unit = "N*m"}
motor_torque = {variable = "M", unit = "N*m"}
"""
    builders.run(tmp_path, channels, file="*.csv", ratio="12.0")
    first, second = tmp_path / "first", tmp_path / "second"
    run(tmp_path / "out", first)
    run(tmp_path / "out", second, first / "model.json")

    def of_te(folder: Path) -> tuple[list[dict[str, Any]], float]:
        report = json.loads((folder / "report.json").read_text())
        channel = next(c for c in report["channels"] if c["channel"] == "transmission_error")
        found = [f for f in report["findings"] if f["channel"] == "transmission_error"]
        return found, float(channel["held_out_rmse_after"])

    (found,), left = of_te(first)
    assert found["effect"] == "te.harmonic"
    assert {31.0, 2.0} <= set(found["location"]["orders"])
    assert left == pytest.approx(1e-4, rel=0.1)
    again, left_again = of_te(second)
    assert again == []
    assert left_again == pytest.approx(left, rel=0.05)
