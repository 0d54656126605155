"""``bench run --conceal`` and ``bench prove --open``: the plant has what the seed says, recordings do not say so."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from bench.cli.app import make_app
from bench.configuration import concealing, load_bench
from bench.errors import ConfigurationError, ProofError
from bench.proof.seal import SEAL
from bench.recording import RecordingFolder
from bench.service.process.job import Job
from bench.service.process.main import Process
from fakes.plant import plant
from fakes.plant.spec import plant_of

CAMPAIGN = """
format = "bench-campaign"
format_version = "1.0"
name = "one"
title = "One reversal"

[[stages]]
name = "one"
order = "listed"

[[stages.points]]
sequence = "reversal"
velocities = ["10 deg/s"]
load_torques = ["200 N*m"]
options = { amplitude = "3 deg", cycles = 1 }
"""
SEED = 5
"""conceals something"""


def call(*arguments: str) -> Any:
    return CliRunner().invoke(make_app(), list(arguments), catch_exceptions=False)


def test_a_concealed_plant_runs_and_only_its_seal_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    campaign = tmp_path / "one.toml"
    campaign.write_text(CAMPAIGN, encoding="utf-8")
    hidden, plain = tmp_path / "hidden", tmp_path / "plain"
    played = []
    monkeypatch.setattr(plant, "plant_of", lambda name: played.append(name) or plant_of(name))
    assert call("run", str(campaign), "--out", str(hidden), "--conceal", str(SEED), "--json").exit_code == 0
    assert played == [f"rh380n?conceal={SEED}"]
    assert len(RecordingFolder.open(hidden).recordings) == 1
    opened = json.loads(call("prove", "--open", str(SEED), "--sealed", str(hidden), "--json").output)
    assert (hidden / SEAL).read_text("utf-8").strip() == opened["sha256"]
    told_of = [word for row in opened["concealed"] for word in (row["effect"], row["form"])]
    assert told_of
    for path in hidden.iterdir():
        content = path.read_bytes()
        assert not [word for word in ("conceal=", "kinds=", *told_of) if word.encode() in content], path
    with pytest.raises(ProofError, match="not of this seed"):
        call("prove", "--open", str(SEED + 1), "--sealed", str(hidden))
    plain.mkdir()
    with pytest.raises(ProofError, match="no seal"):
        call("prove", "--open", str(SEED), "--sealed", str(plain))


def test_a_seal_opens_to_words(tmp_path: Path) -> None:
    text = call("prove", "--open", str(SEED)).output
    assert text.startswith("seal ")
    assert "weak orders of the gearbox" in text


def test_the_service_s_run_process_plays_the_plant_of_its_job(tmp_path: Path) -> None:
    folder = str(tmp_path)
    job = Job("r1", "quick", "rh380n", folder, f"{folder}/s", f"{folder}/o", plant="rh380n?conceal=7")
    process = Process(job)
    assert process._file.configuration.bus.plant == "rh380n?conceal=7"
    assert "conceal" not in process._file.text


def test_only_an_emulated_bench_conceals() -> None:
    with pytest.raises(ConfigurationError, match="emulated plant only"):
        concealing(load_bench("rh380n-wire"), 1)
