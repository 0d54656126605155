"""What the first look says of columns that are of no use as they are: constant, backwards, with holes, in odd units."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.errors import ConfigurationError
from bench.importing import import_recordings
from bench.importing.axis import mixture
from bench.importing.looking import Draft, draft, take_inventory
from tests.bench.importing import builders

_T = np.arange(200) / 100
_WAVE = np.sin(_T)


def _draft(folder: Path, **columns: Any) -> Draft:
    path = builders.csv(folder / "a.csv", **columns)
    return draft(take_inventory(path), folder / "a.toml")


def _look(folder: Path, *more: str, **columns: Any) -> str:
    path = builders.csv(folder / "a.csv", **columns)
    arguments = ["import", "--look", str(path), "--mapping", str(folder / "a.toml"), *more]
    done = CliRunner().invoke(make_app(), arguments, catch_exceptions=False)
    assert done.exit_code == 0
    return done.output


def test_a_constant_column_is_no_candidate_and_is_said_to_be_constant(tmp_path: Path) -> None:
    made = _draft(tmp_path, **{"time [s]": _T, "motor angle [rad]": 0 * _T + 3, "torque [Nm]": 0 * _T + 1.5})
    angle, torque = made.lacking()
    assert angle.endswith("'motor angle [rad]' is 3 in all samples, so nothing was measured there")
    assert torque.endswith("'torque [Nm]' is 1.5 in all samples, so nothing was measured there")


def test_a_table_is_advised_for_what_it_may_be_only(tmp_path: Path) -> None:
    made = _draft(tmp_path, **{"time [s]": _T, "angle [rad]": 0 * _T, "pressure [bar]": 2 + _WAVE})
    assert "as [aux.NAME] to [channels.motor_torque]" in made.lacking()[1]
    made = _draft(tmp_path, **{"time [s]": _T, "motor angle [rad]": 9 * _T, "pressure [bar]": _WAVE, "wave": _WAVE})
    (torque,) = made.lacking()
    assert "as [aux.wave] to [channels.motor_torque]" in torque


def test_auxiliary_quantities_alone_are_no_recording(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", t=_T, p=_WAVE)
    with pytest.raises(ConfigurationError, match=r"at least one measured channel; \[aux.NAME\] alone is none"):
        builders.run(tmp_path, "", aux='p = {variable = "p", unit = "bar"}')


def test_a_time_that_falls_is_said_to_run_backwards_and_where(tmp_path: Path) -> None:
    made = _draft(tmp_path, **{"time [s]": _T[::-1], "motor angle [rad]": _WAVE, "torque [Nm]": np.cos(_T)})
    why = made.entries()["channels.time.rate"].why
    assert why == "samples per second: 'time [s]' is no time, it runs backwards from line 3 on"
    made = _draft(tmp_path, **{"motor angle [rad]": _WAVE, "torque [Nm]": np.cos(_T)})
    assert made.entries()["channels.time.rate"].why == "samples per second: no column is a time"


def test_samples_that_are_no_number_are_counted_and_the_first_is_named(tmp_path: Path) -> None:
    holes = _WAVE.copy()
    holes[[10, 11, 50]] = np.nan, np.nan, np.inf
    columns = {"time [s]": _T, "motor angle [rad]": holes, "torque [Nm]": np.cos(_T)}
    shown = _look(tmp_path, **columns)
    said = "3 of 200 samples are no number (NaN, inf, empty or a fill value), the first in line 12"
    assert f"motor angle [rad]: {said}" in shown
    assert shown.count("no number") == 1
    (tmp_path / "a.toml").unlink()
    found = json.loads(_look(tmp_path, "--json", **columns))
    assert [column["missing"] for column in found["columns"]] == [0, 3, 0]


def test_an_angle_in_a_unit_of_length_beside_a_torque_is_remarked_and_blamed(tmp_path: Path) -> None:
    columns = {"time [s]": _T, "motor angle [furlong]": 9 * _T, "motor torque [Nm]": _WAVE}
    shown = _look(tmp_path, **columns)
    blamed = "channels.motor_angle.unit is 'furlong', which becomes m, and channels.motor_torque is in N·m: the unit"
    assert blamed in shown
    text = (tmp_path / "a.toml").read_text("utf-8")
    assert blamed in text
    assert tomllib.loads(text)["gearbox"] == {"ratio": "?"}
    with pytest.raises(
        ConfigurationError, match=r"channels\.motor_angle\.unit is 'furlong'.*an angle's, such as 'deg'"
    ):
        list(import_recordings(tmp_path / "a.toml", tmp_path / "out", changes={"gearbox.ratio": 1.0}))


@pytest.mark.parametrize(
    "units",
    [
        {"motor_angle": ("m", "mm"), "motor_torque": ("N", "N")},
        {"motor_angle": ("rad", "deg"), "motor_torque": ("N·m", "Nm")},
        {"motor_angle": ("rad", "deg"), "motor_torque": ("N", "N")},
    ],
)
def test_units_of_one_kind_of_axis_and_a_force_with_a_lever_are_no_mixture(units: dict[str, tuple[str, str]]) -> None:
    assert mixture(units) is None
