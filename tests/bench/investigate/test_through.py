"""The whole way on an emulated bench that conceals something: look, ask, run, look again; and going on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.configuration import load_bench, parse_bench
from bench.errors import ConfigurationError
from bench.investigate.loop import require_same_gearbox
from bench.proof.through.run import plant_named, run_on
from bench.recording import RecordingFolder

CAMPAIGN = """
format = "bench-campaign"
format_version = "1.0"
name = "first"
title = "Half a revolution at two speeds, no staircase"

[[stages]]
name = "points"
order = "listed"

[[stages.points]]
sequence = "constant_velocity"
load_torques = ["-600 N*m", "600 N*m"]
velocities = ["10 deg/s", "-10 deg/s", "7 deg/s", "-7 deg/s"]
options = { revolutions = 0.3 }
"""


def _bench_with(plant: str, path: Path) -> Path:
    """A bench file whose emulated plant is another."""
    text = load_bench("rh380n").text
    changed = text.replace('plant = "rh380n"', f'plant = "{plant}"')
    assert changed != text
    path.write_text(changed, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def concealed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Recordings of a plant with one concealed effect, and the bench file that goes on with it."""
    place = tmp_path_factory.mktemp("through")
    (place / "first.toml").write_text(CAMPAIGN, encoding="utf-8")
    plant = plant_named("conceal=7&kinds=gain&weak=0")
    run_on(plant, place / "first", 3, place / "first.toml")
    return place / "first", _bench_with(plant, place / "bench.toml")


def test_an_experiment_is_run_and_looked_at_together_with_the_first_campaign(
    concealed: tuple[Path, Path], tmp_path: Path
) -> None:
    folder, bench = concealed
    # so sure is nothing: there is a question in any case, and one experiment
    asked = ["investigate", str(folder), "--out", str(tmp_path), "--bench", str(bench), "--confidence", "0.9"]
    done = CliRunner().invoke(make_app(), [*asked, "--experiments", "1", "--json"])
    assert done.exit_code == 0, done.output
    content: dict[str, Any] = json.loads((tmp_path / "investigation.json").read_text("utf-8"))
    assert content["format"] == "bench-investigation"
    assert content["ended"]
    (step,) = content["steps"]
    made = RecordingFolder.open(tmp_path / "experiment-1").recordings
    assert len(made) >= len(step["points"])
    # the same data set: behind what was recorded before, and all of it in the second look
    before = RecordingFolder.open(folder).recordings
    assert min(r.started_at for r in made) > max(r.started_at for r in before)
    look = json.loads((tmp_path / "look-1" / "report.json").read_text("utf-8"))["recordings"]
    assert len(look["train"]) + len(look["held_out"]) + len(look["rejected"]) == len(before) + len(made)
    assert step["took_h"] == pytest.approx(step["expected_h"], rel=0.5)
    page = (tmp_path / "investigation.md").read_text("utf-8")
    assert "expected gain" in page
    assert "what came" in page


def test_another_gearbox_is_refused_by_name(concealed: tuple[Path, Path]) -> None:
    folder, bench = concealed
    text = bench.read_text("utf-8").replace("RH380-0417", "RH380-9999")
    other = parse_bench(text, "other").configuration
    with pytest.raises(ConfigurationError, match="RH380-9999"):
        require_same_gearbox(folder, other)
