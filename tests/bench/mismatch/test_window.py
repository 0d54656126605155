"""The window of rates, where nobody set the speed: as the torque asks for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.importing import Imported
from bench.mismatch.recordings.loading import load
from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder, prepare
from bench.mismatch.recordings.rows import LIVELY_S
from bench.mismatch.recordings.window import ANGLE, RECORDED, VELOCITY, Rates, best_rates
from bench.recording import ChannelSpec, Recording, write_recording
from tests.bench.importing import builders
from tests.bench.recording import builders as recording_builders

RATE, SECONDS, INERTIA = 1000.0, 20.0, 2e-3
CHANNELS = """
motor_angle = {variable = "q", unit = "rad"}
motor_torque = {variable = "M", unit = "N*m"}
"""


def shaken(folder: Path, hertz: float, noise: float) -> list[Recording]:
    """A rotor that turns slowly and is shaken ``hertz`` times a second, its angle with ``noise`` in rad."""
    rng = np.random.default_rng(4)
    time = np.arange(round(SECONDS * RATE)) / RATE
    rate = 2.0 * np.pi * hertz
    angle = 2.0 * np.sin(0.9 * time) + 30.0 / rate**2 * np.sin(rate * time)
    torque = 0.02 * np.sign(np.cos(0.9 * time)) - INERTIA * 30.0 * np.sin(rate * time)
    angle = angle + rng.normal(0.0, noise, time.size)
    builders.csv(folder / "a.csv", t=time, q=angle, M=torque + rng.normal(0.0, 1e-3, time.size))
    return [builders.one(folder, CHANNELS).recording]


@pytest.mark.parametrize(("hertz", "noise", "span"), [(150.0, 1e-9, 0.004), (40.0, 1e-7, 0.015), (1.5, 1e-4, 0.06)])
def test_what_shakes_fast_wants_a_short_window_and_a_coarse_encoder_a_long_one(
    tmp_path: Path, hertz: float, noise: float, span: float
) -> None:
    recordings = shaken(tmp_path, hertz, noise)
    assert best_rates(recordings, 0.05) == Rates(span)
    manner = Manner.of(recordings)
    assert manner.free
    assert manner.smoothing == span


@pytest.mark.parametrize(("noise", "span"), [(1e-6, 0.06), (0.02, 0.5)])
def test_noise_in_a_slow_acceleration_asks_for_a_window_of_many_samples(
    tmp_path: Path, noise: float, span: float
) -> None:
    """At 20 Hz a window of 60 ms has five samples; a coarse angle leaves nothing but noise in their curvature."""
    rng = np.random.default_rng(4)
    time = np.arange(4000) / 20.0
    angle, inertia = 8.0 * np.sin(0.6 * time), 0.05
    torque = 0.02 * np.sign(np.cos(0.6 * time)) - inertia * 8.0 * 0.36 * np.sin(0.6 * time)
    angle = angle + rng.normal(0.0, noise, time.size)
    builders.csv(tmp_path / "a.csv", t=time, q=angle, M=torque + rng.normal(0.0, 0.02, time.size))
    rates = best_rates([builders.one(tmp_path, CHANNELS).recording], 0.05)
    assert rates is not None
    assert (rates.span == 0.06) if span == 0.06 else (rates.span >= span)


def test_a_window_that_leaves_no_less_is_not_made_longer(tmp_path: Path) -> None:
    """Nothing in the torque says how fast the speed changes: the window stays as long as any other motion's."""
    rng = np.random.default_rng(5)
    time = np.arange(4000) / 20.0
    builders.csv(
        tmp_path / "a.csv",
        t=time,
        q=8.0 * np.sin(0.6 * time) + rng.normal(0.0, 0.02, time.size),
        M=0.02 * np.sign(np.cos(0.6 * time)) + rng.normal(0.0, 0.02, time.size),
    )
    assert best_rates([builders.one(tmp_path, CHANNELS).recording], 0.3) == Rates(0.06)


