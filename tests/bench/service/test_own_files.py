"""The service's own files: gone, frozen or broken they cost what they hold, never a STOP and never the service."""

from __future__ import annotations

import json
import os
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from bench.errors import DeviceError
from bench.service.files.disk import Disk
from bench.service.runs.keeper import Keeper
from bench.service.runs.runs import Run
from bench.service.server import run
from bench.service.service import Service
from bench.service.settings import Settings
from tests.bench.service.conftest import BASE, Client, NoLauncher, made_app

STOPPED_S = 1.0


def running(client: Client) -> None:
    client.take("Ann")
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "running")


def pressed(client: Client) -> float:
    """Press STOP and return how long it took until the process had ended by it, s."""
    begin = time.monotonic()
    answer = client.http.post("/api/stop", json={"by": "Bob", "pressed_at_ns": time.time_ns()})
    assert answer.status_code == 200, answer.text
    client.launcher.processes[0].wait(10)
    return time.monotonic() - begin


def causes(client: Client) -> set[str]:
    return {alarm["cause"] for alarm in client.state("state")["alarms"]}


def test_stop_works_without_the_services_folder_and_the_keeper_lives_on(client: Client, tmp_path: Path) -> None:
    running(client)
    state, away = tmp_path / "recordings" / ".service", tmp_path / "away"
    state.rename(away)
    # a file in its place: nothing can be written there, not even by root
    state.touch()
    assert pressed(client) < STOPPED_S
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    assert client.state("runs")["held"]
    client.until(lambda: "STATE_FOLDER" in causes(client))
    assert any("Bob pressed STOP at" in entry["text"] for entry in client.get("book"))
    refused = client.ask("runs", 409, name="Ann", secret=client.secret, campaign="quick")
    assert "cannot be written" in refused["problem"]
    state.unlink()
    away.rename(state)
    client.until(lambda: "STATE_FOLDER" not in causes(client))
    assert "pressed STOP" in (state / "log.jsonl").read_text("utf-8")
    (kept,) = json.loads((state / "runs.json").read_text("utf-8"))
    assert kept["state"] == "ended"
    # the next run is taken up as ever
    client.ask("runs", name="Ann", secret=client.secret, campaign="quick")
    client.until(lambda: len(client.launcher.processes) == 2)


