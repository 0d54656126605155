"""What ``--look`` sees in a file, the mapping it begins, and what ``--ask`` asks."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from typer.testing import CliRunner, Result

from bench.cli.app import make_app
from bench.errors import ConfigurationError, RecordingError
from bench.importing.looking import Draft, ask, draft, take_inventory
from bench.importing.looking.inventory import picture
from bench.recording import Recording
from tests.bench.importing import builders

_T = np.arange(2000) / 200
_Q = 50 * np.sin(_T) + 10 * _T


def _machine(folder: Path) -> Path:
    path = folder / "rig.csv"
    return builders.csv(
        path,
        **{
            "Zeit [s]": _T,
            "Winkel Motor [°]": np.round(np.degrees(_Q) % 360, 6),
            "Winkel Abtrieb [°]": np.degrees(_Q) / 101,
            "Motorstrom [A]": np.cos(_T),
            "Öltemperatur [°C]": 30 + _T / 10,
            "Solldrehzahl [1/min]": 10 * _T,
            "Öldruck [bar]": 2 + 0.1 * np.sin(_T),
        },
    )


def _draft(path: Path) -> Draft:
    return draft(take_inventory(path), path.with_suffix(".toml"))


def _content(made: Draft) -> dict[str, Any]:
    return tomllib.loads(made.text())


def test_names_and_units_give_channels_and_the_data_give_ratio_and_overflow(tmp_path: Path) -> None:
    made = _draft(_machine(tmp_path))
    content = _content(made)
    assert content["gearbox"]["ratio"] == 101.0
    assert content["channels"]["time"] == {"variable": "Zeit [s]", "unit": "s"}
    assert content["channels"]["motor_angle"] == {"variable": "Winkel Motor [°]", "unit": "°", "wraps_at": 360.0}
    assert content["channels"]["load_angle"]["variable"] == "Winkel Abtrieb [°]"
    assert content["channels"]["motor_torque"]["torque_constant"] == "?"
    assert content["channels"]["temperature"]["unit"] == "°C"
    assert content["channels"]["Solldrehzahl"] == {"variable": "Solldrehzahl [1/min]", "unit": "1/min"}
    assert content["aux"]["Oeldruck"]["unit"] == "bar"
    assert made.open() == ["channels.motor_torque.torque_constant"]
    assert made.rate == pytest.approx(200.0)
    assert "# a guess" in made.text()


def test_a_linear_axis_a_matrix_in_rows_and_a_constant(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "a.mat", {"x": np.vstack([_T, _Q]), "pos_mm": _Q, "t": _T, "k": 35.0})
    found = take_inventory(tmp_path / "a.mat")
    assert [column.name for column in found.columns] == ["x row 1", "x row 2", "pos_mm", "t"]
    assert found.constants == {"k": 35.0}
    content = _content(draft(found, tmp_path / "a.toml"))
    assert content["gearbox"] == {"ratio": 1.0, "axis": "linear"}
    assert content["channels"]["motor_angle"] == {"variable": "pos_mm", "unit": "mm"}


def test_counts_are_asked_for_unless_they_overflow_where_encoders_do(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", t=_T, enc_counts=(np.arange(2000) * 37) % 4096, load_counts=np.arange(2000) * 3)
    content = _content(_draft(tmp_path / "a.csv"))["channels"]
    assert content["motor_angle"]["counts_per_revolution"] == content["motor_angle"]["wraps_at"] == 4096
    assert content["load_angle"]["counts_per_revolution"] == "?"


@pytest.mark.parametrize(
    ("stamps", "expected"),
    [
        (np.arange(100) * 5, {"unit": "?"}),
        (1.78e12 + np.arange(100) * 5, {"unit": "ms"}),
        (np.arange(100) / 50, {"unit": "s"}),
        ([str(np.datetime64("2026-03-01T12:00") + np.timedelta64(i, "s")) for i in range(100)], {"timezone": "UTC"}),
    ],
)
def test_time_is_found_and_its_unit_guessed_or_left_open(tmp_path: Path, stamps: Any, expected: dict[str, str]) -> None:
    builders.csv(tmp_path / "a.csv", time=stamps, M=np.sin(np.arange(100)))
    assert _content(_draft(tmp_path / "a.csv"))["channels"]["time"] == {"variable": "time", **expected}


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::FutureWarning", "ignore::UserWarning")
def test_groups_with_clocks_of_their_own(tmp_path: Path) -> None:
    from asammdf import MDF, Signal

    with MDF(version="4.10") as file:
        file.append([Signal(_Q, _T, name="motor_angle", unit="rad")])
        file.append([Signal(20 + _T[::100], _T[::100], name="oil_temp", unit="degC")])
        file.save(tmp_path / "a.mf4")
    made = _draft(tmp_path / "a.mf4")
    content = _content(made)["channels"]
    assert content["time"]["variable"] == "0/time"
    assert content["temperature"] == {"variable": "oil_temp", "unit": "degC", "time": "1/time"}
    made.set("gearbox.ratio", 5.0, "")
    made.write(tmp_path / "a.toml")
    result = _bench("import", tmp_path / "a.toml", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    recording = Recording.open(tmp_path / "out/a.h5")
    np.testing.assert_allclose(recording.si("temperature"), 20 + recording.si("time"), atol=1e-9)


def test_the_questions_are_those_of_what_is_open_or_guessed_and_a_wrong_answer_is_asked_again(tmp_path: Path) -> None:
    made = _draft(_machine(tmp_path))
    answers = iter(["a lot", "0.12"])
    asked: list[str] = []
    said: list[str] = []

    def prompt(question: str, guess: str | None) -> str:
        asked.append(question.partition(":")[0])
        assert guess is None
        return next(answers)

    ask(made, prompt, said.append)
    assert asked == ["channels.motor_torque.torque_constant"] * 2
    assert "'a lot' should be a number with a unit" in said[0]
    assert _content(made)["channels"]["motor_torque"]["torque_constant"] == 0.12
    assert made.open() == []


def test_pictures_are_one_line() -> None:
    assert picture(np.linspace(0, 1, 1000), 8) == "▁▂▃▄▅▆▇█"
    assert picture(np.zeros(100), 4) == "▁▁▁▁"
    assert picture(np.full(5, np.nan)) == ""


def _bench(*arguments: object, **more: Any) -> Result:
    return CliRunner().invoke(make_app(), [str(argument) for argument in arguments], **more)


def test_from_look_to_a_recording_on_the_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _machine(tmp_path)
    result = _bench("import", "--look", "rig.csv")
    assert result.exit_code == 0, result.output
    for text in (
        "7 columns of 2000 samples, 200 Hz",
        "▁",
        "load_angle",
        "torque_constant is open",
        "mapping: rig.toml",
    ):
        assert text in result.output
    assert isinstance(_bench("import", "--look", "rig.csv").exception, ConfigurationError)
    printed = json.loads(_bench("import", "--look", "rig.csv", "--mapping", "b.toml", "--json").stdout)
    assert printed["open"] == ["channels.motor_torque.torque_constant"]
    still_open = _bench("import", "rig.toml", "--out", tmp_path / "out").exception
    assert "torque_constant is still '?', it should be a number in N·m/A" in str(still_open)
    result = _bench(
        "import", "rig.toml", "--out", tmp_path / "out", "--set", "channels.motor_torque.torque_constant=0.12"
    )
    assert result.exit_code == 0, result.output
    recording = Recording.open(tmp_path / "out/rig.h5")
    np.testing.assert_allclose(recording.si("motor_torque"), 0.12 * np.cos(_T), atol=1e-9)
    assert "torque_constant" in (recording.config or "")
    result = _bench("import", "--ask", "rig.csv", "--mapping", "c.toml", "--out", tmp_path / "asked", input="0.5\n")
    assert result.exit_code == 0, result.output
    assert Recording.open(tmp_path / "asked/rig.h5").size == 2000


def test_the_command_wants_one_thing_to_do(tmp_path: Path) -> None:
    assert _bench("import").exit_code == 2
    assert _bench("import", tmp_path / "a.toml").exit_code == 2
    assert isinstance(_bench("import", "--look", tmp_path / "no*.csv").exception, RecordingError)
    wrong = _bench("import", "--look", _machine(tmp_path), "--set", "ratio").exception
    assert "should be KEY=VALUE, such as gearbox.ratio=50" in str(wrong)


def test_a_clock_without_a_name_is_told_by_its_numbers(tmp_path: Path) -> None:
    path = tmp_path / "plain.csv"
    steps = np.where(np.arange(_T.size) % 3 == 0, 0.012, 0.010)
    np.savetxt(path, np.column_stack([1297 + np.cumsum(steps), _Q, np.cos(_T)]), delimiter=",")
    made = _draft(path)
    assert _content(made)["channels"]["time"] == {"column": 1, "unit": "s"}
    assert "a guess, it rises as a clock does" in made.text()


def test_what_rises_unevenly_is_no_clock(tmp_path: Path) -> None:
    path = tmp_path / "plain.csv"
    travel = np.cumsum(0.5 + 0.45 * np.sin(_T))
    np.savetxt(path, np.column_stack([travel, np.cos(_T)]), delimiter=",")
    assert _content(_draft(path))["channels"]["time"] == {"rate": "?"}


def test_a_column_of_a_matrix_may_be_the_clock(tmp_path: Path) -> None:
    path = tmp_path / "matrix.mat"
    scipy.io.savemat(path, {"data": np.column_stack([_T, np.zeros(_T.size), _Q, np.cos(_T)])})
    assert _content(_draft(path))["channels"]["time"] == {"variable": "data", "column": 1, "unit": "s"}


def test_a_constant_is_no_channel_and_an_empty_column_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "trailing.csv"
    rows = [f"{t},0,{np.cos(t)},{q},," for t, q in zip(_T, _Q, strict=True)]
    path.write_text("\n".join(["time,torque_model,torque_motor,angle,,", *rows]) + "\n")
    made = _draft(path)
    content = _content(made)
    assert content["channels"]["motor_torque"]["variable"] == "torque_motor"
    assert list(content["aux"]) == ["torque_model"]
    shown = CliRunner().invoke(make_app(), ["import", "--look", str(path), "--mapping", str(tmp_path / "m.toml")])
    assert shown.output.count("empty, left out") == 2


def test_a_file_without_names_says_what_the_analysis_needs_and_how_to_name_it(tmp_path: Path) -> None:
    path = tmp_path / "rig.txt"
    np.savetxt(path, np.column_stack([10 * np.arange(2000), _Q, np.cos(_T)]), fmt="%.6g", delimiter="\t")
    made = _draft(path)
    assert [why.split(",")[0] for why in made.lacking()] == [
        "no column was taken for the motor's angle or speed",
        "no column was taken for the motor's torque",
    ]
    assert "[aux.column_N] with its number as N, should be renamed to [channels.motor_angle]" in made.lacking()[0]
    assert made.text().startswith("# no column was taken for the motor's angle or speed")
    assert tomllib.loads(made.text())["aux"]["column_2"]["column"] == 2
    assert not _draft(_machine(tmp_path)).lacking()
    shown = CliRunner().invoke(make_app(), ["import", "--look", str(path), "--mapping", str(tmp_path / "m.toml")])
    assert "no column was taken for the motor's torque" in shown.output.replace("\n", " ")


def test_of_an_arm_the_joint_that_moves_is_taken(tmp_path: Path) -> None:
    q = np.column_stack([1e-3 * np.sin(_T), np.sin(_T), 0.1 * np.sin(_T)])
    np.savez(tmp_path / "arm.npz", t=_T, q=q, tau=np.cos(q))
    content = _content(_draft(tmp_path / "arm.npz"))
    assert [content["channels"][name]["column"] for name in ("motor_angle", "motor_torque")] == [2, 2]
    assert [entry["column"] for entry in content["aux"].values()] == [1, 3, 1, 3]


def test_of_an_arm_whose_joints_are_numbered_in_their_names_the_one_that_moves_is_taken(tmp_path: Path) -> None:
    own = {"Position1": 1e-3 * np.sin(_T), "Position2": np.sin(_T), "Torque1": np.cos(_T), "Torque2": np.sin(_T)}
    builders.csv(tmp_path / "arm.csv", **{"t [s]": _T}, **own, Temp2=_T)
    channels = _content(_draft(tmp_path / "arm.csv"))["channels"]
    assert [channels[name]["variable"] for name in ("motor_angle", "motor_torque")] == ["Position2", "Torque2"]
    # two encoders beside one torque are the two ends of a gearbox and no arm
    own = {"Position1": np.sin(_T), "Position2": 3.0 * np.sin(_T), "Torque": np.cos(_T)}
    builders.csv(tmp_path / "rig.csv", **{"t [s]": _T}, **own)
    channels = _content(_draft(tmp_path / "rig.csv"))["channels"]
    assert [channels[f"{side}_angle"]["variable"] for side in ("motor", "load")] == ["Position2", "Position1"]


def test_what_was_measured_is_taken_and_not_what_was_wanted(tmp_path: Path) -> None:
    own = {"posDes": np.sin(_T), "velDes": np.cos(_T), "posAct": np.sin(_T), "velAct": np.cos(_T)}
    builders.csv(tmp_path / "a.csv", **{"t [s]": _T}, **own, tau_con=np.sin(_T), tau_meas=np.sin(_T))
    channels = _content(_draft(tmp_path / "a.csv"))["channels"]
    taken = [channels[name]["variable"] for name in ("motor_angle", "motor_velocity", "motor_torque")]
    assert taken == ["posAct", "velAct", "tau_meas"]
    assert channels["posDes"] == {"variable": "posDes"}


def test_a_current_position_is_no_current(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", **{"t [s]": _T}, CurrentPosition=np.sin(_T), Current=np.cos(_T))
    channels = _content(_draft(tmp_path / "a.csv"))["channels"]
    assert channels["motor_angle"]["variable"] == "CurrentPosition"
    assert channels["motor_torque"]["variable"] == "Current"


def test_a_file_for_each_channel_has_its_name(tmp_path: Path) -> None:
    files = ("boom_angle_deg", _Q), ("boom_speed_deg_per_sec", np.gradient(_Q, _T)), ("force_kN", _Q), ("joystick", _T)
    for name, values in files:
        np.savetxt(tmp_path / f"{name}.txt", values)
    made = draft(take_inventory(tmp_path / "*.txt"), tmp_path / "rig.toml")
    content = _content(made)
    assert content["channels"]["motor_angle"] == {"file": "boom_angle_deg.txt", "column": 1, "unit": "deg"}
    assert content["channels"]["motor_velocity"]["unit"] == "deg/s"
    assert content["channels"]["motor_torque"] == {"file": "force_kN.txt", "column": 1, "unit": "kN", "factor": "?"}
    assert content["channels"]["time"] == {"rate": 200.0}
    assert content["gearbox"] == {"ratio": "?"}
    assert content["aux"]["joystick"] == {"file": "joystick.txt", "column": 1}
    assert content["recordings"] == [{"file": "boom_angle_deg.txt"}]
    np.savetxt(tmp_path / "longer.txt", np.arange(5000.0))
    assert len(take_inventory(tmp_path / "*.txt").columns) == 1


def test_a_file_for_each_quantity_with_a_column_for_each_joint(tmp_path: Path) -> None:
    two = np.column_stack([0.1 * _Q, _Q])
    for name, values in (("run_ang", two), ("run_torque", -two), ("run_acc", two)):
        np.savetxt(tmp_path / f"{name}.txt", values)
    content = _content(draft(take_inventory(tmp_path / "*.txt"), tmp_path / "rig.toml"))
    assert content["channels"]["motor_angle"] == {"file": "run_ang.txt", "column": 2, "unit": "?"}
    assert content["channels"]["motor_torque"] == {"file": "run_torque.txt", "column": 2, "unit": "?"}
    assert content["aux"]["run_acc_column_1"] == {"file": "run_acc.txt", "column": 1}


def test_runs_of_several_columns_without_names_are_runs(tmp_path: Path) -> None:
    for name in ("torque_1", "torque_2"):
        np.savetxt(tmp_path / f"{name}.txt", np.column_stack([_T, _Q]))
    assert len(take_inventory(tmp_path / "*.txt").columns) == 2


def test_a_clock_that_is_coarser_than_the_samples_gives_their_rate(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", TIME=np.floor(_T * 20) / 20, angle=_Q, torque=np.cos(_T))
    made = _draft(tmp_path / "a.csv")
    (entry,) = made.tables["channels.time"].values()
    assert entry.value == pytest.approx(200.0, rel=0.01)
    assert not entry.sure
    assert "stamps of TIME are doubled" in entry.why
    assert made.rate == entry.value
    assert "TIME" not in _content(made).get("aux", {})


def test_numbers_without_their_sign_are_told(tmp_path: Path) -> None:
    load = np.round(300 * np.sin(_T)).astype(np.int64)
    builders.csv(tmp_path / "a.csv", **{"t [s]": _T}, angle=_Q, load=load % 65536, count=np.arange(_T.size) * 32)
    aux = _content(_draft(tmp_path / "a.csv"))["aux"]
    assert aux["load"]["signed_bits"] == 16
    assert not any("signed_bits" in table for name, table in aux.items() if name != "load")


def test_a_current_of_thousands_is_one_of_milliamperes(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", **{"t [s]": _T}, angle=_Q, motor_current=2000 * np.cos(_T))
    assert _content(_draft(tmp_path / "a.csv"))["channels"]["motor_torque"]["unit"] == "mA"


def test_a_goal_and_the_controllers_position_are_set_values(tmp_path: Path) -> None:
    wanted = {"goal_position": _Q, "CONTROL_POSITION": _Q, "CONTROL_VELOCITY": _Q}
    builders.csv(tmp_path / "a.csv", **{"t [s]": _T}, **wanted, position=0.5 * _Q, torque=np.cos(_T))
    content = _content(_draft(tmp_path / "a.csv"))
    assert content["channels"]["motor_angle"]["variable"] == "position"
    assert wanted.keys() <= content["channels"].keys()


@pytest.mark.parametrize("order", [("encoder A", "encoder B"), ("encoder B", "encoder A")])
def test_of_two_angles_without_a_side_the_slower_is_the_outputs_and_no_torque_is_needed(
    tmp_path: Path, order: tuple[str, str]
) -> None:
    values = {"encoder A": 1000 * _Q, "encoder B": -1000 * _Q / 1.9375 + 5}
    builders.csv(tmp_path / "a.csv", **{"t [s]": _T}, **{name: values[name] for name in order})
    made = _draft(tmp_path / "a.csv")
    channels = _content(made)["channels"]
    assert channels["motor_angle"]["variable"] == "encoder A"
    assert channels["load_angle"]["variable"] == "encoder B"
    assert made.lacking() == []


def test_of_two_angles_that_turn_alike_none_is_the_outputs(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", **{"t [s]": _T}, angle_1=_Q, angle_b=1.01 * _Q + 0.1)
    assert "load_angle" not in _content(_draft(tmp_path / "a.csv"))["channels"]


def test_no_rate_is_guessed_of_a_speed_that_is_not_the_angles(tmp_path: Path) -> None:
    builders.csv(tmp_path / "a.csv", **{"angle [rad]": _Q, "speed [rad/s]": np.sin(3.0 * _T), "torque [N*m]": _T})
    assert _content(_draft(tmp_path / "a.csv"))["channels"]["time"] == {"rate": "?"}


def _wrist(folder: Path, **columns: Any) -> dict[str, Any]:
    """The mapping that begins with a motor's speed, an output 81 times slower, and another joint."""
    builders.csv(
        folder / "a.csv",
        **{"t [s]": _T, "n_mot [1/min]": np.gradient(_Q, _T) * 30 / np.pi, "M [Ncm]": np.cos(_T), **columns},
    )
    return _content(_draft(folder / "a.csv"))


