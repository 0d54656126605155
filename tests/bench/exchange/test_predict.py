"""``bench predict``: predicted channels and residuals beside the measured ones, and what cannot be predicted."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import ConfigurationError, RecordingError
from bench.exchange.beside import write_copy
from bench.exchange.predicted import predict_recordings
from bench.recording import Recording
from bench.recording.validation import validate
from bench.simulation import Simulation
from bench.simulation.model import Parameter, Term
from tests.bench.mismatch.test_folders import write

TRUE = {
    "friction.coulomb": {"f_c": 0.5 - 8.0 / 185.0},
    "friction.viscous": {"f_v": 0.006},
    "friction.viscous_temperature_linear": {"f_vT": 0.0},
    "friction.load_dependent": {"f_l": 0.0},
    "motor.inertia": {"J": 0.0},
    "motor.torque_offset": {"tau_0": 0.0},
}
"""of the motor torque that ``write`` makes"""


def model(folder: Path) -> Path:
    simulation = Simulation.nominal()
    for effect, values in TRUE.items():
        simulation = simulation.with_term(Term(effect, True, {s: Parameter(v) for s, v in values.items()}))
    simulation.save(folder / "model.json")
    return folder / "model.json"


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    (tmp_path / "in").mkdir()
    return write(tmp_path / "in", 1, seconds=3.0)


def test_a_copy_holds_prediction_and_residual_beside_what_was_measured(recording: Path, tmp_path: Path) -> None:
    before, out = recording.read_bytes(), tmp_path / "out"
    result = CliRunner().invoke(make_app(), ["predict", str(model(tmp_path)), str(recording), "--out", str(out)])
    assert result.exit_code == 0, result.output
    assert recording.read_bytes() == before
    copy = Recording.open(out / "r001.h5")
    measured, simulated, residual = (copy.si(f"{kind}motor_torque") for kind in ("", "simulated/", "residual/"))
    np.testing.assert_allclose(residual, measured - simulated, atol=1e-12)
    assert 0.015 < np.std(residual) < 0.025  # the noise put in
    assert copy.specs["simulated/motor_torque"].unit == "N·m"
    about = validate(copy.path)
    assert not [text for text in (*about.violations, *about.notes) if "simulated" in text or "residual" in text]
    assert (out / "r001.png").stat().st_size > 5000
    assert "motor_torque 0.02" in result.output
    assert "transmission_error is not predicted: model.json has no numbers for te.offset, te.fourier" in result.output


def test_a_table_has_the_same_numbers(recording: Path, tmp_path: Path) -> None:
    arguments = ["predict", str(model(tmp_path)), str(recording), "--out", str(tmp_path), "--to", "csv", "--no-plot"]
    result = CliRunner().invoke(make_app(), [*arguments, "--json"])
    row = json.loads(result.output)["recordings"][0]
    with open(row["files"][0], encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    left = [float(r["residual/motor_torque [N·m]"]) for r in rows]
    assert np.std(left) == pytest.approx(row["residual"]["motor_torque"]["rms"], rel=0.1)


def test_what_is_not_compared_is_told_beside_what_is(recording: Path, tmp_path: Path) -> None:
    """A spike counts as no residual, but it is in the file that is written."""
    with h5py.File(recording, "r+") as file:
        file["channels/motor_torque"][100] = 50.0
    out = tmp_path / "out"
    arguments = ["predict", str(model(tmp_path)), str(recording), "--out", str(out), "--no-plot"]
    said = CliRunner().invoke(make_app(), arguments).output
    left = Recording.open(out / "r001.h5").si("residual/motor_torque")
    assert "of 600 samples are not compared" in said
    assert f"with them {np.sqrt(np.mean(left**2)):.3g} N·m)" in said
    row = json.loads(CliRunner().invoke(make_app(), [*arguments, "--json"]).output)["recordings"][0]["residual"]
    found = row["motor_torque"]
    assert 0.9 < found["compared"] < 1.0
    assert found["rms"] < 0.03 < 1.0 < found["rms_of_all"]


@pytest.mark.parametrize(("begins", "instead"), [(200, "the readings before and after"), (0, "25 °C, for there is no")])
def test_an_open_thermometer_is_told(recording: Path, tmp_path: Path, begins: int, instead: str) -> None:
    with h5py.File(recording, "r+") as file:
        file["channels/temperature"][begins:] = 850.0
    arguments = ["predict", str(model(tmp_path)), str(recording), "--out", str(tmp_path / "out"), "--no-plot"]
    said = CliRunner().invoke(make_app(), arguments).output
    assert f"note: r001: the thermometer is open or shorted in {600 - begins} of 600 samples: predicted with" in said
    assert instead in said


def test_a_clock_that_goes_back_is_told_and_the_others_are_predicted(recording: Path, tmp_path: Path) -> None:
    later = write(recording.parent, 2, seconds=3.0)
    with h5py.File(recording, "r+") as file:
        file["channels/time"][300:] -= 1.0
    found = list(predict_recordings(model(tmp_path), recording.parent))
    assert [bool(one.channels) for one in found] == [False, True]
    assert found[0].refused == ("r001: time at index 300 is 0.5 s after 1.495 s, it should strictly increase",)
    (alone,) = predict_recordings(model(tmp_path), later)
    assert alone.channels
    with pytest.raises(RecordingError, match=r"r001\.h5: time at index 300"):
        list(predict_recordings(model(tmp_path), recording))


def test_what_cannot_be_predicted_is_refused(recording: Path, tmp_path: Path) -> None:
    Simulation.nominal().save(tmp_path / "empty.json")
    with pytest.raises(ConfigurationError, match=r"motor_torque is not predicted: empty.json has no numbers for fric"):
        list(predict_recordings(tmp_path / "empty.json", recording))
    lean = write(tmp_path, 2, seconds=3.0, without=("motor_torque", "load_angle"))
    with pytest.raises(ConfigurationError, match="r002 has no motor_torque"):
        list(predict_recordings(model(tmp_path), lean))


def test_the_recording_itself_is_never_written(recording: Path, tmp_path: Path) -> None:
    (predicted,) = predict_recordings(model(tmp_path), recording)
    with pytest.raises(RecordingError, match="is the recording itself"):
        write_copy(predicted, recording.parent)


def test_what_recordings_of_a_folder_lack_alike_is_said_once(tmp_path: Path) -> None:
    folder = tmp_path / "lean"
    folder.mkdir()
    for number in (1, 2, 3):
        write(folder, number, seconds=3.0, without=("load_angle",))
    arguments = ["predict", str(model(tmp_path)), str(folder), "--out", str(tmp_path / "out"), "--no-plot"]
    result = CliRunner().invoke(make_app(), arguments)
    assert result.exit_code == 0, result.output
    lines = [line for line in result.output.splitlines() if "transmission_error is not predicted" in line]
    assert lines == [
        "note: transmission_error is not predicted: r001 has no load_angle (the same in 2 other recordings)"
    ]


@pytest.mark.parametrize("ratio", [185.0, 185.00001, 121.0])
def test_a_simulation_of_another_gearbox_is_said_to_be(recording: Path, tmp_path: Path, ratio: float) -> None:
    content = json.loads(model(tmp_path).read_text())
    content["gearbox"] = {"ratio": ratio}
    (tmp_path / "model.json").write_text(json.dumps(content))
    (one,) = predict_recordings(tmp_path / "model.json", recording)
    assert ("ratio 121" in one.unlike and "ratio 185" in one.unlike) == (ratio == 121.0)
    assert bool(one.unlike) == (ratio == 121.0)
    arguments = ["predict", str(tmp_path / "model.json"), str(recording), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(make_app(), arguments)
    assert ("another gearbox" in result.output) == (ratio == 121.0)
