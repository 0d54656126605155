from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from bench.cli import compare, compensate, identify
from bench.errors import BenchError, RecordingError
from bench.simulation import Simulation
from tests.bench.identification.synthetic import Bench, true_model
from tests.bench.importing import builders

RUNNER = CliRunner()


def _app() -> typer.Typer:
    app = typer.Typer()
    for module in (identify, compare, compensate):
        module.register(app)
    return app


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recordings")
    bench = Bench(path, rate=150.0)
    for torque in (-500.0, 0.0, 500.0):
        for d in (1, -1):
            bench.write(torque, float(d * np.deg2rad(10.0)), 30.0)
    bench.write(250.0, float(np.deg2rad(10.0)), 30.0, kind="validation")
    return path


def test_identify_writes_model_report_and_summary(folder: Path, tmp_path: Path) -> None:
    model, report = tmp_path / "model.json", tmp_path / "report"
    arguments = ["identify", str(folder), "--out", str(model), "--report", str(report), "--json", "--jobs", "1"]
    result = RUNNER.invoke(_app(), arguments, catch_exceptions=False)
    assert result.exit_code == 0
    summary = json.loads(result.stdout)
    assert summary["recordings"] == {"read": 7, "identification": 6, "validation": 1}
    assert summary["parameters"]["f_c"]["value"] == pytest.approx(0.5, rel=0.05)
    assert json.loads((report / "summary.json").read_text())["verdict"] == summary["verdict"]
    assert Simulation.load(model).transmission_error() is not None


def test_identify_prints_tables_and_sentences(folder: Path, tmp_path: Path) -> None:
    arguments = ["identify", str(folder), "--out", str(tmp_path / "m.json"), "--orders", "1,3,46", "--jobs", "1"]
    result = RUNNER.invoke(_app(), arguments, catch_exceptions=False)
    assert "not determined" in result.output
    assert "validation" in result.output
    fourier = Simulation.load(tmp_path / "m.json").terms["te.fourier"]
    assert fourier.orders == (1.0, 3.0, 46.0)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--orders", "1,x"], "numbers such as"),
        (["--orders", "0,3"], "from 1 to"),
        (["--notch", "7.297"], "whole numbers"),
        (["--figures", "all"], "should be paper"),
        (["--method", "best"], "refined or paper"),
    ],
)
def test_identify_refuses_wrong_options(folder: Path, tmp_path: Path, arguments: list[str], words: str) -> None:
    with pytest.raises(BenchError, match=words):
        RUNNER.invoke(
            _app(), ["identify", str(folder), "--out", str(tmp_path / "m"), *arguments], catch_exceptions=False
        )


def test_the_papers_figures_are_written_and_those_that_cannot_be_are_told(folder: Path, tmp_path: Path) -> None:
    arguments = ["identify", str(folder), "--out", str(tmp_path / "m.json"), "--orders", "1,3,7.297", "--jobs", "1"]
    result = RUNNER.invoke(_app(), [*arguments, "--figures", "paper"], catch_exceptions=False)
    assert result.exit_code == 0
    names = sorted(path.name for path in (tmp_path / "figures").iterdir())
    assert names == ["figure-4.png", "figure-5.png", "figure-6.png", "figure-7.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in (tmp_path / "figures").iterdir())
    fourier = Simulation.load(tmp_path / "m.json").terms["te.fourier"]
    assert fourier.orders == (1.0, 3.0, 7.297)
    bare = tmp_path / "bare"
    bare.mkdir()
    shutil.copy(sorted(folder.glob("*.h5"))[0], bare)
    arguments[1] = str(bare)
    result = RUNNER.invoke(_app(), [*arguments, "--figures", "paper"], catch_exceptions=False)
    assert "Figure 7 (a validation recording beside the models) cannot be drawn" in result.output


def test_compare_two_files(tmp_path: Path) -> None:
    for name, seed in (("a", 1), ("b", 2)):
        Simulation.nominal().with_transmission_error(true_model(seed=seed)).save(tmp_path / f"{name}.json")
    paths = [str(tmp_path / "a.json"), str(tmp_path / "b.json")]
    shown = RUNNER.invoke(_app(), ["compare", *paths, "--all"], catch_exceptions=False)
    assert "order 46" in shown.output
    found = json.loads(RUNNER.invoke(_app(), ["compare", *paths, "--json"], catch_exceptions=False).stdout)
    assert not any(change["changed"] for change in found["changes"])


def test_compensate_on_the_emulated_bench(tmp_path: Path) -> None:
    from importlib.metadata import entry_points

    from fakes.plant import Plant

    assert "emulated" in {entry.name for entry in entry_points(group="bench.masters")}
    truth = Plant.from_file("rh380n").truth
    rows = {"effect": "te.fourier", "parameters": truth.te_coefficients()}
    content = {"format": "bench-simulation", "format_version": "1.0", "terms": [rows]}
    path = tmp_path / "model.json"
    Simulation.from_json(content).save(path)
    arguments = ["compensate", str(path), "--point", "200,10", "--added", "--json", "--c", str(tmp_path / "c")]
    arguments += ["--loop", "0.6,0.02", "--table", str(tmp_path / "table.md")]
    result = RUNNER.invoke(_app(), arguments, catch_exceptions=False)
    figures = json.loads(result.stdout)
    (point,) = figures["points"]
    assert point["rmse"]["with"] < 0.1 * point["rmse"]["without"]
    assert point["speed"]["with"] < 0.4 * point["speed"]["without"]
    assert "| with / counting |" in (tmp_path / "table.md").read_text()
    assert point["rmse"]["added"] == pytest.approx(2.0 * point["rmse"]["without"], rel=0.1)
    assert len(figures["files"]) == 3


@pytest.mark.parametrize("text", ["700", "700,0", "a,b"])
def test_compensate_refuses_a_wrong_point(text: str, tmp_path: Path) -> None:
    Simulation.nominal().save(tmp_path / "m.json")
    with pytest.raises(BenchError, match="--point"):
        RUNNER.invoke(_app(), ["compensate", str(tmp_path / "m.json"), "--point", text], catch_exceptions=False)


@pytest.mark.parametrize("text", ["0.6", "0.6,0", "-1,0.02", "a,b"])
def test_compensate_refuses_a_wrong_loop(text: str, tmp_path: Path) -> None:
    Simulation.nominal().save(tmp_path / "m.json")
    with pytest.raises(BenchError, match="--loop"):
        RUNNER.invoke(_app(), ["compensate", str(tmp_path / "m.json"), "--loop", text], catch_exceptions=False)


def test_recordings_of_which_nothing_is_identified_give_no_simulation_file(tmp_path: Path) -> None:
    model = tmp_path / "model.json"
    builders.csv(tmp_path / "a.csv", t=np.arange(500) / 100, i=np.ones(500))
    builders.one(tmp_path, 'motor_torque = {variable = "i", unit = "N*m"}')
    done = RUNNER.invoke(_app(), ["identify", str(tmp_path / "out"), "--out", str(model), "--jobs", "1"])
    assert isinstance(done.exception, RecordingError)
    assert "nothing is identified, so no simulation file was written" in str(done.exception)
    assert "Friction is not identified" in done.output
    assert not model.exists()
