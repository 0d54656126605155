"""Folders as they come: too few recordings, mixed zeros and gearboxes, missing channels, values that are no numbers."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import ConfigurationError, RecordingError
from bench.mismatch import criteria
from bench.mismatch.analysis import _shown_here_first, compared_channels
from bench.mismatch.recordings import loading
from bench.mismatch.recordings.loading import load
from bench.mismatch.recordings.motion import Manner
from bench.mismatch.run import run
from bench.recording import Recording, write_recording
from bench.recording.header import ChannelSpec, Gearbox, RecordingHeader, Segment, Setpoint
from bench.simulation import Simulation
from bench.simulation import model as simulated

RATE = 200.0
BEGIN = datetime(2026, 1, 1, tzinfo=UTC)
HEADER = RecordingHeader(
    recording_id="r",
    campaign_id="c",
    kind="constant_velocity",
    started_at=BEGIN,
    sample_rate=RATE,
    source="emulator",
    setpoint=Setpoint(100.0, 0.1, 25.0),
    gearbox=Gearbox(185.0, 24, 96, 45, 46),
    zero_id="zero-1",
)


def write(folder: Path, number: int, seconds: float = 8.0, without: tuple[str, ...] = (), **changes: object) -> Path:
    """A recording of steady motion with noise; ``changes`` of its header; ``bad`` a channel without a number."""
    rng = np.random.default_rng(number)
    rate = float(changes.pop("rate", RATE))
    n = int(seconds * rate)
    time = np.arange(n) / rate
    speed = 0.1 * (-1.0) ** number * (1 + number % 3)
    theta = speed * time
    values = {
        "time": time,
        "motor_angle": 185.0 * theta,
        "load_angle": theta - 100.0 / 4e6 + 2e-5 * np.sin(46 * theta) + rng.normal(0, 2e-6, n),
        "motor_torque": 0.54 + 0.5 * np.sign(speed) + 0.006 * 185.0 * speed + rng.normal(0, 0.02, n),
        "load_torque": 100.0 + 8.0 * np.sign(speed) + rng.normal(0, 1.0, n),
        "load_motor_torque": np.full(n, 100.0),
        "temperature": 25.0 + rng.normal(0, 0.01, n),
    }
    if changes.pop("opposite", False):
        values["load_torque"] = -values["load_torque"]
    standing = str(changes.pop("standing", ""))
    if standing:
        held = slice(0, n) if changes.pop("from_start", False) else slice(int(3.0 * rate), int(6.0 * rate))
        values[standing][held] = values[standing][held.start]
    if "open_from" in changes:
        values["temperature"][int(float(changes.pop("open_from")) * n) :] = 850.0  # type: ignore[arg-type]
    if changes.pop("clock_back", False):
        values["time"][n // 2 :] -= 3.0
    bad = changes.pop("bad", None)
    if bad is not None:
        values[str(bad)][:] = np.nan
    identity = f"r{number:03d}"
    header = replace(HEADER, recording_id=identity, started_at=BEGIN + timedelta(minutes=number), sample_rate=rate)
    header = replace(header, **{"setpoint": Setpoint(100.0, speed, 25.0), **changes})  # type: ignore[arg-type]
    channels = {name: (v, ChannelSpec.of(name, dtype="float64")) for name, v in values.items() if name not in without}
    path = folder / f"{identity}.h5"
    write_recording(path, header, channels, [Segment("steady", 0, n)], [])
    return path


def test_one_recording_is_cut_into_blocks_and_it_is_said(tmp_path: Path) -> None:
    write(tmp_path, 0, seconds=24.0)
    data = load(tmp_path)
    assert len(data.members) == 14
    assert data.members[0].name == "r000 [1/14]"
    assert "contiguous blocks" in data.notes[0]
    assert "0.25 s apart" in data.notes[0]
    held = [m.held_out for m in data.members]
    assert 0 < sum(held) < 6
    frame = data.rows["motor_torque"].frame
    gaps = np.diff(frame.elapsed)[np.diff(frame.recording) > 0]
    assert np.all(gaps > 0.25)


def test_a_short_recording_alone_is_undetermined_with_the_reason(tmp_path: Path) -> None:
    folder = tmp_path / "r"
    folder.mkdir()
    write(folder, 0, seconds=2.0)
    report = run(folder, tmp_path / "out")
    assert report.verdict == "undetermined"
    assert "1 recording can be fitted, at least 6" in report.why
    assert "Undetermined" in (tmp_path / "out" / "report.html").read_text()


def test_nothing_to_read_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "broken.h5").write_bytes(b"no file at all")
    with pytest.raises(RecordingError, match="no recording that can be compared"):
        load(tmp_path)


def test_truncated_and_odd_files_are_rejected_with_their_reason(tmp_path: Path) -> None:
    for number in range(7):
        write(tmp_path, number)
    whole = write(tmp_path, 7).read_bytes()
    (tmp_path / "r007.h5").write_bytes(whole[: len(whole) // 2])
    write(tmp_path, 8, seconds=0.1)
    write(tmp_path, 9, gearbox=Gearbox(81.0))
    write(tmp_path, 10, gearbox=Gearbox(None))
    data = load(tmp_path)
    assert len(data.members) == 7
    told = " ".join(why for _, why in data.rejected)
    assert len(data.rejected) == 4
    assert "at least 50 are needed" in told
    assert "ratio 81, most of the folder of 185" in told
    assert "names no gear ratio" in told


def test_a_recording_whose_clock_was_not_set_is_rejected(tmp_path: Path) -> None:
    """Time of the campaign would begin in 1970, and drifts be looked for over half a century."""
    for number in range(6):
        write(tmp_path, number)
    write(tmp_path, 6, started_at=datetime(1970, 1, 1, 0, 3, tzinfo=UTC))
    data = load(tmp_path)
    assert data.folder.start == BEGIN.timestamp()
    ((name, why),) = data.rejected
    assert name == "r006.h5"
    assert "started on 1970-01-01, years from most of the folder (2026-01-01)" in why


def test_a_torque_sensor_with_the_other_sign_in_one_recording_is_rejected(tmp_path: Path) -> None:
    """In all of them it is how this bench counts; in one of eight it is a fault."""
    for number in range(8):
        write(tmp_path, number, opposite=number == 3)
    data = load(tmp_path)
    ((name, why),) = data.rejected
    assert name == "r003.h5"
    assert "the other sign beside the load motor's torque" in why
    for name, faulty in (("all", range(8)), ("half", range(4))):  # of a half it is not known which is right
        other = tmp_path / name
        other.mkdir()
        for number in range(8):
            write(other, number, opposite=number in faulty)
        assert not load(other).rejected


def test_what_the_quality_gate_did_not_accept_is_used_all_the_same(tmp_path: Path) -> None:
    """A part of a revolution is no good for the paper's method, and tells of friction; what is broken tells itself."""
    for number in range(7):
        path = write(tmp_path, number)
        with h5py.File(path, "r+") as file:
            file.attrs["accepted"] = False
    data = load(tmp_path)
    assert {m.recording.recording_id for m in data.members} == {f"r{k:03d}" for k in range(7)}
    assert data.rejected == []


