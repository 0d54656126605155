"""``bench run --conceal`` and ``bench prove --open``: the plant has what the seed says, recordings do not say so."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from bench.campaigns import load_campaign
from bench.campaigns.records.journal import Journal
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


def make(folder: Path, tmp_path: Path, *more: str) -> Any:
    """Run the small campaign into a folder."""
    campaign = tmp_path / "one.toml"
    campaign.write_text(CAMPAIGN, encoding="utf-8")
    return call("run", str(campaign), "--out", str(folder), "--json", *more)


def content_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_folder_keeps_the_seal_of_its_recordings(tmp_path: Path) -> None:
    folder = tmp_path / "hidden"
    assert make(folder, tmp_path, "--conceal", str(SEED)).exit_code == 0
    before = content_of(folder)
    with pytest.raises(ConfigurationError, match=r"hidden is sealed \(concealed.sha256\) with another hash"):
        make(folder, tmp_path, "--conceal", str(SEED + 1))
    with pytest.raises(ConfigurationError, match=r"hidden is sealed.*give the same --conceal as before"):
        make(folder, tmp_path)
    assert content_of(folder) == before
    assert make(folder, tmp_path, "--conceal", str(SEED)).exit_code == 0
    assert call("prove", "--open", str(SEED), "--sealed", str(folder)).exit_code == 0


def test_recordings_made_without_concealment_get_no_seal(tmp_path: Path) -> None:
    folder = tmp_path / "plain"
    folder.mkdir()
    (folder / "0001-reversal.h5.part").write_bytes(b"")
    with pytest.raises(ConfigurationError, match="plain holds recordings that were made without --conceal"):
        make(folder, tmp_path, "--conceal", str(SEED))
    assert [path.name for path in folder.iterdir()] == ["0001-reversal.h5.part"]


def test_a_folder_of_another_campaign_is_not_sealed(tmp_path: Path) -> None:
    folder = tmp_path / "other"
    with Journal(folder, load_campaign("quick"), load_bench("rh380n")):
        pass
    with pytest.raises(ConfigurationError, match='not made with campaign "one" as it is now'):
        make(folder, tmp_path, "--conceal", str(SEED))
    assert not (folder / SEAL).exists()


def test_a_journal_is_of_one_plant_and_does_not_name_it(tmp_path: Path) -> None:
    campaign, bench = load_campaign("quick"), load_bench("rh380n")
    with Journal(tmp_path, campaign, concealing(bench, SEED)):
        pass
    for other in (bench, concealing(bench, SEED + 1)):
        with pytest.raises(ConfigurationError, match="the plant that plays the bench now"):
            Journal(tmp_path, campaign, other)
    with Journal(tmp_path, campaign, concealing(bench, SEED)):
        pass
    assert not any(b"conceal" in content for content in content_of(tmp_path).values())


def test_an_investigation_keeps_the_seal(tmp_path: Path) -> None:
    folder = tmp_path / "hidden"
    assert make(folder, tmp_path, "--conceal", str(SEED)).exit_code == 0
    for more, sentence in (
        ((), "give the same --conceal as before"),
        (("--conceal", str(SEED + 1)), "with another hash"),
    ):
        with pytest.raises(ConfigurationError, match=sentence):
            call("investigate", str(folder), "--out", str(tmp_path / "out"), "--plan-only", *more)
    assert not (tmp_path / "out").exists()
