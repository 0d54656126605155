"""An investigation over HTTP: what it asks for waits for a yes, is run, and is answered; or it is ended."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from bench.configuration import load_bench
from bench.errors import LimitError
from bench.service.analyses import experimenting
from bench.service.analyses.analyses import open_findings
from bench.service.analyses.experimenting import AskingLab
from bench.service.analyses.experiments import may_go_alone
from bench.service.runs.runs import Run
from tests.bench.service.conftest import Client
from tests.bench.service.test_joining import CAMPAIGN

AFTER = datetime(2026, 11, 3, 9, tzinfo=UTC)
WORKER = """
import json, pathlib, sys
work = json.loads(pathlib.Path(sys.argv[1]).read_text())
out = pathlib.Path(work["out"])
def say(**told):
    print(json.dumps(told), flush=True)
number = 0
while number < work["asked"]["experiments"]:
    number += 1
    plan = {"points": 4, "tasks": []}
    campaign, folder = str(out / f"experiment-{number}.toml"), str(out / f"experiment-{number}")
    asks = {"number": number, "campaign": campaign, "folder": folder, "plan": plan}
    asks["after"] = "2026-11-03T09:00:00+00:00"
    say(what=f"experiment {number} waits", share=0.5, asks=asks)
    answer = json.loads(sys.stdin.readline())
    if "problem" in answer:
        say(what=answer["problem"], share=1.0, ended="failed")
        sys.exit(1)
    hours = answer["bench_time_s"] / 3600
    (out / "investigation.json").write_text(json.dumps({"steps": [{"number": number, "took_h": hours}]}))
    (out / "said.txt").write_text("09:00 looks\\n09:30 looks again\\n")
