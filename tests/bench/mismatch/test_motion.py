"""Corners of a speed profile, and the speeds at which one bench stands and another moves."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.mismatch import criteria
from bench.mismatch.recordings.motion import Manner, away_from_turns, corners, passing, resolved_speed, slowly
from bench.recording import Recording
from tests.bench.importing import builders
from tests.bench.mismatch.regression.synthetic import campaign

RATE = 500.0
CHANNELS = 'motor_angle = {variable = "q", unit = "rad"}\nmotor_torque = {variable = "M", unit = "N*m"}'


def acceleration(*levels: float) -> np.ndarray:
    return np.repeat(np.asarray(levels, dtype=np.float64), 300)


def test_a_ramp_has_corners_where_it_begins_and_ends() -> None:
    found = np.flatnonzero(corners(acceleration(0.0, 60.0, 0.0, 0.0), RATE, 0.06))
    assert {300, 600} <= set(found.tolist())
    assert not {150, 450, 899} & set(found.tolist())


def test_a_recording_that_begins_on_a_ramp_begins_with_a_corner() -> None:
    marked = corners(acceleration(60.0, 0.0, 0.0, 0.0), RATE, 0.06)
    assert marked[0]
    assert marked[300]
    assert not marked[150]
    assert not corners(acceleration(0.0, 0.0, 60.0, 0.0), RATE, 0.06)[0]


def test_a_motion_without_set_speeds_that_begins_or_ends_on_the_way_has_corners_there() -> None:
    rng = np.random.default_rng(2)
    shaken = np.concatenate([np.full(8, 40.0), rng.normal(0.0, 3.0, 1500)])
    assert not corners(shaken, RATE, 0.06)[0]
    assert corners(shaken, RATE, 0.06, free=True)[0]
    # one that never rests has no corners but those, and one that begins at rest none
    swing = 40.0 * np.cos(np.linspace(0.0, 60.0, 1500))
    assert np.flatnonzero(corners(swing, RATE, 0.06, free=True)).size < 60
    assert corners(swing, RATE, 0.06, free=True)[0]
    assert not corners(np.concatenate([np.zeros(100), swing]), RATE, 0.06, free=True)[0]


def test_passing_a_crawl_says_nothing_of_friction_and_a_steady_crawl_does() -> None:
    set_speeds = Manner(criteria.STANDSTILL_RAD_S, 0.06, 1000.0, speed=0.17)
    ramp = np.linspace(-4.0, 4.0, 801)
    slow = np.abs(ramp) < criteria.SURELY_MOVING_RAD_S
    changing, steady = np.zeros(ramp.size), np.ones(ramp.size)
    assert np.array_equal(passing(ramp, changing, set_speeds, 185.0), slow)
    assert not passing(ramp, steady, set_speeds, 185.0).any()
    # a motion that nobody set, or a machine that is hardly faster
    assert not passing(ramp, changing, replace(set_speeds, free=True), 185.0).any()
    assert not passing(ramp, changing, replace(set_speeds, standstill=0.05), 185.0).any()
    assert np.array_equal(passing(ramp, changing, replace(set_speeds, speed=4.0), 1.0), np.abs(ramp) < 0.4)


def test_near_a_turn_the_direction_is_not_known() -> None:
    direction = np.array([1.0] * 10 + [0.0] * 3 + [-1.0] * 10 + [0.0] * 4 + [-1.0] * 5 + [1.0] * 6)
    found = away_from_turns(direction, 3.6)
    changed = np.flatnonzero(found != direction)
    # three samples to either side of each turn; a stop on the way is none
    assert changed.tolist() == [8, 9, 13, 14, 29, 30, 31, 32, 33, 34]
    assert np.all(found[changed] == 0.0)


def test_a_motion_that_does_not_turn_keeps_its_direction() -> None:
    direction = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 1.0])
    assert np.array_equal(away_from_turns(direction, 2.5), direction)
    assert away_from_turns(np.zeros(0), 2.5).size == 0


@pytest.mark.parametrize(("crawling", "told"), [(0, False), (4, False), (10, True)])
def test_a_motor_that_crawls_is_said_to_be_left_out(crawling: int, told: bool) -> None:
    """Of a hundred rows in motion; rows at rest are none and count for nothing."""
    frame = campaign(8).take(slice(0, 200))
    speed = np.repeat([2.0, 0.1, 0.0], [100 - crawling, crawling, 100])
    frame = replace(frame, velocity=speed / frame.ratio, direction=np.where(speed > 0.3, 1.0, 0.0))
    notes = slowly(replace(frame, count=np.ones(200)), Manner(0.3, 0.06, 1000.0))
    assert bool(notes) is told
    assert not told or notes[0].startswith("in 0.1 of the samples in motion the motor is slower than 0.3 rad/s")


@pytest.mark.parametrize(
    ("swing", "step", "limit"),
    [(2.0, 0.0, 0.3), (0.05, 0.0, 0.02 * 0.157), (0.05, 0.004, 0.3)],
    ids=["fast", "slow", "slow, but the encoder is coarse"],
)
def test_a_recording_that_is_slow_by_intent_has_a_standstill_of_its_own(
    tmp_path: Path, swing: float, step: float, limit: float
) -> None:
    time = np.arange(4000) / RATE
    angle = swing * np.sin(np.pi * time)
    angle = step * np.round(angle / step) if step else angle
    builders.csv(tmp_path / "a.csv", t=np.round(time, 6), q=angle, M=np.cos(np.pi * time))
    builders.one(tmp_path, CHANNELS)
    (path,) = (tmp_path / "out").glob("*.h5")
    manner = Manner(criteria.STANDSTILL_RAD_S, 0.004 if step else 0.03, 1.0, free=True)
    assert resolved_speed(Recording.open(path), manner) == pytest.approx(limit, rel=0.02)
    assert resolved_speed(Recording.open(path), replace(manner, free=False)) == manner.standstill
