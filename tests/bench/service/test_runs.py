"""The queue: one run at a time, in order, proposed without the controls, once per request id, kept over a restart."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path

from starlette.testclient import TestClient

from bench.campaigns import load_campaign
from bench.campaigns.records.journal import Journal
from bench.configuration import load_bench, on_interface
from bench.proof.seal import SEAL, opened, seal
from bench.safety.acts import latch_of
from bench.service.settings import Settings
from tests.bench.service.conftest import BASE, Client, NoLauncher, made_app

SHORT = """
format = "bench-campaign"
format_version = "1.0"
name = "sent"
title = "Sent as text"
[[stages]]
name = "one"
[[stages.points]]
sequence = "constant_velocity"
velocities = ["60 deg/s"]
"""


def test_runs_wait_their_turn(client: Client) -> None:
    client.take()
    first = client.ask("runs", name="Ann", secret=client.secret, campaign="quick", real_time=True)
    second = client.ask("runs", name="Ann", secret=client.secret, text=SHORT, folder="second")
    client.until(lambda: client.launcher.jobs)
    runs = {run["id"]: run for run in client.state("runs")["runs"]}
    assert (runs[first["id"]]["state"], runs[second["id"]]["state"]) == ("running", "queued")
    assert client.launcher.jobs[0]["real_time"]
    assert second["folder"].endswith("second")
    client.ask(f"runs/{second['id']}/withdraw", secret=client.secret)
    assert {run["state"] for run in client.state("runs")["runs"]} == {"running", "ended"}
    assert len(client.launcher.jobs) == 1


def test_the_same_request_twice_is_one_run(client: Client) -> None:
    client.take()
    body = {"request_id": "the-very-same", "name": "Ann", "secret": client.secret, "campaign": "quick"}
    answers = [client.http.post("/api/runs", json=body).json() for _ in range(3)]
    assert answers[0] == answers[1] == answers[2]
    assert len(client.state("runs")["runs"]) == 1
    other = client.http.post("/api/runs", json={**body, "campaign": "paper"})
    assert other.status_code == 409
    assert "was used for another request" in other.json()["problem"]


def test_without_the_controls_a_run_is_proposed_and_waits_for_the_operator(client: Client) -> None:
    proposed = client.ask("runs", name="Bob", campaign="quick")
    assert proposed["state"] == "proposed"
    assert not client.launcher.jobs
    client.take("Ann")
    assert "approve" in client.state("state")["allowed"]
    client.ask(f"runs/{proposed['id']}/approve", secret=client.secret)
    client.until(lambda: client.launcher.jobs)
    assert any(entry["act"] == "approve" and "Bob" in entry["text"] for entry in client.get("book"))


def test_a_campaign_that_would_break_a_limit_is_never_queued(client: Client) -> None:
    client.take()
    wrong = SHORT.replace("60 deg/s", "600 deg/s")
    problem = client.ask("runs", 422, name="Ann", secret=client.secret, text=wrong)["problem"]
    assert "limits.motor_speed" in problem
    assert (
        "sequence" in client.ask("runs", 422, name="Ann", text=SHORT.replace("constant_velocity", "dance"))["problem"]
    )
    assert "there are quick" in client.ask("runs", 404, name="Ann", campaign="dance")["problem"]
    client.ask("runs", 409, name="Ann")
    assert client.state("runs")["runs"] == []


def with_two_runs(http: TestClient, launcher: NoLauncher) -> Client:
    """Somebody with the controls, one run that goes and one that waits for it."""
    client = Client(http, launcher)
    client.take()
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.ask("runs", name="Ann", secret=client.secret, campaign="paper")
    client.until(lambda: launcher.jobs)
    return client


def test_a_run_goes_on_when_the_service_is_started_anew(tmp_path: Path) -> None:
    settings, launcher = Settings(folder=tmp_path / "recordings"), NoLauncher()
    with TestClient(made_app(settings, launcher), base_url=BASE) as http:
        with_two_runs(http, launcher)
    assert launcher.processes[0].poll() is None
    again = NoLauncher()
    again.processes = launcher.processes
    with TestClient(made_app(settings, again), base_url=BASE) as http:
        second = Client(http, again)
        states = [run["state"] for run in second.state("runs")["runs"]]
        assert states == ["running", "queued"]
        launcher.processes[0].kill()
        # how it ended is not known to the new service; the queue waits for the operator
        second.until(lambda: second.state("state")["alarms"])
        assert second.state("runs")["held"]
    launcher.end_all()


def test_a_stop_and_its_alarm_outlive_the_service(tmp_path: Path) -> None:
    settings, launcher = Settings(folder=tmp_path / "recordings"), NoLauncher()
    with TestClient(made_app(settings, launcher), base_url=BASE) as http:
        first = with_two_runs(http, launcher)
        launcher.end_all()
        first.until(lambda: first.state("state")["alarms"])
        alarms = first.state("state")["alarms"]
    again = NoLauncher()
    with TestClient(made_app(settings, again), base_url=BASE) as http:
        second = Client(http, again)
        assert second.state("state")["alarms"] == alarms
        assert second.state("runs")["held"]
        assert [run["state"] for run in second.state("runs")["runs"]] == ["ended", "queued"]
        assert not again.jobs
        second.take()
        second.ask(f"alarms/{alarms[0]['number']}/acknowledge", secret=second.secret)
        assert second.state("state")["alarms"] == []
        second.ask("queue/go-on", secret=second.secret)
        second.until(lambda: again.jobs)
    again.end_all()


def test_a_stop_by_a_run_from_elsewhere_is_acknowledged_and_reset_on_the_page(tmp_path: Path) -> None:
    settings, launcher = Settings(interface="eth9", folder=tmp_path / "recordings"), NoLauncher()
    latch = latch_of(on_interface(load_bench("rh380n"), "eth9"), tmp_path)
    latch.stopped("MOTOR_SPEED", "too fast", datetime.now(UTC))
    with TestClient(made_app(settings, launcher), base_url=BASE) as http:
        client = Client(http, launcher)
        client.take()
        (alarm,) = client.state("state")["alarms"]
        assert (alarm["cause"], alarm["text"]) == ("MOTOR_SPEED", "too fast")
        assert "start" not in client.state("state")["allowed"]
        client.ask("reset", 409, secret=client.secret, run=None)
        client.ask(f"alarms/{alarm['number']}/acknowledge", secret=client.secret)
        assert "reset" in client.state("state")["allowed"]
        client.ask("reset", secret=client.secret, run=None)
        client.until(lambda: launcher.jobs)
        job = launcher.jobs[0]
        assert (job["reset_by"], job["interface"], job["bench"]) == ("Ann", "eth9", "rh380n")
    launcher.end_all()


def test_a_folder_of_another_campaign_is_refused_before_anything_is_queued(client: Client, tmp_path: Path) -> None:
    Journal(tmp_path / "recordings" / "first", load_campaign("short"), load_bench("rh380n")).close()
    client.take()
    asked = client.ask("runs", 422, name="Ann", secret=client.secret, campaign="quick", folder="first")
    assert "not made with campaign" in asked["problem"]
    assert client.state("runs")["runs"] == client.state("state")["alarms"] == []
    client.ask("runs", name="Ann", secret=client.secret, campaign="short", folder="first")


def test_what_a_report_asks_for_next_is_offered(client: Client, tmp_path: Path) -> None:
    report = tmp_path / "recordings" / ".service" / "analyses" / "20261121T160000-abcdef"
    report.mkdir(parents=True)
    (report / "analysis.json").write_text(json.dumps({"folder": "mystery"}))
    (report / "next-1.toml").write_text(SHORT)
    offered = {one["name"]: one["title"] for one in client.get("campaigns")}
    assert offered["next-1 of 20261121T160000-abcdef"] == "Sent as text, asked for by the report on mystery"
    client.take()
    client.ask("runs", name="Ann", secret=client.secret, campaign="next-1 of 20261121T160000-abcdef")
    client.until(lambda: client.launcher.jobs)
    assert client.launcher.jobs[0]["campaign"] == str(report / "next-1.toml")


def test_the_book_says_that_the_service_was_killed(tmp_path: Path) -> None:
    settings, launcher = Settings(folder=tmp_path / "recordings"), NoLauncher()
    with TestClient(made_app(settings, launcher), base_url=BASE):
        pass
    with TestClient(made_app(settings, launcher), base_url=BASE) as http:
        assert not [one for one in Client(http, launcher).get("book") if "without a word" in one["text"]]
    log = settings.state / "log.jsonl"
    # a service that is killed does not come to write its last line
    log.write_text("".join(log.read_text().splitlines(keepends=True)[:-1]))
    with TestClient(made_app(settings, launcher), base_url=BASE) as http:
        assert [one for one in Client(http, launcher).get("book") if "ended without a word" in one["text"]]


def test_what_may_be_done_is_refused_and_shown_alike(client: Client) -> None:
    client.take()
    shown = client.state("state")["allowed"]
    assert "pause" not in shown
    assert "nothing runs" in client.ask("run/pause", 409, secret=client.secret, run="none")["problem"]
    client.ask("run/skip", 409, secret=client.secret, run="none", point="0123456789abcdef")


def test_a_request_repeated_after_a_restart_makes_no_second_run(tmp_path: Path) -> None:
    body = {"request_id": "request-again-1", "name": "Bo", "campaign": "quick"}
    settings = Settings(folder=tmp_path / "recordings")
    answers = []
    for content in (body, body):
        with TestClient(made_app(settings, NoLauncher()), base_url=BASE) as http:
            answers.append(http.post("/api/runs", json=content).json())
            other = http.post("/api/runs", json={**content, "campaign": "short"})
            assert "was used for another request" in other.json()["problem"]
            runs = Client(http, NoLauncher()).state("runs")["runs"]
    assert answers[0] == answers[1]
    assert [(run["id"], run["state"]) for run in runs] == [(answers[0]["id"], "proposed")]
    # a broken file is kept aside, and the service begins all the same
    path = settings.state / "requests.json"
    path.write_text("{")
    with TestClient(made_app(settings, NoLauncher()), base_url=BASE) as http:
        assert http.post("/api/runs", json={**body, "request_id": "request-again-2"}).status_code == 200
    assert list(settings.state.glob("requests.json.broken-*"))


def test_a_service_that_conceals_seals_what_its_runs_record(tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    launcher = NoLauncher()
    with TestClient(made_app(Settings(folder=folder, conceal=5), launcher), base_url=BASE) as http:
        client = Client(http, launcher)
        client.take()
        client.ask("runs", name="Ann", secret=client.secret, campaign="quick", folder="mine")
        client.until(lambda: launcher.jobs)
    launcher.end_all()
    file = load_bench("rh380n")
    assert (folder / "mine" / SEAL).read_text("utf-8").strip() == opened(file, 5)[1] != opened(file, 6)[1]
    # a bench without concealed physics does not go on in such a folder
    other, plain = NoLauncher(), tmp_path / "plain"
    seal(plain / "mine", opened(file, 5)[1])
    with TestClient(made_app(Settings(folder=plain), other), base_url=BASE) as http:
        client = Client(http, other)
        client.take()
        run = client.ask("runs", name="Ann", secret=client.secret, campaign="quick", folder="mine")
        client.until(lambda: next(r for r in client.state("runs")["runs"] if r["id"] == run["id"])["state"] == "ended")
        end = next(one for one in client.state("runs")["runs"] if one["id"] == run["id"])["end"]
    assert end["kind"] == "refused"
    assert "is sealed (concealed.sha256)" in end["text"]
    assert not other.jobs
