from __future__ import annotations

import ast
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fakes.concealed
from fakes.concealed import cases, open_folder
from fakes.concealed.exam import ALIKE
from fakes.concealed.noise import NUISANCE_NAMES, Noise, draw_sensors, roughen
from fakes.concealed.recordings import NoiseTally, generate_recordings
from tests.fakes.concealed.test_effects import SMALL


def small(group: str, at: int = 0, **changes):
    return replace(list(cases(group, 2))[at], design=SMALL, **changes)


@pytest.fixture(scope="module")
def made():
    folder = open_folder(small("clear"))
    return list(folder.recordings()), folder.truth()


def test_recordings_meet_the_format(made) -> None:
    recordings, _truth = made
    assert len(recordings) > 10
    ends = [r.started_at for r in recordings]
    assert ends == sorted(ends)
    for recording in recordings:
        sizes = {c.raw.size for c in recording.channels.values()}
        assert len(sizes) == 1
        time = recording.channels["time"].raw
        assert (np.diff(time) > 0).all()
        for _name, start, stop in recording.segments:
            assert 0 <= start < stop <= time.size


def test_steady_parts_hold_a_whole_revolution(made) -> None:
    for recording in made[0]:
        if recording.kind not in ("constant_velocity", "validation"):
            continue
        ((start, stop),) = [(a, b) for name, a, b in recording.segments if name == "steady"]
        channel = recording.channels["load_angle"]
        angle = channel.raw[[start, stop - 1]] * channel.scale
        assert abs(angle[1] - angle[0]) >= 2.0 * np.pi


def test_angles_keep_one_zero(made) -> None:
    last = None
    for recording in made[0]:
        channel = recording.channels["motor_angle"]
        angle = channel.raw * channel.scale
        if last is not None:
            assert abs(angle[0] - last) < 185.0 * 100.0
        last = angle[-1]


def test_truth_tells_noise_and_is_json(made) -> None:
    truth = made[1]
    text = json.dumps(truth.to_dict(), allow_nan=False)
    assert json.loads(text)["effects"][0]["effect"] == truth.effects[0].effect
    assert set(truth.noise_rms) == {"transmission_error", "motor_torque", "temperature", "load_torque"}
    assert all(value > 0.0 for value in truth.noise_rms.values())


def test_a_null_hides_nothing_and_its_noise_is_as_told() -> None:
    folder = open_folder(small("null"))
    list(folder.recordings())
    truth = folder.truth()
    assert truth.verdict == "match"
    assert truth.effects == ()
    sensor = folder.sensors.motor_torque
    assert truth.noise_rms["motor_torque"] == pytest.approx(np.hypot(sensor.sigma, sensor.step / 12**0.5), rel=0.1)


@pytest.mark.parametrize(("alike", "status"), [(0.95, "named"), (0.97, "ambiguous")])
def test_what_the_recordings_tell_apart_is_to_be_named(
    monkeypatch: pytest.MonkeyPatch, alike: float, status: str
) -> None:
    monkeypatch.setattr("fakes.concealed.folder.overlap", lambda *_: alike)
    (case,) = [c for c in cases("ambiguous", 2) if c.least_overlap == ALIKE][:1]
    (effect,) = open_folder(replace(case, design=SMALL)).truth().effects
    assert effect.status == status
    assert bool(effect.also) == (status == "ambiguous")


def test_a_cut_file_is_open_and_shorter() -> None:
    recordings = list(open_folder(small("null", truncate=True)).recordings())
    (cut,) = [r for r in recordings if not r.complete]
    assert cut.segments[-1][2] == -1
    assert all(start < cut.channels["time"].raw.size for _n, start, _s in cut.segments)


def test_lost_cycles_leave_gaps_in_time_and_an_event() -> None:
    folder = open_folder(small("null", elsewhere=True))
    recordings = list(generate_recordings(folder.campaign, folder.sensors, folder.start, NoiseTally(), lost=1.0))
    for recording in recordings:
        time = recording.channels["time"].raw
        assert np.diff(time).max() > 1.5 / recording.rate_hz
        assert any(level == "warning" for _t, level, _text in recording.events)
        assert all(0 <= a < b <= time.size for _n, a, b in recording.segments)


@pytest.mark.parametrize("how", NUISANCE_NAMES)
def test_nuisances_keep_their_sigma(how: str) -> None:
    rng = np.random.default_rng(3)
    noise = roughen(draw_sensors(rng), how, rng).motor_torque
    drawn = np.concatenate([noise.draw(20000, 500.0, rng) for _ in range(40)])
    spikes = noise.spikes / 500.0 * 110.0
    assert np.std(drawn) == pytest.approx(noise.sigma * np.sqrt(1.0 + noise.offset**2 + spikes), rel=0.25)


def test_noise_offset_is_one_a_recording() -> None:
    noise = Noise(sigma=1.0, step=0.0, offset=5.0, colour=0.0)
    means = [noise.draw(4000, 500.0, np.random.default_rng(i)).mean() for i in range(200)]
    assert np.std(means) == pytest.approx(5.0, rel=0.2)


def test_the_examiner_imports_nothing_of_the_bench() -> None:
    root = Path(fakes.concealed.__file__).parent
    for path in root.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] in ("bench", "drivers", "sequences") for name in names), path
