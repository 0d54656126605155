"""Who may do what: one operator holds the controls, everybody may stop, everything stands in the book."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
import time
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from bench.service.files.book import Book
from bench.service.files.disk import Disk
from bench.service.runs.keeper import Keeper
from bench.service.runs.lease import LOST_S, SILENT_S, Lease, NotHeld
from bench.service.runs.watches import look_at_disk, watch
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
    lease = Lease(Book(tmp_path / "log.jsonl", Disk()))
    secret = lease.take("Ann", None, 0.0).secret
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
    disk = Disk()
    (first,) = [Book(path, disk).write("note", "Ann", "first")]
    assert disk.close(10.0)
    with path.open("ab") as file:
        file.write(b'[1, 2]\n\xff\xfe{"at": "20')
    assert Book(path, Disk()).last() == [first]
    # the clock on the wall, with its offset to UTC
    assert datetime.fromisoformat(first["at"]).utcoffset() == datetime.now().astimezone().utcoffset()


@pytest.mark.parametrize(
    ("path", "more"),
    [
        ("run/pause", {"run": "x"}),
        ("run/go-on", {"run": "x"}),
        ("run/abort", {"run": "x"}),
        ("queue/go-on", {}),
        ("reset", {"run": None}),
        ("runs/none/again", {}),
        ("alarms/1/acknowledge", {}),
    ],
)
def test_nothing_moves_without_the_controls(client: Client, path: str, more: dict[str, str | None]) -> None:
    assert "controls" in client.ask(path, 403, secret="not-it", **more)["problem"]
    client.take()
    assert "controls" in client.ask(path, 403, secret="not-it", **more)["problem"]


def test_two_browsers_of_one_name_do_not_both_hold_the_controls(client: Client) -> None:
    first = client.ask("controls/take", name="Ann")
    assert "Ann holds the controls" in client.ask("controls/take", 403, name="Ann")["problem"]
    second = client.ask("controls/take", name="Ann", taken_from="Ann")
    assert first["id"] != second["id"]
    assert client.state("state")["holder"]["id"] == second["id"]
    refused = client.ask("controls/release", 403, secret=first["secret"])
    assert "in another browser" in refused["problem"]
    client.ask("controls/release", secret=second["secret"])


ACTS = ["run/pause", "run/go-on", "run/abort", "run/note", "run/skip", "run/repeat"]


@pytest.mark.parametrize("path", ACTS)
def test_an_act_meant_for_one_run_is_not_done_to_the_next(client: Client, path: str) -> None:
    client.take()
    more = {"text": "all well"} if path == "run/note" else {"point": "0" * 16} if path in ACTS[-2:] else {}
    # without the run it is not taken at all
    client.ask(path, 422, secret=client.secret, **more)
    first = client.ask("runs", name="Ann", secret=client.secret, campaign="quick")["id"]
    client.until(lambda: client.launcher.processes)
    client.launcher.processes[0].kill()
    client.until(lambda: client.state("state")["alarms"])
    client.ask(f"alarms/{client.state('state')['alarms'][0]['number']}/acknowledge", secret=client.secret)
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: len(client.launcher.processes) == 2)
    service: Service = client.http.app.state.service  # type: ignore[attr-defined]
    service.keeper.shown.status = {"type": "status", "phase": "paused" if path == "run/go-on" else "measuring"}
    refused = client.ask(path, 409, secret=client.secret, run=first, **more)["problem"]
    assert "which has ended" in refused
    assert "nothing was done" in refused
    assert client.launcher.processes[1].poll() is None


def test_an_alarm_nobody_has_read_gives_no_torque(client: Client) -> None:
    client.take()
    run = client.ask("runs", name="Ann", secret=client.secret, campaign="quick")["id"]
    client.until(lambda: client.launcher.processes)
    client.launcher.processes[0].kill()
    client.until(lambda: client.state("state")["alarms"])
    proposed = client.ask("runs", name="Bob", campaign="quick")["id"]
    for path in (f"runs/{run}/again", "queue/go-on", f"runs/{proposed}/approve"):
        assert "acknowledge" in client.ask(path, 409, secret=client.secret)["problem"]
    client.ask("runs", 409, name="Ann", secret=client.secret, campaign="quick")
    client.ask("reset", 409, secret=client.secret, run=run)
    assert len(client.launcher.processes) == 1
    (alarm,) = client.state("state")["alarms"]
    client.ask(f"alarms/{alarm['number']}/acknowledge", secret=client.secret)
    client.ask(f"runs/{run}/again", secret=client.secret)
    client.until(lambda: len(client.launcher.processes) == 2)


def test_a_reset_is_of_the_stop_that_was_seen(client: Client) -> None:
    client.take()
    run = client.ask("runs", name="Ann", secret=client.secret, campaign="quick")["id"]
    client.until(lambda: client.launcher.processes)
    client.http.post("/api/stop", json={})
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    assert "has ended since" in client.ask("reset", 409, secret=client.secret, run=None)["problem"]
    client.ask("reset", secret=client.secret, run=run)


def test_the_first_press_of_stop_is_named_and_stamped_once(client: Client) -> None:
    client.take()
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "running")
    pressed = time.time_ns() - 3 * 10**9
    first = client.http.post("/api/stop", json={"by": "Bob", "pressed_at_ns": pressed}).json()
    again = client.http.post("/api/stop", json={"by": "Cleo", "pressed_at_ns": time.time_ns()}).json()
    assert (first["by"], first["pressed_at_ns"]) == (again["by"], again["pressed_at_ns"]) == ("Bob", pressed)
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    # every page is told who it was; nobody saw the shafts of a process that only waits
    said = client.state("state")["stop"]
    assert (said["by"], said["pressed_at_ns"], said["at_rest_after_s"], said["over"]) == ("Bob", pressed, None, True)
    texts = [entry["text"] for entry in client.get("book") if entry["act"] == "stop"]
    assert "nobody saw the shafts at rest" in texts[0]
    assert any(text.startswith("Cleo pressed STOP too, after Bob") for text in texts)
    # a clock that is wrong by hours stamps nothing
    wrong = client.http.post("/api/stop", json={"pressed_at_ns": 10**18}).json()
    assert abs(wrong["pressed_at_ns"] - time.time_ns()) < 60 * 10**9


def test_stop_works_for_anybody_and_holds_the_queue(client: Client) -> None:
    client.take("Ann")
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.launcher.jobs)
    answer = client.http.post("/api/stop", json={})
    assert answer.json()["done"] == "the bench is being brought to rest"
    # the process ends by the signal even though it never listened
    client.until(lambda: client.launcher.processes[0].poll() is not None)
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    assert client.state("runs")["held"]
    assert any("pressed STOP" in entry["text"] for entry in client.get("book"))
    assert client.http.post("/api/stop", json={"by": "Bob"}).json()["done"].startswith("nothing runs")


def test_a_run_that_dies_is_an_alarm_that_is_acknowledged(client: Client) -> None:
    client.take("Ann")
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "running")
    service: Service = client.http.app.state.service  # type: ignore[attr-defined]
    service.keeper.shown.points = {"a": {"number": 1, "label": "10 °/s"}, "b": {"number": 2, "label": "20 °/s"}}
    service.keeper.shown.status = {"type": "status", "phase": "measuring", "identity": "b"}
    client.launcher.processes[0].kill()
    client.until(lambda: client.state("state")["alarms"])
    (alarm,) = client.state("state")["alarms"]
    assert (alarm["cause"], alarm["point"]) == ("DIED", "point 2 of 2, 20 °/s")
    assert "watchdogs" in alarm["what_to_do"]
    client.ask(f"alarms/{alarm['number']}/acknowledge", secret=client.secret)
    assert client.state("state")["alarms"] == []
    client.ask(f"alarms/{alarm['number']}/acknowledge", 409, secret=client.secret)


def test_stop_while_a_run_is_being_started_stops_it(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    started = client.launcher.start

    async def slow(job: Path, log: Path) -> int:
        client_answer = await asyncio.to_thread(lambda: client.http.post("/api/stop", json={}))
        assert client_answer.json()["run"] is not None
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
    monkeypatch.setattr(service.keeper.stopper, "deadline_s", 0.3)
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
        await look_at_disk(service.alarms, service.storage)

    def alarms(number: int) -> list[dict[str, Any]]:
        """Alarms after a look; once more where a look that the service began before has ended after it."""
        found: list[dict[str, Any]] = []
        for _ in range(20):
            client.http.portal.call(look)  # type: ignore[union-attr]
            found = client.state("state")["alarms"]
            if len(found) == number:
                break
        return found

    (alarm,) = alarms(1)
    assert alarm["cause"] == "DISK"
    assert "backup" in alarm["what_to_do"]
    # it goes when there is room again
    said["enough"] = True
    assert alarms(0) == []


def test_an_error_of_one_look_does_not_end_the_watch() -> None:
    looks: list[int] = []

    async def look() -> None:
        looks.append(1)
        raise OSError("no such folder")

    async def scene() -> None:
        task = asyncio.create_task(watch(look, 0.01))
        async with asyncio.timeout(60.0):
            while len(looks) < 2:
                await asyncio.sleep(0.01)
        task.cancel()

    asyncio.run(scene())


def held_with_one_waiting(client: Client) -> str:
    """STOP while one campaign runs and another waits; return the id of the one that waits."""
    client.take()
    client.ask("runs", name="Ann", secret=client.secret, campaign="paper")
    client.until(lambda: client.launcher.jobs)
    waiting: str = client.ask("runs", name="Ann", secret=client.secret, campaign="short")["id"]
    client.http.post("/api/stop", json={"by": "Ann"})
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    return waiting


def run_of(client: Client, run: str) -> dict[str, Any]:
    return next(one for one in client.state("runs")["runs"] if one["id"] == run)


@pytest.mark.parametrize("act", ["start", "again", "approve", "reset"])
def test_what_is_started_behind_a_hold_begins_alone(client: Client, act: str) -> None:
    waiting = held_with_one_waiting(client)
    ended = client.state("runs")["runs"][0]["id"]
    if act == "start":
        asked = client.ask("runs", name="Ann", secret=client.secret, campaign="quick")["id"]
    elif act == "again":
        asked = client.ask(f"runs/{ended}/again", secret=client.secret)["id"]
    elif act == "approve":
        asked = client.ask("runs", name="Bob", campaign="quick")["id"]
        client.ask(f"runs/{asked}/approve", secret=client.secret)
    else:
        asked = client.ask("reset", secret=client.secret, run=ended)["id"]
    client.until(lambda: run_of(client, asked)["state"] == "running")
    assert (run_of(client, waiting)["state"], client.state("runs")["held"]) == ("queued", True)
    texts = [entry["text"] for entry in client.get("book") if entry["act"] == "queue"]
    assert texts == [f"{run_of(client, asked)['title']} begins alone; the queue stays held"]
    client.launcher.processes[1].kill()
    client.until(lambda: run_of(client, asked)["state"] == "ended")
    assert (run_of(client, waiting)["state"], len(client.launcher.jobs)) == ("queued", 2)


def test_only_the_release_lets_what_waits_go_on(client: Client) -> None:
    waiting = held_with_one_waiting(client)
    client.ask("queue/go-on", secret=client.secret)
    client.until(lambda: run_of(client, waiting)["state"] == "running")
    assert not client.state("runs")["held"]


def test_a_stop_takes_back_what_was_started_behind_a_hold(client: Client) -> None:
    held_with_one_waiting(client)
    keeper: Keeper = client.http.app.state.service.keeper  # type: ignore[attr-defined]
    first = client.ask("runs", name="Ann", secret=client.secret, campaign="quick")["id"]
    client.until(lambda: run_of(client, first)["state"] == "running")
    later = client.ask("runs", name="Ann", secret=client.secret, campaign="quick")["id"]
    client.http.post("/api/stop", json={"by": "Ann"})
    client.until(lambda: run_of(client, first)["state"] == "ended")
    assert (run_of(client, later)["state"], keeper.held, len(client.launcher.jobs)) == ("queued", True, 2)


def test_a_hold_with_nothing_behind_it_ends_with_a_start_and_the_book_says_so(client: Client) -> None:
    client.take()
    client.http.post("/api/stop", json={"by": "Ann"})
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.launcher.jobs)
    assert not client.state("runs")["held"]
    assert any("it is held no longer" in entry["text"] for entry in client.get("book") if entry["act"] == "queue")