def test_a_clock_that_goes_back_is_told_and_the_recording_not_used(tmp_path: Path) -> None:
    for number in range(7):
        write(tmp_path, number, clock_back=number == 2)
    ((name, why),) = load(tmp_path).rejected
    assert name == "r002.h5"
    assert why == "r002.h5: time at index 800 is 1 s after 3.995 s, it should strictly increase"


def test_a_thermometer_whose_circuit_opens_is_not_compared_from_then_on(tmp_path: Path) -> None:
    """A PT100's range ends at 850 °C (IEC 60751); the oil stays as warm as it was for what depends on it."""
    for number in range(7):
        write(tmp_path, number, open_from=1.0 / 3.0 if number == 2 else 1.0)
    data = load(tmp_path)
    (note,) = [text for text in data.notes if "PT100" in text]
    assert note == (
        "r002: temperature reads -200 or 850 °C or beyond, as a PT100 does that is open or shorted, 0.67 of the"
        " samples: not compared there"
    )
    rows = data.rows["temperature"]
    counted = [float(rows.number[rows.frame.recording == k].sum()) for k in range(7)]
    assert counted[2] == pytest.approx(counted[1] / 3.0, rel=0.1)
    for channel in data.rows.values():
        assert np.max(channel.frame.temperature) < 25.2


