"""After a stop: three acts, each by somebody; a record of the stop; nothing recorded before is lost."""

import json
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from bench.campaigns import parse_campaign
from bench.campaigns.execution.session import run_campaign
from bench.campaigns.listener import Silent
from bench.campaigns.operator.reset import reset
from bench.campaigns.records.journal import Journal
from bench.cli.app import make_app
from bench.configuration import BenchFile, load_bench, parse_bench
from bench.cycle.end import EndKind
from bench.errors import DeviceError, LimitError
from bench.recording import Recording
from bench.recording.validation import validate
from bench.safety import Standing, acts

TEXT = """
format = "bench-campaign"
format_version = "1.0"
name = "short"
title = "one loaded point"
[[stages]]
name = "s"
[[stages.points]]
sequence = "run_in"
velocities = ["10 deg/s"]
load_torques = ["LOAD N*m"]
options = { duration = "1 s" }
"""
CAMPAIGN = parse_campaign(TEXT.replace("LOAD", "300"), "short.toml")


@pytest.fixture(scope="module")
def file() -> BenchFile:
    return load_bench("rh380n")


@pytest.fixture(scope="module")
def tight(file: BenchFile) -> BenchFile:
    """A bench whose load may not change as fast as its own ramps do."""
    text = file.text.replace('load_torque_rate = "3 kN*m/s"', 'load_torque_rate = "300 N*m/s"')
    return parse_bench(text, "tight")


@pytest.fixture
def stopped(tight: BenchFile, tmp_path: Path) -> Path:
    summary = run_campaign(tight, CAMPAIGN, tmp_path)
    assert summary.end.kind is EndKind.TRIPPED
    return tmp_path


def test_a_stop_is_latched_in_the_folder_until_three_acts(stopped: Path, tight: BenchFile) -> None:
    with pytest.raises(LimitError, match="bench acknowledge"):
        run_campaign(tight, CAMPAIGN, stopped, resumed_by="me")
    with pytest.raises(LimitError, match="acknowledge comes first"):
        reset(tight, stopped, "me")
    assert acts.acknowledge(tight, stopped, "me").standing is Standing.ACKNOWLEDGED
    assert reset(tight, stopped, "me").standing is Standing.RESET
    with pytest.raises(LimitError, match="--resume"):
        run_campaign(tight, CAMPAIGN, stopped)
    assert run_campaign(tight, CAMPAIGN, stopped, resumed_by="me").end.kind is EndKind.TRIPPED
    assert acts.latch_of(tight, stopped).read().standing is Standing.STOPPED
    assert len(list(stopped.glob("stop-*.json"))) == 2


def test_a_stop_leaves_a_record(stopped: Path) -> None:
    (path,) = stopped.glob("stop-*.json")
    record: dict[str, Any] = json.loads(path.read_text())
    assert record["cause"] == "LOAD_TORQUE_RATE"
    assert "load_torque_rate" in record["text"]
    assert [rung["rung"] for rung in record["rungs"]] == ["disable voltage"]
    assert record["to_rest_s"] <= sum(rung["lasted_s"] for rung in record["rungs"]) == pytest.approx(record["lasted_s"])
    assert record["drives"] == {"input_drive": "SWITCH_ON_DISABLED", "load_drive": "SWITCH_ON_DISABLED"}
    times = [sample["time_s"] for sample in record["coast_down"]]
    assert times == sorted(times)
    (file,) = stopped.glob("*.h5")
    assert record["recording"] == file.stem
    assert validate(file).valid
    texts = [event.text for event in Recording.open(file).events]
    assert any(text.startswith("stop: at rest after") for text in texts)


def test_reset_is_refused_while_the_cause_is_there(file: BenchFile, tmp_path: Path) -> None:
    hot = parse_bench(file.text.replace('temperature = "70 degC"', 'temperature = "15 degC"'), "hot")
    acts.latch_of(hot, tmp_path).write(acts.latch_of(hot, tmp_path).read().stopped("TEMPERATURE_HIGH", "hot", ""))
    acts.acknowledge(hot, tmp_path, "me")
    with pytest.raises(LimitError, match=r"limits\.temperature"):
        reset(hot, tmp_path, "me")


def test_a_script_may_do_what_the_bench_file_names_and_no_more(
    stopped: Path, tight: BenchFile, tmp_path_factory: pytest.TempPathFactory
) -> None:
    app, runner = make_app(), CliRunner()
    path = tmp_path_factory.mktemp("bench") / "mine.toml"
    path.write_text(tight.text)
    refused = runner.invoke(app, ["acknowledge", str(stopped), "--bench", str(path)])
    assert isinstance(refused.exception, LimitError)
    assert "unattended.may" in str(refused.exception)
    path.write_text(tight.text.replace("may = []", 'may = ["acknowledge"]'))
    done = runner.invoke(app, ["acknowledge", str(stopped), "--bench", str(path), "--json"])
    assert json.loads(done.output)["standing"] == "acknowledged"
    refused = runner.invoke(app, ["reset", str(stopped), "--bench", str(path)])
    assert isinstance(refused.exception, LimitError)


@pytest.mark.parametrize("text", ["the journal is not readable.", "the journal is not readable"])
def test_the_question_before_a_stop_is_acknowledged_has_one_full_stop(
    text: str, file: BenchFile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    acts.latch_of(file, tmp_path).stopped("operator", text, datetime.now(UTC))
    asked: list[str] = []
    monkeypatch.setattr("bench.cli._operator.somebody", lambda _bench, _act, question: asked.append(question) or "me")
    assert CliRunner().invoke(make_app(), ["acknowledge", str(tmp_path)]).exit_code == 0
    assert asked == ["The bench was stopped: the journal is not readable. Acknowledge?"]


def test_without_a_folder_an_emulated_run_is_asked_for() -> None:
    refused = CliRunner().invoke(make_app(), ["reset"])
    assert "folder" in str(refused.exception)


def test_a_clear_bench_has_nothing_to_acknowledge(file: BenchFile, tmp_path: Path) -> None:
    with pytest.raises(LimitError, match="nothing is latched"):
        acts.acknowledge(file, tmp_path, "me")
    assert reset(file, tmp_path, "me").standing is Standing.CLEAR
    assert replace(acts.latch_of(file, tmp_path).read(), acts=()).standing is Standing.CLEAR


def test_a_folder_that_goes_on_with_another_zero_says_so(file: BenchFile, tmp_path: Path) -> None:
    class Ears(Silent):
        def __init__(self) -> None:
            self.heard: list[str] = []

        def noticed(self, text: str) -> None:
            self.heard.append(text)

    with Journal(tmp_path, CAMPAIGN, file) as journal:
        journal.remember("zero", "another")
    ears = Ears()
    run_campaign(file, CAMPAIGN, tmp_path, ears)
    assert any("zero another" in text and str(file.configuration.zero_id) in text for text in ears.heard)
    (recording,) = tmp_path.glob("*.h5")
    assert Recording.open(recording).zero_id == file.configuration.zero_id


def test_two_runs_do_not_share_a_folder(file: BenchFile, tmp_path: Path) -> None:
    with Journal(tmp_path, CAMPAIGN, file), pytest.raises(DeviceError, match="in use by a run in process"):
        run_campaign(file, CAMPAIGN, tmp_path)
    assert run_campaign(file, CAMPAIGN, tmp_path).end.kind is EndKind.FINISHED
