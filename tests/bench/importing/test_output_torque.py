"""A torque at the joint, as ROS gives it: a key of its own, proposed by the first look, and told of where it lacks."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.errors import ConfigurationError
from bench.importing import Imported, import_recordings
from bench.importing.looking import Draft, draft, take_inventory
from tests.bench.importing import builders

_T = np.arange(2000) / 200
_Q = np.sin(_T)
_W = np.cos(_T)
_M = 3.0 * np.cos(0.7 * _T)
_ANGLE = 'load_angle = {variable = "q", unit = "rad"}'


def _draft(folder: Path, **columns: Any) -> Draft:
    path = builders.csv(folder / "a.csv", **{"t [s]": _T}, **columns)
    return draft(take_inventory(path), folder / "a.toml")


def _imported(folder: Path, torque: str, name: str = "x", ratio: str = "50.0") -> Imported:
    builders.csv(folder / "a.csv", t=_T, q=_Q, **{name: _M})
    return builders.one(folder, f"{_ANGLE}\nmotor_torque = {{{torque}}}", ratio=ratio)


@pytest.mark.parametrize(
    ("conversion", "factor"),
    [('unit = "N*m"', 1.0), ('unit = "A", torque_constant = 0.1', 0.1), ('unit = "N*m", scale = -2, offset = 1', -2.0)],
)
@pytest.mark.parametrize("ratio", ["50.0", "-50.0"])
def test_a_torque_at_the_output_is_the_motors_over_the_ratio(
    tmp_path: Path, conversion: str, factor: float, ratio: str
) -> None:
    done = _imported(tmp_path, f'variable = "x", {conversion}, at = "output"', ratio=ratio)
    offset = 1.0 if "offset" in conversion else 0.0
    np.testing.assert_allclose(done.recording.si("motor_torque"), (factor * _M + offset) / float(ratio), atol=1e-12)
    said = f"motor_torque is that over gearbox.ratio {float(ratio):g}"
    assert any(note.startswith("the motor's torque was given at the output") and said in note for note in done.notes)


@pytest.mark.parametrize(
    ("name", "torque", "told"),
    [
        ("effort", 'unit = "N*m"', True),
        ("eff", 'unit = "N*m"', True),
        ("effort", 'unit = "N*m", at = "motor"', False),
        ("effort", 'unit = "N*m", scale = 0.02', False),
        ("controller_effort", 'unit = "N*m"', False),
        ("torque", 'unit = "N*m"', False),
    ],
)
def test_an_effort_that_was_taken_for_the_motors_is_told_of(tmp_path: Path, name: str, torque: str, told: bool) -> None:
    done = _imported(tmp_path, f'variable = "{name}", {torque}', name)
    notes = [note for note in done.notes if "ROS gives an effort at the joint" in note]
    assert len(notes) == told
    assert not notes or "at = 'output' in [channels.motor_torque] would be right" in notes[0]


def test_an_effort_of_a_direct_drive_is_both(tmp_path: Path) -> None:
    done = _imported(tmp_path, 'variable = "effort", unit = "N*m"', "effort", "1.0")
    assert not any("ROS" in note for note in done.notes)


def test_only_a_torque_of_the_motor_may_be_given_at_the_output(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", t=_T, q=_Q)
    with pytest.raises(ConfigurationError, match=r"channels\.load_angle\.at: is only for channels\.motor_torque"):
        builders.run(tmp_path, 'load_angle = {variable = "q", unit = "rad", at = "output"}', ratio="50.0")


@pytest.mark.parametrize(
    "names",
    [
        ("position", "velocity", "effort"),
        ("pos", "vel", "eff"),
        ("/joint_states/position[0]", "/joint_states/velocity[0]", "/joint_states/effort[0]"),
        ("joint1_position", "joint1_velocity", "joint1_effort"),
    ],
)
def test_position_velocity_and_effort_are_proposed_as_a_joints(tmp_path: Path, names: tuple[str, str, str]) -> None:
    made = _draft(tmp_path, **dict(zip(names, (_Q, _W, _M), strict=True)))
    channels = tomllib.loads(made.text())["channels"]
    assert {name: table["variable"] for name, table in channels.items()} == {
        "time": "t [s]",
        "load_angle": names[0],
        "load_velocity": names[1],
        "motor_torque": names[2],
    }
    assert channels["motor_torque"]["at"] == "output"
    assert not made.entries()["channels.motor_torque.at"].sure
    assert any("were taken for those of a joint (the output), as in ROS" in one for one in made.remarks)
    made.write(tmp_path / "a.toml")
    units = {"load_angle": "rad", "load_velocity": "rad/s", "motor_torque": "N*m"}
    changes = {f"channels.{name}.unit": unit for name, unit in units.items()} | {"gearbox.ratio": 50.0}
    (done,) = import_recordings(tmp_path / "a.toml", tmp_path / "out", changes=changes)
    assert isinstance(done, Imported)
    np.testing.assert_allclose(done.recording.si("motor_torque"), _M / 50.0, atol=1e-12)
    np.testing.assert_allclose(done.recording.si("motor_angle"), 50.0 * _Q, atol=1e-9)


@pytest.mark.parametrize(
    "names", [("motor_position", "motor_velocity", "effort"), ("phi", "omega", "effort"), ("pos", "vel", "torque")]
)
def test_others_are_not(tmp_path: Path, names: tuple[str, str, str]) -> None:
    made = _draft(tmp_path, **dict(zip(names, (_Q, _W, _M), strict=True)))
    channels = tomllib.loads(made.text())["channels"]
    assert channels["motor_angle"]["variable"] == names[0]
    assert "at" not in channels["motor_torque"]


def test_a_file_for_each_of_the_three_is_a_joints_too(tmp_path: Path) -> None:
    for name, values in (("pos", _Q), ("vel", _W), ("eff", _M)):
        np.savetxt(tmp_path / f"{name}.csv", values)
    made = draft(take_inventory(str(tmp_path / "*.csv")), tmp_path / "a.toml")
    assert tomllib.loads(made.text())["channels"]["motor_torque"]["at"] == "output"
