"""What the first look takes columns for: sides by name and by motion, counts, percent, and what it says of a guess."""

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
_Q = 50 * np.sin(_T) + 10 * _T
_SPEED = np.gradient(_Q, _T)


def _draft(folder: Path, **columns: Any) -> Draft:
    path = builders.csv(folder / "a.csv", **{"t [s]": _T}, **columns)
    return draft(take_inventory(path), folder / "a.toml")


def _content(made: Draft) -> dict[str, Any]:
    return tomllib.loads(made.text())


def _variables(made: Draft) -> dict[str, str]:
    """Column of each channel."""
    return {name: table["variable"] for name, table in _content(made)["channels"].items()}


def _rig(side: str) -> dict[str, Any]:
    """A log with everything on both sides, whose output is called ``side``."""
    return {
        "phi_mot[deg]": np.degrees(_Q),
        f"phi_{side}[deg]": np.degrees(_Q) / 119,
        f"M_{side}[Nm]": 180 * np.sin(_Q / 119),
        "I_mot[A]": np.cos(_T),
        "n_mot[1/min]": _SPEED * 30 / np.pi,
    }


def test_a_short_word_for_the_output_is_one_and_its_angle_gives_the_ratio(tmp_path: Path) -> None:
    made = _draft(tmp_path, **_rig("abtr"))
    taken = _variables(made)
    assert [taken[name] for name in ("load_angle", "load_torque", "motor_torque")] == [
        "phi_abtr[deg]",
        "M_abtr[Nm]",
        "I_mot[A]",
    ]
    assert _content(made)["gearbox"] == {"ratio": 119.0}


def test_an_angle_that_turns_with_the_motors_is_the_outputs_whatever_its_name(tmp_path: Path) -> None:
    made = _draft(tmp_path, **_rig("xyz"))
    taken = _variables(made)
    assert taken["load_angle"] == "phi_xyz[deg]"
    assert _content(made)["gearbox"] == {"ratio": 119.0}
    # a torque that names no side comes after a current that names the motor's
    assert taken["motor_torque"] == "I_mot[A]"


def test_an_angle_that_turns_farther_than_one_of_the_motors_name_is_not_the_outputs(tmp_path: Path) -> None:
    taken = _variables(_draft(tmp_path, **{"phi_mot[rad]": _Q, "phi_el[rad]": 5 * _Q, "M_mot[Nm]": np.cos(_T)}))
    assert "load_angle" not in taken
    assert taken["motor_angle"] == "phi_mot[rad]"


@pytest.mark.parametrize("other", ["control_effort", "controller_effort", "ctrlEffort", "effort_control"])
def test_an_effort_is_a_torque_but_for_that_of_a_controller(tmp_path: Path, other: str) -> None:
    """As ROS calls it (sensor_msgs/JointState)."""
    made = _draft(tmp_path, **{"phi_mot[rad]": _Q, other: np.sin(_T), "effort": np.cos(_T)})
    assert made.entries()["channels.motor_torque.variable"].value == "effort"


def test_a_torque_that_names_no_side_is_marked_as_a_guess(tmp_path: Path) -> None:
    made = _draft(tmp_path, **{"phi_mot[rad]": _Q, "torque [Nm]": np.cos(_T)})
    assert made.entries()["channels.motor_torque.variable"].why == "a guess, its name says no side of the gearbox"


def test_a_ratio_that_is_not_whole_is_asked_for(tmp_path: Path) -> None:
    for ratio, sure in ((119.0, True), (119.206, False)):
        made = _draft(tmp_path, **{"motor angle [rad]": _Q, "output angle [rad]": _Q / ratio})
        assert made.entries()["gearbox.ratio"].value == pytest.approx(ratio)
        assert made.entries()["gearbox.ratio"].sure is sure


