"""The commands on recordings: what they print, and the exit codes scripts rely on."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner, Result

from bench.cli.app import make_app
from bench.errors import BenchError, RecordingError
from bench.recording import Recording, guarded
from tests.bench.recording import builders


def _bench(*arguments: object) -> Result:
    return CliRunner().invoke(make_app(), [str(argument) for argument in arguments])


def test_validate_counts_and_names(tmp_path: Path) -> None:
    good = builders.write(tmp_path / "good.h5")
    assert _bench("validate", good).exit_code == 0
    bad = builders.write(tmp_path / "bad.h5")
    with h5py.File(bad, "r+") as file:
        del file.attrs["kind"]
    result = _bench("validate", tmp_path)
    assert result.exit_code == 6
    assert f"{bad}: root attribute 'kind' is missing, it should be text." in result.stdout
    assert "2 files checked, 1 valid, 1 not valid" in result.stdout
    rows = json.loads(_bench("validate", tmp_path, "--json").stdout)
    assert [(Path(row["file"]).name, row["valid"]) for row in rows] == [("bad.h5", False), ("good.h5", True)]


def test_validate_missing_file_is_one_sentence(tmp_path: Path) -> None:
    result = _bench("validate", tmp_path / "none.h5")
    assert isinstance(result.exception, RecordingError)


def test_inspect_shows_all_and_draws(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    result = _bench("inspect", path)
    assert result.exit_code == 0
    for text in ("load_torque", "segment steady", "lubricant topped up", "recording format: valid", "5.72958 °/s"):
        assert text in result.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    shown = json.loads(_bench("inspect", path, "--json", "--no-plot").stdout)
    assert shown["channels"]["temperature"]["min"] == pytest.approx(30.0)
    assert (shown["rows"], shown["valid"], shown["plot"]) == (3000, True, None)


def test_inspect_shows_the_rest_of_a_damaged_recording(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path) as file:
        place = file["channels/load_torque"].id.get_chunk_info(0)
    with path.open("r+b") as raw:
        raw.seek(place.byte_offset)
        raw.write(bytes(place.size))
    result = _bench("inspect", path)
    assert result.exit_code == 6
    assert f"{path}: /channels/load_torque rows 0 to 3000 cannot be read" in result.stdout
    assert "load_angle" in result.stdout
    assert (tmp_path / "a.png").exists()


def test_inspect_and_repair_what_a_kill_left(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5")
    with h5py.File(path, "r+") as file:
        del file.attrs["complete"]
    part = path.rename(tmp_path / "a.h5.part")
    assert "cut short" in _bench("inspect", part, "--no-plot").stdout
    result = _bench("repair", tmp_path)
    assert result.exit_code == 0
    assert f"{path}: 3000 rows, cut short" in result.stdout
    assert not Recording.open(path).complete
    manifest = json.loads((tmp_path / "campaign.json").read_text())
    assert [entry["status"] for entry in manifest["recordings"]] == ["failed"]


@pytest.mark.parametrize("command", ["validate", "inspect", "export --to csv", "identify", "repair"])
def test_no_command_opens_a_file_in_its_own_process(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = builders.write(tmp_path / ("a.h5.part" if command == "repair" else "a.h5"))

    def crash(path: Path, *_: object, **__: object) -> None:
        raise RecordingError(f"{path}: reading it ended in a crash of the HDF5 library (SIGSEGV).")

    def open_here(*_: object, **__: object) -> None:
        raise AssertionError("a file was opened where a crash ends the program")

    monkeypatch.setattr(guarded, "call", crash)
    monkeypatch.setattr(h5py, "File", open_here)
    result = _bench(*command.split(), path.parent if command == "identify" else path)
    assert result.exit_code != 0
    assert isinstance(result.exception, (RecordingError, BenchError, SystemExit)), result.exception
    assert "ended in a crash of the HDF5 library" in f"{result.output} {result.exception}"


def test_repair_beyond_repair(tmp_path: Path) -> None:
    (tmp_path / "a.h5.part").write_bytes(b"nothing")
    result = _bench("repair", tmp_path / "a.h5.part")
    assert result.exit_code == 6
    assert "not a readable HDF5 file" in result.stdout


def test_export_and_import_go_round(tmp_path: Path) -> None:
    path = builders.write(tmp_path / "a.h5", rows=400)
    assert _bench("export", path, "--to", "csv", "--out", tmp_path / "csv").exit_code == 0
    (tmp_path / "map.toml").write_text(
        """
campaign_id = "back"
started_at = 2026-01-01T00:00:00Z
gearbox.ratio = 185.0
channels.time = {variable = "time [s]", unit = "s"}
channels.load_angle = {variable = "load_angle [rad]", unit = "rad"}
[[recordings]]
file = "a.csv"
""",
        encoding="utf-8",
    )
    result = _bench("import", tmp_path / "map.toml", "--data", tmp_path / "csv", "--out", tmp_path / "out", "--json")
    assert result.exit_code == 0, result.output
    (row,) = json.loads(result.stdout)
    assert row["channels"] == ["time", "load_angle"]
    back, original = Recording.open(tmp_path / "out/a.h5"), Recording.open(path)
    assert back.si("load_angle").tolist() == original.si("load_angle").tolist()
    again = _bench("import", tmp_path / "map.toml", "--data", tmp_path / "csv", "--out", tmp_path / "out")
    assert again.exit_code == 6
    assert "does not overwrite" in again.stdout


def test_import_has_a_line_a_file_and_says_once_what_is_missing(tmp_path: Path) -> None:
    time = 0.01 * np.arange(2000)
    for name in ("a", "b"):
        table = np.column_stack([time, 3.0 * time])
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header="t,q", comments="")
    (tmp_path / "map.toml").write_text(
        """
campaign_id = "rig"
started_at = 2026-01-01T00:00:00Z
gearbox.ratio = 10.0
pieces.seconds = 2.0
channels.time = {variable = "t", unit = "s"}
channels.load_angle = {variable = "q", unit = "rad"}
[[recordings]]
file = "a.csv"
[[recordings]]
file = "b.csv"
started_at = 2026-01-02T00:00:00Z
""",
        encoding="utf-8",
    )
    result = _bench("import", tmp_path / "map.toml", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    said = result.stdout.splitlines()
    for name in ("a", "b"):
        begin = (
            f"{tmp_path / 'out' / name}-01.h5 to {name}-10.h5: 10 recordings, 2000 rows (20.0 s) of time, load_angle"
        )
        assert said.count(begin) == 1, result.stdout
    lacks = [sentence for sentence in said if "no channel 'motor_torque'" in sentence]
    assert len(lacks) == 1, result.stdout
    assert lacks[0].startswith("in 2 of 2 files there is no channel 'motor_torque', so there is no ")
