from __future__ import annotations

import json
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from bench.cli import prove as command
from bench.proof import analyse, make
from bench.proof.analyse import Job
from tests.bench.proof.conftest import SmallExaminer


@pytest.fixture
def app(monkeypatch: pytest.MonkeyPatch) -> typer.Typer:
    def silent(job: Job, name: str, target: Path) -> str:
        noise = make.read_truth(job.out / make.TRUTHS / f"{name}.json")["noise_rms"]
        rows = [{"channel": channel, "held_out_rmse_after": rms} for channel, rms in noise.items()]
        target.mkdir(parents=True)
        (target / "report.json").write_text(json.dumps({"verdict": "match", "findings": [], "channels": rows}))
        return ""

    monkeypatch.setattr(make, "load_examiner", lambda: SmallExaminer)
    monkeypatch.setattr(analyse, "_run", silent)
    made = typer.Typer()
    command.register(made)
    made.command("other")(lambda: None)
    return made


def test_make_only_seals_and_analyses_nothing(app: typer.Typer, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["prove", "--make-only", "--set", "null", "--count", "1", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    folder, told = result.output.splitlines()
    assert list(Path(folder).glob("*.h5"))
    truths = Path(told.removeprefix("what is in each: "))
    assert make.read_truth(truths / f"{Path(folder).name}.json")["verdict"] == "match"
    assert not list(tmp_path.rglob("report.json"))


def test_table_and_json_say_the_same(app: typer.Typer, tmp_path: Path) -> None:
    table = tmp_path / "table.md"
    arguments = ["prove", "--set", "null,switched_off", "--count", "1", "--out", str(tmp_path), "--table", str(table)]
    result = CliRunner().invoke(app, [*arguments, "--json"])
    assert result.exit_code == 0, result.output
    content = json.loads(result.stdout)
    assert [case["every_point_right"] for case in content["cases"]] == [True, False]
    text = table.read_text(encoding="utf-8")
    assert "| null | 1 | 1/1 |" in text
    assert "| switched_off | 1 | 0/1 |" in text
    assert content["seal"] in text


def test_sweep_picks_the_effects_asked_for(app: typer.Typer, tmp_path: Path) -> None:
    arguments = [
        "prove",
        "--severity",
        "--effects",
        "friction.viscous_quadratic",
        "--strengths",
        "0.2",
        "--repeats",
        "2",
    ]
    result = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "| friction.viscous_quadratic | 2 |" in result.output