def test_a_recording_whose_temperature_cannot_be_read_is_named_and_the_others_are_compared(tmp_path: Path) -> None:
    """The first one, which is asked whether a thermometer is connected at all."""
    paths = [write(tmp_path, number) for number in range(7)]
    with h5py.File(paths[0]) as file:
        chunk = file["channels/temperature"].id.get_chunk_info(0)
    with paths[0].open("r+b") as raw:
        raw.seek(chunk.byte_offset)
        raw.write(b"\xff" * chunk.size)
    data = load(tmp_path)
    ((name, why),) = data.rejected
    assert name == "r000.h5"
    assert "/channels/temperature rows 0 to 1600 cannot be read" in why
    assert len(data.members) == 6


def test_a_thermometer_that_is_not_connected_is_as_none(tmp_path: Path) -> None:
    for number in range(7):
        write(tmp_path, number, open_from=0.0)
    data = load(tmp_path)
    assert {"transmission_error", "motor_torque", "load_torque"} == set(data.rows)
    assert np.unique(data.rows["motor_torque"].frame.temperature).tolist() == [criteria.REFERENCE_CELSIUS]
    assert [text for text in data.notes if "thermometer" in text or "temperature" in text] == [
        "the thermometer is open or shorted in all recordings: nothing is compared with the temperature"
    ]
    # of one recording of seven it is not known what its friction would be
    other = tmp_path / "one"
    other.mkdir()
    for number in range(7):
        write(other, number, open_from=0.0 if number == 2 else 1.0)
    of_one = load(other)
    assert 2 not in of_one.rows["motor_torque"].frame.recording
    assert 2 in of_one.rows["load_torque"].frame.recording
    assert len([text for text in of_one.notes if text.startswith("r002")]) == 1


def test_an_encoder_that_never_moves_is_no_transmission_error(tmp_path: Path) -> None:
    """Not connected: the channel holds nothing, and the others are compared."""
    for number in range(7):
        write(tmp_path, number, standing="load_angle", from_start=True)
    data = load(tmp_path)
    channels, skipped = compared_channels(data)
    assert "transmission_error" not in channels
    assert "motor_torque" in channels
    assert any(s.startswith("transmission_error is not compared") for s in skipped)


@pytest.mark.parametrize(("standing", "name"), [("load_angle", "load_angle"), ("motor_angle", "motor_angle"), ("", "")])
def test_an_encoder_that_stays_at_one_value_is_not_compared_there(tmp_path: Path, standing: str, name: str) -> None:
    """Three of eight seconds; where it goes on it is right again."""
    for number in range(7):
        write(tmp_path, number, standing=standing if number == 2 else "")
    data = load(tmp_path)
    told = [note for note in data.notes if "stays at one value" in note]
    rows = data.rows["transmission_error"]
    counted = [float(rows.number[rows.frame.recording == k].sum()) for k in range(7)]
    if not name:
        assert not told
        return
    (note,) = told
    assert note.startswith(f"r002: {name} stays at one value while the other encoder turns, 0.37 of the samples")
    # r005 moves as quickly the other way
    assert counted[2] == pytest.approx(counted[5] * 5.0 / 8.0, rel=0.1)
    inside = (rows.frame.recording == 2) & (rows.number > 0)
    assert np.std(rows.y[inside]) < 5e-5


