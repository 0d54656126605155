from __future__ import annotations

import json
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from bench.cli import prove as command
from bench.proof import analyse, make, recompute, seal
from tests.bench.proof.conftest import BlindAnalyser, SmallExaminer, each, smoothed


@pytest.fixture
def app(monkeypatch: pytest.MonkeyPatch) -> typer.Typer:
    monkeypatch.setattr(make, "load_examiner", lambda: SmallExaminer)
    monkeypatch.setattr(analyse, "_run", BlindAnalyser())
    monkeypatch.setattr(recompute, "predictor", lambda: each(smoothed))
    made = typer.Typer()
    command.register(made)
    made.command("other")(lambda: None)
    return made


def test_make_only_seals_and_analyses_nothing(app: typer.Typer, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["prove", "--make-only", "--set", "null", "--count", "1", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    folder, notice = result.output.splitlines()
    assert list(Path(folder).glob("*.h5"))
    truths = Path(notice.removeprefix("what is in each: "))
    (truth,) = (seal.read_truth(path) for path in truths.glob("*.json"))
    assert truth["verdict"] == "match"
    assert truth["folder"] == Path(folder).name
    assert not list(tmp_path.rglob("report.json"))


def test_a_plant_is_not_made_and_left(app: typer.Typer, tmp_path: Path) -> None:
    """What a plant conceals is written down after its analysis, so that nothing can be made beforehand."""
    done = CliRunner().invoke(app, ["prove", "--through-the-bench", "--make-only", "--out", str(tmp_path)])
    assert done.exit_code != 0
    assert "--make-only does not go with --through-the-bench" in str(done.exception) + done.output


def test_table_and_json_say_the_same(app: typer.Typer, tmp_path: Path) -> None:
    table = tmp_path / "table.md"
    arguments = ["prove", "--set", "null,switched_off", "--count", "1", "--out", str(tmp_path), "--table", str(table)]
    result = CliRunner().invoke(app, [*arguments, "--json"])
    assert result.exit_code == 0, result.output
    content = json.loads(result.stdout)
    assert [case["every_point_right"] for case in content["cases"]] == [True, False]
    text = table.read_text(encoding="utf-8")
    assert "| null | 1 | 1 | 1/1 |" in text
    assert "| switched_off | 1 | 1 | 0/1 |" in text
    assert content["provenance"]["seal"] in text
    assert content["provenance"]["asked"] == {"null": 1, "switched_off": 1}
    more = [*arguments, "--nulls", "2", "--done", "--store", str(tmp_path / "kept.json")]
    done = CliRunner().invoke(app, more)
    assert "| null | 2 | 1 | 1/1 |" in done.output
    assert len(json.loads((tmp_path / "kept.json").read_text())["cases"]) == 2


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