def test_of_many_short_pieces_that_rest_for_the_most_part_those_that_move_are_asked(tmp_path: Path) -> None:
    """Of six that are spread over the folder none moves."""
    rng = np.random.default_rng(7)
    time = np.arange(round(RATE)) / RATE
    rate = 2.0 * np.pi * 150.0
    pieces = []
    for number in range(36):
        moves = number % 6 == 1
        angle = moves * (2.0 * np.sin(0.9 * time) + 30.0 / rate**2 * np.sin(rate * time))
        torque = moves * (0.02 - INERTIA * 30.0 * np.sin(rate * time)) + rng.normal(0.0, 1e-3, time.size)
        values = {"time": time, "motor_angle": angle + rng.normal(0.0, 1e-9, time.size), "motor_torque": torque}
        channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
        path = tmp_path / f"p{number:02d}.h5"
        write_recording(path, recording_builders.header(path.stem, sample_rate=RATE), channels, [], [])
        pieces.append(Recording.open(path))
    assert best_rates(pieces[::6], 0.05) != Rates(0.004)
    assert best_rates(pieces, 0.05) == Rates(0.004)


def test_what_the_window_lets_pass_may_have_a_row_of_its_own(tmp_path: Path) -> None:
    (recording,) = shaken(tmp_path, 150.0, 1e-9)
    rows = load(recording.path.parent).rows["motor_torque"]
    steady = np.abs(rows.frame.velocity) > 0.5  # away from reversals, which part rows anyway
    assert np.mean(rows.number[steady] / RATE < LIVELY_S) > 0.2


def test_without_a_torque_nothing_is_asked(tmp_path: Path) -> None:
    assert best_rates([], 0.05) is None


def driven(folder: Path, step: float, late_s: float) -> list[Recording]:
    """A motor to and fro, its angle in steps of ``step`` rad, its drive's speed ``late_s`` late; rates of 100 Hz."""
    time = np.arange(4000) / 100.0
    angle, speed = 5.0 * np.sin(1.7 * time), 8.5 * np.cos(1.7 * time)
    torque = 0.02 * np.sign(speed) - INERTIA * 8.5 * 1.7 * np.sin(1.7 * time) + 0.004 * speed
    torque = torque + np.random.default_rng(5).normal(0.0, 1e-3, time.size)
    said = 8.5 * np.cos(1.7 * (time - late_s))
    builders.csv(folder / "a.csv", t=time, q=step * np.round(angle / step), v=said, M=torque)
    return [builders.one(folder, CHANNELS + 'motor_velocity = {variable = "v", unit = "rad/s"}').recording]


@pytest.mark.parametrize(
    ("step", "late_s", "sources"), [(0.2, 0.0, {VELOCITY, RECORDED}), (1e-4, 0.0, {ANGLE}), (1e-4, 0.1, {ANGLE})]
)
def test_the_recorded_speed_is_taken_where_it_says_more_than_the_angle(
    tmp_path: Path, step: float, late_s: float, sources: set[str]
) -> None:
    recordings = driven(tmp_path, step, late_s)
    manner = Manner.of(recordings)
    assert manner.source in sources
    folder = Folder(recordings[0].started_at.timestamp(), manner)
    frame = prepare(recordings[0], 0, folder).frame
    true = 8.5 * np.cos(1.7 * frame.elapsed)
    assert np.std(frame.velocity - true) < 0.05 * np.std(true)


def test_a_campaign_that_begins_at_rest_has_the_window_of_those_that_move(tmp_path: Path) -> None:
    """An angle that stands shows no steps of a coarse encoder, and a window for none lets their noise pass."""
    time = np.arange(4000) / 500.0
    channels = 'motor_angle = {variable = "q", unit = "rad"}'
    step = 2.0 * np.pi / 2**13
    for name, speed in (("a", 0.0), ("b", 20.0), ("c", -20.0)):
        builders.csv(tmp_path / f"{name}.csv", t=time, q=step * np.round(speed * time / step))
    recordings = [i.recording for i in builders.run(tmp_path, channels, file="*.csv") if isinstance(i, Imported)]
    assert len(recordings) == 3
    assert Manner.of(recordings).smoothing == Manner.of(recordings[1:]).smoothing == 0.06