def test_a_wrong_simulation_is_not_put_on_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "r"
    folder.mkdir()
    for number in range(8):
        write(folder, number)
    wrong = "model.toml: inputs.n_in: the recording has no channel 'motor_speed'."

    def prepared(*_: object) -> None:
        raise ConfigurationError(wrong)

    monkeypatch.setattr(loading, "prepare", prepared)
    with pytest.raises(ConfigurationError, match=r"^model.toml: inputs.n_in"):
        load(folder)


def test_recordings_that_name_no_setpoint_are_points_of_their_own(tmp_path: Path) -> None:
    for number in range(10):
        write(tmp_path, number, kind="free", setpoint=Setpoint())
    members = load(tmp_path).members
    assert [m.held_out for m in members].count(True) == 2
    assert len({m.fold for m in members if not m.held_out}) == 8


def test_zeros_are_never_mixed_unsaid(tmp_path: Path) -> None:
    for number in range(8):
        write(tmp_path, number, zero_id="zero-1" if number < 6 else "zero-2")
    data = load(tmp_path)
    assert set(data.rows["transmission_error"].frame.recording) == set(range(6))
    assert set(data.rows["motor_torque"].frame.recording) == set(range(8))
    assert any("2 encoder zeros are mixed" in note and "2 of 8 recordings" in note for note in data.notes)


def test_a_recording_without_torque_sensor_is_not_read_as_unloaded(tmp_path: Path) -> None:
    for number in range(8):
        write(tmp_path, number, without=("load_torque",) if number == 3 else ())
    data = load(tmp_path)
    assert 3 not in set(data.rows["motor_torque"].frame.recording)
    assert any("r003" in note and "not compared in motor_torque" in note for note in data.notes)


def test_a_channel_that_no_recording_has_is_said(tmp_path: Path) -> None:
    for number in range(7):
        write(tmp_path, number, without=("load_angle", "load_motor_torque"))
    channels, skipped = compared_channels(load(tmp_path))
    assert "transmission_error" not in channels
    assert "load_torque" not in channels
    assert any("no load_angle" in text for text in skipped)


def test_a_channel_of_nothing_but_nan_is_not_compared(tmp_path: Path) -> None:
    for number in range(7):
        write(tmp_path, number, bad="motor_torque")
    channels, skipped = compared_channels(load(tmp_path))
    assert "motor_torque" not in channels
    assert any("motor_torque is not compared: no recording has a usable sample" in text for text in skipped)


@pytest.mark.parametrize(("longest", "compared"), [(1.9, False), (4.1, True)])
def test_a_temperature_of_which_no_recording_has_two_blocks_is_not_compared(
    tmp_path: Path, longest: float, compared: bool
) -> None:
    for number in range(7):
        write(tmp_path, number, seconds=longest if number == 2 else 1.5)
    channels, skipped = compared_channels(load(tmp_path))
    assert ("temperature" in channels) is compared
    why = "temperature is not compared: no recording lasts longer than a mean of 2 s, so none shows how it changes"
    assert (why in skipped) is not compared


def test_a_torque_sensor_without_a_number_is_no_unloaded_bench(tmp_path: Path) -> None:
    for number in range(8):
        write(tmp_path, number, **({"bad": "load_torque"} if number == 2 else {}))
    data = load(tmp_path)
    assert 2 not in set(data.rows["motor_torque"].frame.recording)
    assert any("r002 holds no number in load_torque" in note for note in data.notes)


def test_files_of_different_rates_are_compared_each_at_its_own(tmp_path: Path) -> None:
    for number in range(8):
        write(tmp_path, number, rate=RATE if number % 2 else 100.0)
    rows = load(tmp_path).rows["motor_torque"]
    steady = rows.frame.reversal_time > 2.0
    number = [np.median(rows.number[steady & (rows.frame.recording == r)]) for r in (0, 1)]
    assert number[1] == pytest.approx(2.0 * number[0], rel=0.2)


def test_the_manner_of_motion_follows_the_bench(tmp_path: Path) -> None:
    write(tmp_path, 0)
    geared = load(tmp_path).members[0].recording
    assert Manner.of([geared]).standstill == 0.3
    slow = write(tmp_path, 1, gearbox=Gearbox(1.0))
    axis = Manner.of([Recording.open(slow)])
    assert axis.standstill == pytest.approx(0.02 * 0.2)
    assert axis.smoothing < 0.06


