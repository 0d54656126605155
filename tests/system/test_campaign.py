"""A campaign from file to recordings on the emulated bench, through the real drivers."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from bench.campaigns import Campaign, parse_campaign
from bench.campaigns.execution.session import run_campaign
from bench.campaigns.listener import Silent
from bench.campaigns.picture import order_amplitudes, transmission_error
from bench.campaigns.taken import Status, Summary
from bench.configuration import load_bench, parse_bench
from bench.cycle.end import EndKind
from bench.errors import ConfigurationError, LimitError
from bench.recording import Recording, RecordingFolder
from bench.recording.validation import validate

TEXT = """
format = "bench-campaign"
format_version = "1.0"
name = "short"
title = "two points and a heating"
[[stages]]
name = "s"
[[stages.points]]
sequence = "constant_velocity"
velocities = ["30 deg/s"]
load_torques = ["300 N*m"]
temperatures = ["as found", "25 degC"]
"""


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return parse_campaign(TEXT, "short.toml")


@pytest.fixture(scope="module")
def made(campaign: Campaign, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Summary]:
    folder = tmp_path_factory.mktemp("campaign")
    return folder, run_campaign(load_bench("rh380n"), campaign, folder, Silent(), seed=1)


def test_every_file_is_valid_and_says_where_it_comes_from(made: tuple[Path, Summary]) -> None:
    folder, summary = made
    assert summary.end.kind is EndKind.FINISHED
    assert [taken.kind for taken in summary.taken] == ["constant_velocity", "heating", "constant_velocity"]
    assert not summary.failed
    recordings = RecordingFolder.open(folder).recordings
    assert len(recordings) == 3
    for recording in recordings:
        assert validate(recording.path).valid
        assert recording.complete
        assert recording.accepted
        assert recording.source == "emulator"
        assert recording.config == load_bench("rh380n").text
        assert recording.gearbox_serial
        assert recording.zero_id
        assert recording.point_id


def test_no_recording_holds_the_plants_truth(made: tuple[Path, Summary]) -> None:
    for path in made[0].glob("*.h5"):
        assert b"emulated-plant" not in path.read_bytes()


def test_the_heated_point_was_measured_warm(made: tuple[Path, Summary]) -> None:
    first, heating, second = RecordingFolder.open(made[0]).recordings
    assert np.isnan(first.setpoint.temperature)
    assert second.setpoint.temperature == 25.0
    assert heating.si("temperature")[-1] > 25.0
    assert heating.setpoint.velocity * 185.0 == pytest.approx(200.0)
    (steady,) = second.steady()
    assert abs(second.si("temperature", steady.start, steady.stop).mean() - 25.0) < 1.5


def test_steady_motion_is_a_revolution_at_the_set_point(made: tuple[Path, Summary]) -> None:
    recording = RecordingFolder.open(made[0]).recordings[0]
    (steady,) = recording.steady()
    angle = recording.si("load_angle", steady.start, steady.stop)
    assert abs(angle[-1] - angle[0]) >= 2 * np.pi
    assert np.mean(recording.si("load_torque", steady.start, steady.stop)) == pytest.approx(300, abs=25)


def test_the_transmission_error_shows_the_gearboxs_orders(made: tuple[Path, Summary]) -> None:
    amplitude = order_amplitudes(transmission_error(RecordingFolder.open(made[0]).recordings[0]))
    # orders of the cycloid stage and the output shaft stand far above an order that nothing excites
    assert amplitude[46] > 20 * amplitude[47:55].min()
    assert amplitude[1] > 5e-6


def test_the_manifest_says_what_was_done(made: tuple[Path, Summary]) -> None:
    manifest = json.loads((made[0] / "campaign.json").read_text())
    assert manifest["bench"] == "rh380n"
    assert [entry["status"] for entry in manifest["recordings"]] == ["done"] * 3
    assert manifest["plan"]["points"] == 2
    # forth and back cancels friction: the sensor's zero hardly moves in minutes
    assert abs(manifest["torque_sensor"]["drift_nm"]) < 1.0


def test_running_again_repeats_nothing(made: tuple[Path, Summary], campaign: Campaign) -> None:
    folder, _ = made
    before = sorted((path.name, path.stat().st_mtime_ns) for path in folder.glob("*.h5"))
    again = run_campaign(load_bench("rh380n"), campaign, folder, Silent(), seed=1)
    assert (again.taken, again.earlier) == ([], 2)
    assert sorted((path.name, path.stat().st_mtime_ns) for path in folder.glob("*.h5")) == before


def test_another_campaign_or_configuration_is_not_mixed_in(made: tuple[Path, Summary], campaign: Campaign) -> None:
    other = parse_campaign(TEXT.replace("300 N*m", "301 N*m"), "other.toml")
    with pytest.raises(ConfigurationError, match="campaign"):
        run_campaign(load_bench("rh380n"), other, made[0], Silent())
    changed = parse_bench(load_bench("rh380n").text.replace('"10 kN*m" ', '"9 kN*m" '), "changed")
    with pytest.raises(ConfigurationError, match="configuration"):
        run_campaign(changed, campaign, made[0], Silent())


def test_a_full_disk_is_said_before_anything_is_recorded(campaign: Campaign, tmp_path: Path) -> None:
    text = load_bench("rh380n").text.replace('minimum_free = "500 MB"', 'minimum_free = "1000000000 GB"')
    with pytest.raises(LimitError, match=r"storage\.minimum_free"):
        run_campaign(parse_bench(text, "b"), campaign, tmp_path, Silent())
    assert not list(tmp_path.glob("*.h5"))


def test_a_poor_recording_is_repeated_and_all_takes_are_kept(tmp_path: Path, campaign: Campaign) -> None:
    # a bench file whose load side friction is far from the truth makes the gate's torque band too narrow
    text = load_bench("rh380n").text.replace('load_friction = "8 N*m"', 'load_friction = "0.01 N*m"')
    point = parse_campaign(TEXT.replace(', "25 degC"', "").replace('"300 N*m"', '"0 N*m"'), "one.toml")
    summary = run_campaign(parse_bench(text, "b"), point, tmp_path, Silent())
    assert [taken.take for taken in summary.taken] == [1, 2, 3]
    assert len(summary.failed) == 1
    assert "load_torque" in summary.failed[0].note
    for recording in RecordingFolder.open(tmp_path).recordings:
        assert recording.accepted is False
        assert recording.complete


def bench_command(*arguments: str) -> "subprocess.Popen[str]":
    code = "from bench.cli import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def wait_for_part(folder: Path, process: "subprocess.Popen[str]", finished: int = 0) -> None:
    deadline = time.monotonic() + 60
    while len(list(folder.glob("*.h5"))) < finished or not list(folder.glob("*.part")):
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_operator_stop_finishes_the_recording_at_rest(tmp_path: Path, number: signal.Signals) -> None:
    process = bench_command("run", "distinguish", "--out", str(tmp_path), "--json")
    wait_for_part(tmp_path, process, finished=1)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert json.loads(out)["end"] == "interrupted"
    assert not list(tmp_path.glob("*.part"))
    last = RecordingFolder.open(tmp_path).recordings[-1]
    assert validate(last.path).valid
    assert not last.complete
    texts = [event.text for event in last.events]
    assert any("operator" in text for text in texts)
    assert "bench at rest" in texts[-1]
    assert abs(last.si("motor_velocity")[-10:].mean()) < 0.5
    manifest = json.loads((tmp_path / "campaign.json").read_text())
    assert any(entry["status"] == "pending" for entry in manifest["recordings"])


def test_a_killed_campaign_goes_on_where_it_was(tmp_path: Path, campaign: Campaign) -> None:
    path = tmp_path / "short.toml"
    path.write_text(TEXT)
    folder = tmp_path / "out"
    folder.mkdir()
    process = bench_command("run", str(path), "--out", str(folder), "--json")
    wait_for_part(folder, process, finished=1)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert list(folder.glob("*.part"))
    summary = run_campaign(load_bench("rh380n"), campaign, folder, Silent())
    assert summary.earlier == 1
    assert {taken.status for taken in summary.taken} == {Status.DONE}
    assert not list(folder.glob("*.part"))
    for file in folder.glob("*.h5"):
        assert validate(file).valid, file
        assert Recording.open(file).size > 0


def test_a_plan_beyond_a_limit_ends_with_its_exit_code(tmp_path: Path) -> None:
    path = tmp_path / "far.toml"
    path.write_text(TEXT.replace("300 N*m", "2 kN*m"))
    process = bench_command("run", str(path), "--out", str(tmp_path / "out"))
    _, err = process.communicate(timeout=60)
    assert process.returncode == 4
    assert "limits.load_torque" in err
    assert not (tmp_path / "out").exists()