@pytest.mark.parametrize(("name", "told"), [("A2 Istposition", True), ("A2 Motorposition", False)])
def test_an_angle_that_turns_less_than_once_may_be_a_joints(tmp_path: Path, name: str, told: bool) -> None:
    joint = np.degrees(_Q) / 121
    made = _draft(tmp_path, **{f"{name} [°]": joint, "A2 Istgeschwindigkeit [°/s]": np.degrees(_SPEED) / 121})
    said = [one for one in made.remarks if "turns over" in one]
    assert len(said) == told
    for one in said:
        assert one.endswith("its table is [channels.load_angle], and that of its speed [channels.load_velocity]")


def test_counts_per_revolution_are_those_of_the_speed_and_not_of_an_overflow_after_several_turns(
    tmp_path: Path,
) -> None:
    counter = np.round(_Q / (2 * np.pi) * 16384).astype(np.int64) % 65536
    channels = _content(_draft(tmp_path, counter=counter, n_rpm=_SPEED * 30 / np.pi))["channels"]
    assert channels["motor_angle"]["counts_per_revolution"] == 16384.0
    assert channels["motor_angle"]["wraps_at"] == 65536.0
    made = _draft(tmp_path, counter=counter, n_rpm=_SPEED * 50 * 30 / np.pi)
    entry = made.entries()["channels.motor_angle.counts_per_revolution"]
    assert entry.value == "?"
    assert entry.why.startswith("of its shaft; n_rpm says 32")


def test_whole_numbers_of_an_encoder_are_counts(tmp_path: Path) -> None:
    counts = np.round(4096 * _Q).astype(np.int64)
    channels = _content(_draft(tmp_path, encoder=counts, current_mA=900 * np.cos(_T)))["channels"]
    assert channels["motor_angle"] == {"variable": "encoder", "unit": "counts", "counts_per_revolution": "?"}
    made = _draft(tmp_path, position=counts, current_mA=900 * np.cos(_T))
    assert made.entries()["channels.motor_angle.unit"].why.endswith("if an encoder counts them")
    made = _draft(tmp_path, encoder=_Q, current_mA=900 * np.cos(_T))
    assert "counts" not in made.entries()["channels.motor_angle.unit"].why


def test_percent_of_the_rated_torque_ask_for_it(tmp_path: Path) -> None:
    columns = {"motor angle [rad]": _Q, "motor torque [% rated]": 50 * np.cos(_T), "valve position [%]": _T}
    made = _draft(tmp_path, **columns)
    content = _content(made)
    table = content["channels"]["motor_torque"]
    assert (table["unit"], table["factor"]) == ("%", "?")
    assert "valve_position" in content["aux"]
    made.write(tmp_path / "a.toml")
    changes = {"channels.motor_torque.factor": "3.2 N*m", "gearbox.ratio": 50.0}
    (done,) = import_recordings(tmp_path / "a.toml", tmp_path / "out", changes=changes)
    assert isinstance(done, Imported)
    np.testing.assert_allclose(done.recording.si("motor_torque"), 1.6 * np.cos(_T), atol=1e-9)


@pytest.mark.parametrize(
    ("channel", "unit", "said"),
    [
        ("motor_torque", "%", "a factor that is 100 % of it, such as '3.2 N*m' for the rated torque"),
        ("motor_angle", "counts", "counts_per_revolution such as 4096 makes an angle of an encoder's counts"),
        ("motor_torque", "counts", "a factor with a unit such as '0.05 N*m'"),
    ],
)
def test_a_unit_of_no_quantity_is_refused_with_what_makes_one_of_it(
    tmp_path: Path, channel: str, unit: str, said: str
) -> None:
    builders.csv(tmp_path / "a.csv", t=_T, x=_Q)
    with pytest.raises(ConfigurationError, match=f"channels.{channel}: unit '{unit}' is of no quantity") as error:
        builders.run(tmp_path, f'{channel} = {{variable = "x", unit = "{unit}"}}', ratio="50")
    assert said in str(error.value)


