"""Whether the load torque follows the waves of the transmission error."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.mismatch.given import says_waves, with_shafts
from bench.mismatch.prediction import predict, predict_all
from bench.mismatch.recordings import loading
from bench.mismatch.recordings.followed_waves import FEWEST, NOTE, are_followed, follows_waves
from bench.mismatch.recordings.loading import load
from bench.mismatch.recordings.prepared import Folder, prepare
from bench.recording import ChannelSpec, Recording, Segment, Setpoint, write_recording
from bench.simulation.frame import FloatArray
from bench.simulation.model import Parameter, Simulation, Term
from tests.bench.recording import builders

RATE, RATIO, INERTIA, ORDER = 500.0, 185.0, 3.0, 276.0


def recorded(folder: Path, follows: bool, number: int = 8) -> list[Recording]:
    """Motions that start, run steadily and stop at some speeds, on a gearbox with one large order; the load torque has
    the inertia times the output's acceleration, or times that of both shafts.
    """
    rng, out = np.random.default_rng(3), []
    time = np.arange(4000) / RATE
    for k in range(number):
        speed = 0.5 + 0.05 * k
        rate = speed * np.clip(np.minimum(time, time[-1] - time) / 0.5, 0.0, 1.0)
        theta = np.cumsum(rate) / RATE
        error = 2e-5 * np.sin(ORDER * theta)
        together, waves = np.gradient(rate, time), np.gradient(np.gradient(error, time), time)
        torque = 5.0 + INERTIA * (together + (waves if follows else 0.0)) + rng.normal(0.0, 0.3, time.size)
        values = {
            "time": time,
            "motor_angle": RATIO * theta,
            "load_angle": theta + error + rng.normal(0.0, 1e-7, time.size),
            "load_torque": torque,
            "load_motor_torque": np.zeros(time.size),
        }
        channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items()}
        path = folder / f"r{k:02d}.h5"
        started = builders.header().started_at + timedelta(minutes=k)
        setpoint = Setpoint(load_torque=0.0, velocity=speed, temperature=30.0)
        header = builders.header(path.stem, sample_rate=RATE, started_at=started, setpoint=setpoint)
        write_recording(path, header, channels, [Segment("steady", 300, 3700)], [])
        out.append(Recording.open(path))
    return out


def waves_of(recording: Recording, folder: Folder) -> float:
    """Root mean square of the load's acceleration in the middle of a recording, as it is prepared."""
    frame = prepare(recording, 0, folder, group=1).frame
    middle: FloatArray = frame.load_acceleration[1000:3000]
    return float(np.sqrt(np.mean(middle**2)))


@pytest.mark.parametrize("follows", [True, False])
def test_the_load_is_accelerated_as_its_torque_says(tmp_path: Path, follows: bool) -> None:
    recordings = recorded(tmp_path, follows)
    data = load(tmp_path)
    assert data.folder.manner.follows_waves is follows
    assert (NOTE in data.notes) is not follows
    size = 2e-5 * (ORDER * 0.5) ** 2 / np.sqrt(2.0)
    found = waves_of(recordings[0], data.folder)
    assert found == pytest.approx(size, rel=0.2) if follows else found < 0.1 * size


def test_a_simulation_that_says_so_is_believed(tmp_path: Path) -> None:
    recorded(tmp_path, False)
    assert load(tmp_path, waves=True).folder.manner.follows_waves


def test_few_recordings_are_no_witness(tmp_path: Path) -> None:
    recordings = recorded(tmp_path, False, FEWEST - 1)
    assert follows_waves(recordings, Folder.of(recordings))


def test_recordings_held_out_are_not_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recorded(tmp_path, True)
    asked: list[str] = []

    def witnesses(recordings: Sequence[Recording], folder: Folder) -> bool:
        asked.extend(r.recording_id for r in recordings)
        return True

    monkeypatch.setattr(loading, "follows_waves", witnesses)
    members = load(tmp_path).members
    assert any(m.held_out for m in members)
    assert asked == [m.recording.recording_id for m in members if not m.held_out]


def test_a_recording_alone_is_predicted_as_among_all(tmp_path: Path) -> None:
    """What the folder's recordings told stands in the simulation file."""
    recordings = recorded(tmp_path, False)
    inertia = Term("load.inertia", True, {"J_L": Parameter(INERTIA, "kg*m^2")})
    waves = Simulation.nominal().with_term(inertia)
    shafts = with_shafts(waves)
    alone = predict(shafts, recordings[5])["load_torque"]
    among = [predicted["load_torque"] for _, predicted in predict_all(shafts, recordings)][5]
    np.testing.assert_allclose(alone, among)
    assert np.std(predict(waves, recordings[5])["load_torque"] - alone) > 1.0
    assert Simulation.from_json(shafts.to_json()) == shafts


def test_another_value_of_the_key_is_refused() -> None:
    term = Term("load.inertia", extra={"accelerated_with": "shaft"})
    with pytest.raises(ConfigurationError, match="'accelerated_with': 'shaft' in a row, it should be 'shafts'"):
        says_waves(Simulation.nominal().with_term(term))


def test_waves_that_nothing_shows_are_believed() -> None:
    """Noise in the torque, the two accelerations the same but for a little."""
    rng = np.random.default_rng(1)
    shown = []
    for _ in range(12):
        shafts = rng.normal(size=2000)
        shown.append((2.0 * shafts + 30.0 * rng.normal(size=2000), shafts + 0.01 * rng.normal(size=2000), shafts))
    assert are_followed(shown)
