"""The torque of a load that is kept at a level, as a recording is read: with what the load motor does as well."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.mismatch.recordings.motion import Manner
from bench.mismatch.recordings.prepared import Folder, prepare
from bench.recording import ChannelSpec, Recording, Segment, write_recording
from bench.simulation.frame import FloatArray
from tests.bench.recording import builders

RATE, SIZE, LEVEL, SIZE_NM = 200.0, 12_000, 500.0, 3.0
INNER = slice(400, -400)
TIME = np.arange(SIZE) / RATE


def about_the_level(folder: Path, sensor: FloatArray, motor: FloatArray | None, confirmed: float = 0.0) -> FloatArray:
    """The frame's torque about its level where the torque ``sensor`` reads more than that (n,), and the load ``motor``
    gives more (n,), if it is recorded; of what the sensor reads second by second the share ``confirmed`` is load.
    """
    rng = np.random.default_rng(6)
    values = {"time": TIME, "motor_angle": 18.5 * TIME, "load_angle": 0.1 * TIME}
    values["load_torque"] = LEVEL + sensor + rng.normal(0.0, 0.2, SIZE)
    if motor is not None:
        values["load_motor_torque"] = LEVEL + motor + rng.normal(0.0, 0.2, SIZE)
    channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
    path = folder / "r.h5"
    write_recording(path, builders.header("r", sample_rate=RATE), channels, [Segment("steady", 0, SIZE)], [])
    recording = Recording.open(path)
    manner = Manner(0.5, 0.06, 1000.0, confirmed=confirmed)
    frame = prepare(recording, 0, Folder(recording.started_at.timestamp(), manner), group=1).frame
    return (frame.torque - frame.torque_level)[INNER]


def ripple(hertz: float) -> FloatArray:
    """A load that rises and falls so often a second (n,), N·m."""
    return np.asarray(SIZE_NM * np.sin(2.0 * np.pi * hertz * TIME))


@pytest.mark.parametrize(("hertz", "confirmed", "lost"), [(1.0, 1.0, 0.1), (1.5, 0.0, 0.3), (2.0, 0.0, 0.2)])
def test_a_ripple_that_the_load_motor_gives_as_well_stays_in_the_torque(
    tmp_path: Path, hertz: float, confirmed: float, lost: float
) -> None:
    own = ripple(hertz)
    left = own[INNER] - about_the_level(tmp_path, own, own, confirmed)
    assert np.std(left) < lost * np.std(own)


@pytest.mark.parametrize("hertz", [1.0, 1.5, 2.0])
def test_what_the_sensor_alone_reads_goes(tmp_path: Path, hertz: float) -> None:
    own = ripple(hertz)
    assert np.std(about_the_level(tmp_path, own, np.zeros(SIZE))) < 0.05 * np.std(own)


def test_without_a_torque_of_the_load_motor_the_mean_is_kept_alone(tmp_path: Path) -> None:
    assert np.std(about_the_level(tmp_path, ripple(1.5), None)) < 1e-9 * SIZE_NM


@pytest.mark.parametrize("ramps", [False, True])
def test_what_the_load_motor_reports_keeps_its_level_in_ramps_of_the_speed(tmp_path: Path, ramps: bool) -> None:
    """Noise of the load motor is in the difference of the two torques: a loop that follows it would be told from it.
    A ramp of the load itself is none of noise.
    """
    rng = np.random.default_rng(8)
    load = LEVEL + rng.normal(0.0, 1.0, SIZE)
    if ramps:
        load[:400] += np.linspace(-400.0, 0.0, 400)
    values = {"time": TIME, "motor_angle": 18.5 * TIME, "load_angle": 0.1 * TIME, "load_torque": load}
    values["load_motor_torque"] = load + rng.normal(0.0, 0.2, SIZE)
    channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
    path = tmp_path / "r.h5"
    segments = [Segment("ramp_up", 0, 400), Segment("steady", 400, SIZE)]
    write_recording(path, builders.header("r", sample_rate=RATE), channels, segments, [])
    recording = Recording.open(path)
    own = Folder(recording.started_at.timestamp(), Manner(0.5, 0.06, 1000.0))
    frame = prepare(recording, 0, own, group=1).frame
    assert np.ptp(frame.load_motor_level[400:]) == 0.0
    assert (np.ptp(frame.load_motor_level[:400]) > 300.0) if ramps else (np.ptp(frame.load_motor_level[:400]) == 0.0)