def test_an_angle_that_goes_to_and_fro_beside_a_speed_of_one_sign_is_not_its_shafts(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    speed = 900.0 + 300.0 * np.sin(0.02 * np.arange(2000)) + rng.normal(0.0, 1.0, 2000)
    phase = 180.0 + 60.0 * np.sin(0.05 * np.arange(2000)) + rng.normal(0.0, 5.0, 2000)
    turned = np.cumsum(speed) * 6.0 / 1000.0
    columns = {"N_VM [1/min]": speed, "M_VM [Nm]": rng.normal(5.0, 1.0, 2000)}
    for name, angle, taken in (
        ("PA1_PHI_1 [°]", phase, False),
        ("PHI [°]", turned % 360.0, True),
        ("PHI", turned % 360.0, True),
        ("PHI [°]", turned + rng.normal(0.0, 20.0, 2000), True),
    ):
        builders.csv(tmp_path / "a.csv", **columns, **{name: angle})
        content = tomllib.loads(draft(take_inventory(tmp_path / "a.csv"), tmp_path / "map.toml").text())
        assert ("motor_angle" in content["channels"]) == taken
        assert content["channels"]["motor_velocity"]["variable"] == "N_VM [1/min]"


def test_german_words_and_units_are_known_as_the_english_ones_are(tmp_path: Path) -> None:
    made = _draft(
        tmp_path,
        Motor_Inkremente=np.round(_Q * 1000).astype(np.int64),
        Abtrieb_Grad=np.degrees(_Q) / 50,
        Antriebsdrehzahl_U_min=_SPEED * 30 / np.pi,
        Drehmoment_Nm=np.cos(_T),
        Oeltemperatur_Grad=40 + _T,
        Strom_A=np.sin(_T),
    )
    channels = _content(made)["channels"]
    taken = {name: (table["variable"], table["unit"]) for name, table in channels.items()}
    assert taken == {
        "time": ("t [s]", "s"),
        "motor_angle": ("Motor_Inkremente", "counts"),
        "load_angle": ("Abtrieb_Grad", "deg"),
        "motor_velocity": ("Antriebsdrehzahl_U_min", "rpm"),
        "motor_torque": ("Drehmoment_Nm", "Nm"),
        "temperature": ("Oeltemperatur_Grad", "degC"),
    }


def test_a_speed_in_turns_per_second_is_one_and_is_in_no_seconds(tmp_path: Path) -> None:
    made = _draft(tmp_path, motor_position_turns=_Q / (2 * np.pi), motor_velocity_turns_s=_SPEED / (2 * np.pi))
    channels = _content(made)["channels"]
    assert channels["motor_angle"] == {"variable": "motor_position_turns", "unit": "rev"}
    assert channels["motor_velocity"] == {"variable": "motor_velocity_turns_s", "unit": "rev/s"}
    # a rate of what nobody knows
    made = _draft(tmp_path, motor_position_turns=_Q / (2 * np.pi), motor_velocity_cranks_s=_SPEED)
    assert _content(made)["channels"]["motor_velocity"]["unit"] == "?"


@pytest.mark.parametrize("name", ["Sample", "n", "Index", "row count", "No."])
def test_a_column_that_counts_the_rows_is_no_time_and_no_channel(tmp_path: Path, name: str) -> None:
    path = builders.csv(
        tmp_path / "a.csv", **{name: np.arange(2000), "motor angle [rad]": _Q, "motor torque [Nm]": np.cos(_T)}
    )
    made = draft(take_inventory(path), tmp_path / "a.toml")
    rate = made.entries()["channels.time.rate"]
    assert (rate.value, rate.why) == ("?", f"samples per second: '{name}' counts the rows by one and is no time")
    assert made.channel_by_column[name] == "counts the rows, left out"
    assert "aux" not in _content(made)
    # beside a time it is left out as well
    made = _draft(tmp_path, **{name: np.arange(2000), "motor angle [rad]": _Q})
    assert _variables(made)["time"] == "t [s]"
    assert "aux" not in _content(made)


def test_a_time_that_rises_by_one_may_count_the_rows(tmp_path: Path) -> None:
    for step, told in ((1, True), (5, False)):
        path = builders.csv(tmp_path / "a.csv", time=np.arange(2000) * step, **{"motor angle [rad]": _Q})
        unit = draft(take_inventory(path), tmp_path / "a.toml").entries()["channels.time.unit"]
        assert unit.value == "?"
        assert ("if it counts them, 'rate' (samples per second)" in unit.why) == told
