"""Who may do what: one operator holds the controls, everybody may stop, everything stands in the book."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from bench.service.book import Book
from bench.service.lease import LOST_S, SILENT_S, Lease, NotHeld
from bench.service.service import Service
from tests.bench.service.conftest import Client


def test_controls_are_taken_offered_taken_away_and_let_go_with_a_record(client: Client) -> None:
    ann = client.take("Ann")
    assert client.state("state")["holder"]["name"] == "Ann"
    assert "Ann holds the controls" in client.ask("controls/take", 403, name="Bob")["problem"]
    client.ask("controls/offer", secret=ann, to="Bob")
    bob = client.take("Bob")
    client.ask("controls/release", 403, secret=ann)
    cleo = client.take("Cleo", taken_from="Bob")
    client.ask("controls/release", 403, secret=bob)
    client.ask("controls/release", secret=cleo)
    assert client.state("state")["holder"] is None
    acts = [entry["text"] for entry in client.get("book") if entry["act"] == "controls"]
    assert acts == [
        "Cleo let go of the controls",
        "Cleo took the controls from Bob",
        "Ann handed the controls over to Bob",
        "Ann offers the controls to Bob",
        "Ann took the controls",
    ]


def test_a_secret_never_leaves_with_the_state(client: Client) -> None:
    secret = client.take("Ann")
    assert secret not in client.http.get("/api/state").text
    assert secret not in client.http.get("/api/book").text


def test_a_holder_who_is_gone_loses_the_controls(tmp_path: Path) -> None:
    lease = Lease(Book(tmp_path / "log.jsonl"))
    secret = lease.take("Ann", None, 0.0)
    assert lease.as_dict(SILENT_S + 1.0) is not None
    shown = lease.as_dict(SILENT_S + 1.0)
    assert shown is not None
    assert shown["away"]
    lease.check(secret, SILENT_S + 2.0)
    assert lease.holder(LOST_S + SILENT_S + 1.0) is not None
    assert lease.holder(LOST_S + SILENT_S + 3.0) is None
    with pytest.raises(NotHeld, match="take them first"):
        lease.check(secret, LOST_S + SILENT_S + 4.0)


def test_the_book_outlives_a_torn_line(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    Book(path).write("note", "Ann", "first")
    with path.open("a", encoding="utf-8") as file:
        file.write('{"at": "20')
    book = Book(path)
    assert [entry["text"] for entry in book.last()] == ["first"]


@pytest.mark.parametrize(
    "path", ["run/pause", "run/go-on", "run/abort", "queue/go-on", "reset", "runs/none/again", "alarms/1/acknowledge"]
)
def test_nothing_moves_without_the_controls(client: Client, path: str) -> None:
    assert "controls" in client.ask(path, 403, secret="not-it")["problem"]
    client.take()
    assert "controls" in client.ask(path, 403, secret="not-it")["problem"]


def test_stop_works_for_anybody_and_holds_the_queue(client: Client) -> None:
    client.take("Ann")
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.launcher.jobs)
    answer = client.http.post("/api/stop", json={})
    assert answer.json()["done"] == "the bench is brought to rest"
    # the process ends by the signal even though it never listened
    client.until(lambda: client.launcher.processes[0].poll() is not None)
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    assert client.state("runs")["held"]
    assert any("pressed STOP" in entry["text"] for entry in client.get("book"))
    assert client.http.post("/api/stop", json={"by": "Bob"}).json()["done"].startswith("nothing runs")


def test_a_run_that_dies_is_an_alarm_that_is_acknowledged(client: Client) -> None:
    client.take("Ann")
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.launcher.processes)
    client.launcher.processes[0].kill()
    client.until(lambda: client.state("state")["alarms"])
    (alarm,) = client.state("state")["alarms"]
    assert alarm["cause"] == "DIED"
    assert "watchdogs" in alarm["what_to_do"]
    client.ask(f"alarms/{alarm['number']}/acknowledge", secret=client.secret)
    assert client.state("state")["alarms"] == []
    client.ask(f"alarms/{alarm['number']}/acknowledge", 409, secret=client.secret)


def test_stop_while_a_run_is_being_started_stops_it(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    started = client.launcher.start

    async def slow(job: Path, log: Path) -> int:
        client_answer = await asyncio.to_thread(lambda: client.http.post("/api/stop", json={}))
        assert client_answer.json()["done"].startswith("nothing runs")
        return await started(job, log)

    monkeypatch.setattr(client.launcher, "start", slow)
    client.take()
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.launcher.processes)
    client.until(lambda: client.launcher.processes[0].poll() is not None)
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    assert client.state("runs")["runs"][0]["end"]["kind"] == "interrupted"
    assert client.state("runs")["held"]


def test_a_run_that_does_not_come_to_rest_is_ended_hard_with_an_alarm(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    deaf = (
        "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print('deaf', flush=True); time.sleep(60)"
    )

    async def start(job: Path, log: Path) -> int:
        process = subprocess.Popen([sys.executable, "-c", deaf, str(job)], stdout=subprocess.PIPE)
        assert process.stdout is not None
        with process.stdout as said:
            said.readline()
        client.launcher.processes.append(process)
        return process.pid

    monkeypatch.setattr(client.launcher, "start", start)
    service: Service = client.http.app.state.service  # type: ignore[attr-defined]
    monkeypatch.setattr(service.keeper, "_stop_deadline_s", 0.3)
    client.take()
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "running")
    client.http.post("/api/stop", json={})
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    assert client.launcher.processes[0].poll() == -signal.SIGKILL
    causes = {alarm["cause"] for alarm in client.state("state")["alarms"]}
    assert causes == {"KILLED", "DIED"}


def test_a_disk_that_fills_up_is_an_alarm_before_a_run_stops_for_it(client: Client) -> None:
    service: Service = client.http.app.state.service  # type: ignore[attr-defined]
    said = {**service.storage(), "enough": False}

    async def look() -> None:
        service.storage = lambda: said  # type: ignore[method-assign]
        task = asyncio.get_running_loop().create_task(service._watch_disk())
        await asyncio.sleep(0.1)
        task.cancel()

    client.http.portal.call(look)  # type: ignore[union-attr]
    (alarm,) = client.state("state")["alarms"]
    assert alarm["cause"] == "DISK"
    assert "backup" in alarm["what_to_do"]