def test_an_angle_that_turns_slower_than_the_motor_is_the_outputs_and_gives_the_ratio(tmp_path: Path) -> None:
    content = _wrist(tmp_path, **{"position [deg]": np.degrees(_Q) / 81})
    assert content["channels"]["load_angle"]["variable"] == "position [deg]"
    assert "motor_angle" not in content["channels"]
    assert content["gearbox"] == {"ratio": 81.0}
    assert content["channels"]["motor_torque"]["unit"] == "Ncm"
    # what the name says comes before what the numbers say
    content = _wrist(tmp_path, **{"motor position [deg]": np.degrees(_Q) / 81})
    assert content["channels"]["motor_angle"]["variable"] == "motor position [deg]"


def test_a_speed_that_is_slower_than_the_angle_is_the_outputs(tmp_path: Path) -> None:
    speed = np.gradient(_Q, _T) / 7
    builders.csv(tmp_path / "a.csv", **{"t [s]": _T, "angle motor [rad]": _Q, "speed [rad/s]": speed})
    content = _content(_draft(tmp_path / "a.csv"))
    assert content["channels"]["load_velocity"]["variable"] == "speed [rad/s]"
    assert content["gearbox"] == {"ratio": 7.0}


def test_an_angle_that_turns_by_itself_is_another_joints_if_one_turns_with_the_speed(tmp_path: Path) -> None:
    elbow = 30 * np.sin(3.7 * _T)
    content = _wrist(tmp_path, **{"elbow_angle [deg]": elbow, "position [deg]": np.degrees(_Q)})
    assert content["channels"]["motor_angle"]["variable"] == "position [deg]"
    assert content["aux"]["elbow_angle"]["variable"] == "elbow_angle [deg]"
    # alone it may be the machine's: only another angle that goes with the speed says otherwise
    alone = _wrist(tmp_path, **{"elbow_angle [deg]": elbow})
    assert alone["channels"]["motor_angle"]["variable"] == "elbow_angle [deg]"


def test_stamps_are_shown_with_their_zone_or_that_they_say_none(tmp_path: Path) -> None:
    for zone, said in (("+01:00", "from 2026-03-02T07:15:00.000 to 2026-03-02T07:15:01.900 UTC"), ("", "say no zone")):
        stamps = [f"2026-03-02T08:15:{k / 10:06.3f}{zone}" for k in range(20)]
        builders.csv(tmp_path / f"a{len(zone)}.csv", **{"when": np.asarray(stamps), "torque [Nm]": _T[:20]})
        target = tmp_path / f"m{len(zone)}.toml"
        shown = CliRunner().invoke(
            make_app(), ["import", "--look", str(tmp_path / f"a{len(zone)}.csv"), "--mapping", str(target)]
        )
        assert said in shown.output.replace("\n", " ")