def test_stop_does_not_wait_for_a_frozen_disk(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    running(client)
    thawed = threading.Event()
    monkeypatch.setattr(os, "fsync", lambda descriptor: thawed.wait(20))
    assert pressed(client) < STOPPED_S
    client.until(lambda: "STATE_FOLDER" in causes(client))
    assert "takes no data" in client.state("state")["alarms"][0]["text"]
    thawed.set()
    client.until(lambda: "STATE_FOLDER" not in causes(client))


def test_stop_does_not_look_at_the_folder_of_locks(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    running(client)

    def refuse(name: str) -> Path:
        raise DeviceError("the runtime folder is gone")

    monkeypatch.setattr("bench.service.runs.run_process.socket_path", refuse)
    assert pressed(client) < STOPPED_S
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")


def test_an_error_in_the_keeper_is_an_alarm_and_the_run_is_followed_further(
    client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = threading.Event()
    follow = Keeper._follow

    async def failing(self: Keeper, run: Run) -> None:
        if not broken.is_set():
            broken.set()
            raise OSError(28, "No space left on device")
        await follow(self, run)

    monkeypatch.setattr(Keeper, "_follow", failing)
    running(client)
    client.until(lambda: "KEEPER" in causes(client))
    assert not client.get("health")["alive"]
    assert pressed(client) < STOPPED_S
    client.until(lambda: client.state("runs")["runs"][0]["state"] == "ended")
    client.until(lambda: "KEEPER" not in causes(client))


def test_what_a_process_says_amiss_does_not_end_the_keeper(client: Client) -> None:
    service: Service = client.http.app.state.service  # type: ignore[attr-defined]
    # a plan without points: a message of another version
    with pytest.raises(KeyError):
        service.keeper.shown.take({"type": "plan"})
    assert service.keeper.trouble is None


@pytest.mark.parametrize("name", ["runs.json", "alarms.json", "log.jsonl", "seen", "analyses/x/analysis.json"])
@pytest.mark.parametrize("content", [b"", b"\xff\x00", b"[{}]", b"7"])
def test_a_broken_file_is_kept_aside_and_the_service_begins(name: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / ".service" / name
    path.parent.mkdir(parents=True)
    path.write_bytes(content)
    with TestClient(made_app(Settings(folder=tmp_path), NoLauncher()), base_url=BASE) as http:
        state = next(one for one in http.get("/api/state").json() if one["type"] == "state")
        assert http.post("/api/stop", json={}).status_code == 200
    if name in ("log.jsonl", "seen"):
        assert state["alarms"] == []
        return
    assert [alarm["cause"] for alarm in state["alarms"]] == ["STATE_FILE"]
    (aside,) = path.parent.glob(f"{path.name}.broken-*")
    assert aside.read_bytes() == content
    assert aside.name in state["alarms"][0]["text"]


def test_runs_are_rebuilt_from_their_jobs_where_their_file_is_broken(tmp_path: Path) -> None:
    launcher = NoLauncher()
    settings = Settings(folder=tmp_path)
    with TestClient(made_app(settings, launcher), base_url=BASE) as http:
        running(Client(http, launcher))
    runs = tmp_path / ".service" / "runs.json"
    (before,) = json.loads(runs.read_text("utf-8"))
    runs.write_text(runs.read_text("utf-8")[:40])
    with TestClient(made_app(settings, launcher), base_url=BASE) as http:
        client = Client(http, launcher)
        (run,) = client.state("runs")["runs"]
        assert (run["id"], run["state"], run["pid"]) == (before["id"], "running", before["pid"])
        assert client.state("runs")["held"]
        assert pressed(client) < STOPPED_S
    launcher.end_all()


def test_the_book_says_when_a_service_that_died_was_last_seen(tmp_path: Path) -> None:
    disk = Disk()
    entry = {"at": "2026-11-20T08:00:00.000+01:00", "act": "service", "by": "service", "text": "the service begins"}
    disk.append(tmp_path / ".service" / "log.jsonl", json.dumps(entry))
    disk.replace(tmp_path / ".service" / "seen", "2026-11-20T14:03:10.000+01:00")
    assert disk.close(10.0)
    with TestClient(made_app(Settings(folder=tmp_path), NoLauncher()), base_url=BASE) as http:
        texts = [entry["text"] for entry in http.get("/api/book").json()]
    assert "it ended without a word, last seen at 2026-11-20T14:03:10.000+01:00" in texts


def test_a_disk_writes_what_it_could_not_as_soon_as_it_can(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bench.service.files.disk.RETRY_S", 0.02)
    disk, folder = Disk(), tmp_path / "folder"
    folder.touch()
    for number in range(3):
        disk.append(folder / "lines", f"line {number}")
        disk.replace(folder / "content", f"content {number}")
    assert not disk.settled(0.1)
    assert "cannot be written" in str(disk.trouble)
    folder.unlink()
    assert disk.settled(5.0)
    assert disk.trouble is None
    assert (folder / "lines").read_text() == "line 0\nline 1\nline 2\n"
    assert (folder / "content").read_text() == "content 2"
    disk.remove(folder / "content")
    assert disk.close(5.0)
    assert not (folder / "content").exists()


def test_a_line_that_was_cut_off_is_written_again_on_a_line_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("bench.service.files.disk.RETRY_S", 0.02)
    write, full = os.write, [True]

    def short(descriptor: int, data: Any) -> int:
        if full:
            full.clear()
            write(descriptor, data[:4])
            raise OSError(28, "No space left on device")
        return write(descriptor, data)

    monkeypatch.setattr(os, "write", short)
    disk = Disk()
    disk.append(tmp_path / "lines", "whole line")
    assert disk.close(5.0)
    assert (tmp_path / "lines").read_text() == "whol\nwhole line\n"


def test_a_runtime_folder_whose_path_is_too_long_is_said_before_anything_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BENCH_RUNTIME", str(tmp_path / ("long" * 20)))
    with pytest.raises(DeviceError, match=r"the path of the runtime folder .* has \d+ bytes, .* with BENCH_RUNTIME"):
        run(Settings(folder=tmp_path / "recordings"))
    assert not (tmp_path / "recordings").exists()