say(what="all is named", share=1.0, ended="done")
"""


@pytest.fixture
def asking(client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Client:
    """A service whose investigations only ask: looking and designing is another matter."""
    worker = tmp_path / "worker.py"
    worker.write_text(WORKER, "utf-8")
    monkeypatch.setattr("bench.service.analyses.analyses.WORKER", (str(worker),))
    (tmp_path / "recordings" / "spring").mkdir(parents=True)
    return client


def begun(client: Client, **more: Any) -> str:
    return str(client.ask("analyses", name="Ann", kind="investigate", folder="spring", investigation=more)["id"])


def one(client: Client) -> dict[str, Any]:
    found: dict[str, Any] = client.state("analyses")["analyses"][0]
    return found


def last_run(client: Client) -> dict[str, Any]:
    runs = client.state("runs")["runs"]
    return dict(runs[-1]) if runs else {}


def end(client: Client, **how: Any) -> None:
    """End the run as its process would."""
    service = client.http.app.state.service  # type: ignore[attr-defined]
    run = last_run(client)
    service.keeper.runs.change(run["id"], state="ended", end={"text": "", **how})


def test_an_experiment_waits_for_a_yes_and_its_hours_come_back(asking: Client) -> None:
    made = begun(asking, experiments=1, hours=3.0)
    asking.until(lambda: one(asking)["asks"].get("run"))
    run = last_run(asking)
    assert (run["state"], run["not_before"], run["seed"]) == ("proposed", "2026-11-03T09:00:00+00:00", 1)
    assert run["folder"].endswith(f"{made}/experiment-1")
    assert one(asking)["asks"]["plan"]["points"] == 4
    assert not asking.launcher.jobs
    # the yes is an act of whoever holds the controls
    asking.ask(f"runs/{run['id']}/approve", 403, secret="not-the-one")
    end(asking, kind="finished", bench_time_s=5400.0)
    asking.until(lambda: one(asking)["state"] == "done")
    assert one(asking)["what"] == "all is named"
    assert one(asking)["asks"] == {}
    steps = asking.get(f"analyses/{made}/steps")
    assert steps["log"]["steps"] == [{"number": 1, "took_h": 1.5}]
    assert steps["said"] == ["09:00 looks", "09:30 looks again"]


def test_later_ones_begin_alone_only_where_it_was_asked_for(asking: Client) -> None:
    begun(asking, experiments=2, alone=True)
    asking.until(lambda: one(asking)["asks"].get("run"))
    assert last_run(asking)["state"] == "proposed"
    end(asking, kind="finished", bench_time_s=60.0)
    asking.until(lambda: one(asking)["asks"].get("number") == 2)
    assert last_run(asking)["state"] in ("queued", "running")


def test_ending_it_takes_what_waits_out_of_the_queue(asking: Client) -> None:
    made = begun(asking, experiments=1)
    asking.until(lambda: one(asking)["asks"].get("run"))
    asking.ask(f"analyses/{made}/cancel", name="Bea")
    asking.until(lambda: one(asking)["state"] == "cancelled")
    run = last_run(asking)
    assert (run["state"], run["end"]["kind"]) == ("ended", "withdrawn")
    assert "Bea" in run["end"]["text"]
    assert one(asking)["asks"] == {}


def test_a_run_that_comes_to_no_end_ends_it_with_the_reason(asking: Client) -> None:
    begun(asking, experiments=1)
    asking.until(lambda: one(asking)["asks"].get("run"))
    end(asking, kind="tripped", text="the lubricant is too warm")
    asking.until(lambda: one(asking)["state"] == "failed")
    assert "the lubricant is too warm" in one(asking)["what"]


def test_what_does_not_go_together_is_refused(asking: Client) -> None:
    refused = asking.ask("analyses", 422, name="Ann", kind="mismatch", folder="spring", investigation={})
    assert "goes with the kind investigate" in refused["problem"]
    assert "no investigation" in asking.http.get("/api/analyses/nothing/steps").text


def test_a_bench_behind_an_interface_asks_each_time_unless_its_file_says_otherwise() -> None:
    emulated = load_bench("rh380n").configuration
    assert may_go_alone(emulated)
    wired = emulated.model_copy(update={"bus": emulated.bus.model_copy(update={"master": "soem"})})
    assert not wired.bus.in_process
    assert not may_go_alone(wired)
    may = wired.unattended.model_copy(update={"may": ("experiment",)})
    assert may_go_alone(wired.model_copy(update={"unattended": may}))


def test_the_lab_asks_with_a_plan_and_takes_the_answer(tmp_path: Path) -> None:
    campaign = tmp_path / "experiment-2.toml"
    campaign.write_text(CAMPAIGN, "utf-8")
    messages: list[dict[str, Any]] = []
    answers = iter(['{"bench_time_s": 1800.0}\n', '{"problem": "refused by Ann"}\n', ""])

    def report_progress(what: str, **more: Any) -> None:
        messages.append({"what": what, **more})

    lab = AskingLab(load_bench("rh380n").configuration, report_progress, lambda: next(answers))
    assert lab.celsius(40.0) == lab.bench.nominal.ambient_temperature
    assert lab.run(campaign, tmp_path / "experiment-2", AFTER) == 0.5
    asks = messages[0]["asks"]
    assert (asks["number"], asks["after"]) == (2, "2026-11-03T09:00:00+00:00")
    assert asks["plan"]["points"] == len([task for task in asks["plan"]["tasks"] if not task["preparation"]]) > 0
    with pytest.raises(LimitError, match="experiment 2: refused by Ann"):
        lab.run(campaign, tmp_path / "experiment-2", AFTER)
    with pytest.raises(LimitError, match="the service ended"):
        lab.run(campaign, tmp_path / "experiment-2", AFTER)


def test_the_last_look_is_the_report_of_the_investigation(tmp_path: Path) -> None:
    for number in (0, 2, 10):
        look = tmp_path / f"look-{number}"
        look.mkdir()
        for name in ("report.html", "report.json", "model.json"):
            (look / name).write_text(f"look {number}", "utf-8")
    (tmp_path / "look-10" / "report.html").unlink()
    experimenting._show_last_look(tmp_path)
    assert (tmp_path / "report.html").read_text("utf-8") == "look 2"


def test_findings_that_are_open_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "report.json"
    assert open_findings(path) == 0
    found = [("named", 0.9), ("named", 0.6), ("ambiguous", None), ("unknown", 0.99), ("named", None)]
    path.write_text(json.dumps({"findings": [{"status": s, "confidence": c} for s, c in found]}), "utf-8")
    assert open_findings(path) == 3


def test_a_run_of_an_experiment_is_told_when_it_may_begin(tmp_path: Path) -> None:
    from bench.service.process.job import Job
    from bench.service.runs.jobs import write_job

    run = Run("r", "quick", "q", "rh380n", str(tmp_path), "Ann", "", not_before=AFTER.isoformat())
    job = Job.load(write_job(run, tmp_path / "run", tmp_path / "socket", 0))
    assert job.not_before == AFTER.isoformat()