def test_several_folders_each_get_a_report(tmp_path: Path) -> None:
    for name in ("a", "b", "empty"):
        (tmp_path / name).mkdir()
    for number in range(2):
        write(tmp_path / "a", number, seconds=1.0)
        write(tmp_path / "b", number, seconds=1.0)
    folders = [str(tmp_path / name) for name in ("a", "b", "empty")]
    result = CliRunner().invoke(make_app(), ["mismatch", *folders, "--out", str(tmp_path / "out"), "--json"])
    assert result.exit_code == 3
    first, second, third = json.loads(result.output)
    assert first["verdict"] == second["verdict"] == "undetermined"
    assert "no recording" in third["error"]
    assert (tmp_path / "out" / "a" / "report.html").exists()
    again = CliRunner().invoke(make_app(), ["mismatch", folders[0], folders[0], "--out", str(tmp_path / "o")])
    assert again.exit_code != 0
    assert "two folders are called a" in str(again.exception)


def test_other_processes_read_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(7):
        write(tmp_path, number)
    (tmp_path / "r003.h5").write_bytes((tmp_path / "r003.h5").read_bytes()[:3000])
    here = load(tmp_path)
    asked: list[int] = []

    def elsewhere(function: Callable[[Any], Any], items: Sequence[Any], jobs: int) -> Iterator[Any]:
        asked.append(jobs)
        return (pickle.loads(pickle.dumps(function(pickle.loads(pickle.dumps(item))))) for item in items)

    monkeypatch.setattr(loading, "over", elsewhere)
    monkeypatch.setattr(loading, "SAMPLES_A_PROCESS", 3000)
    there = load(tmp_path, jobs=3)
    assert asked == [3]
    assert [m.name for m in there.members] == [m.name for m in here.members]
    for channel, rows in here.rows.items():
        assert np.array_equal(there.rows[channel].y, rows.y)
        assert np.array_equal(there.rows[channel].frame.travel, rows.frame.travel)
    # the distance run goes on from recording to recording
    assert np.all(np.diff(here.rows["motor_torque"].frame.travel) >= 0.0)
    assert here.rows["motor_torque"].frame.travel[-1] > 5.0


@pytest.mark.parametrize(("found", "asked"), [((), False), (("sensor.timing_skew",), True)])
def test_a_delay_that_the_load_torque_does_not_show_is_not_looked_for_elsewhere(
    found: tuple[str, ...], asked: bool
) -> None:
    banned = _shown_here_first(found)
    assert {"sensor.torque_gain", "sensor.torque_hysteresis"} <= set(banned)
    assert ("sensor.timing_skew" not in banned) is asked
    assert not any(effect.startswith(("te.", "friction.")) for effect in banned)


def test_a_recording_of_few_seconds_says_how_long_it_should_be(tmp_path: Path) -> None:
    folder = tmp_path / "r"
    folder.mkdir()
    write(folder, 0, seconds=6.2)
    report = run(folder, tmp_path / "out")
    assert report.why.startswith(
        "6.2 s of recordings make 3 blocks that can be fitted (10 s make enough; `pieces` in the mapping of an import"
    )


@pytest.mark.parametrize(("ratio", "said"), [(185.0, False), (121.0, True)])
def test_a_simulation_of_another_gearbox_is_said_to_be(tmp_path: Path, ratio: float, said: bool) -> None:
    folder = tmp_path / "r"
    folder.mkdir()
    write(folder, 0, seconds=2.0)
    Simulation.nominal(simulated.Gearbox(ratio)).save(tmp_path / "model.json")
    report = run(folder, tmp_path / "out", tmp_path / "model.json")
    assert any("gearbox of ratio 121" in note for note in report.data.notes) is said
    assert ("of another gearbox" in (tmp_path / "out" / "report.html").read_text()) is said
