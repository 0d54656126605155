"""What watches a run: systemd's watchdog, the writer, the alarms and who they are sent to, the room on the disk."""

from __future__ import annotations

import asyncio
import configparser
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bench.errors import ConfigurationError
from bench.safety import Cause
from bench.safety.places import state_root
from bench.service.alarms import OTHERWISE, WHAT_TO_DO, Alarm, Alarms
from bench.service.allowed import PHASES, RUNNING, Situation, allowed, why_not
from bench.service.book import Book
from bench.service.notify import Notifier
from bench.service.storage import storage
from bench.service.watchdog import feed, is_well, notify, writer_lives


def test_the_unit_is_one_and_its_watchdog_and_privileges_are_set(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "from bench.cli import main; main()", "serve", "--systemd-unit"]
    done = subprocess.run([*command, "--bus", "eth1", "--port", "8090"], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    unit = configparser.ConfigParser(interpolation=None, strict=False)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read_string(done.stdout)
    service = unit["Service"]
    assert service["ExecStart"].endswith("serve --bus eth1 --port 8090")
    assert service["Type"] == "notify"
    assert int(service["WatchdogSec"]) >= 10
    assert set(service["AmbientCapabilities"].split()) == {
        "CAP_NET_RAW",
        "CAP_NET_ADMIN",
        "CAP_SYS_NICE",
        "CAP_IPC_LOCK",
    }
    assert service["WorkingDirectory"] == str(tmp_path)
    # all it writes to is there and may be written to; bench run in a shell looks for the service in the same place
    writable = service["ReadWritePaths"].split()
    assert writable == [str(tmp_path), str(state_root()), tempfile.gettempdir()]
    assert all(Path(path).is_dir() for path in writable)
    assert "BENCH_RUNTIME" not in service["Environment"]
    verifier = shutil.which("systemd-analyze")
    if verifier is not None:
        file = tmp_path / "gearbench.service"
        file.write_text(done.stdout)
        told = subprocess.run([verifier, "verify", str(file)], capture_output=True, text=True)
        assert (told.returncode, "gearbench" in told.stderr) == (0, False), told.stderr


def service_with(folder: Path, alive: bool, phase: str) -> Any:
    run = SimpleNamespace(folder=str(folder))
    keeper = SimpleNamespace(runs=SimpleNamespace(running=lambda: run), is_alive=lambda: alive, status={"phase": phase})
    return SimpleNamespace(keeper=keeper)


def test_the_watchdog_is_fed_only_while_run_and_writer_live(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.bind(str(tmp_path / "notify"))
        systemd.settimeout(10)
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        monkeypatch.setenv("WATCHDOG_USEC", "1000000")
        for alive, said in ((True, b"WATCHDOG=1"), (False, b"STATUS=the run or its writer is silent")):

            async def scene(alive: bool = alive) -> None:
                task = asyncio.create_task(feed(service_with(tmp_path, alive, "measuring")))
                await asyncio.sleep(0.05)
                task.cancel()

            asyncio.run(scene())
            assert systemd.recv(100) == b"READY=1"
            assert systemd.recv(100) == said
    monkeypatch.delenv("NOTIFY_SOCKET")
    assert not notify("WATCHDOG=1")


def test_a_writer_lives_while_its_recording_is_touched(tmp_path: Path) -> None:
    now = time.time()
    assert writer_lives(tmp_path, "measuring", now)
    part = tmp_path / "0001-constant_velocity.h5.part"
    part.touch()
    assert writer_lives(tmp_path, "measuring", now)
    os.utime(part, (now - 60.0, now - 60.0))
    assert not writer_lives(tmp_path, "measuring", now)
    assert not is_well(service_with(tmp_path, True, "heating"))
    # between two points nothing is written
    assert writer_lives(tmp_path, "paused", now)
    assert is_well(service_with(tmp_path, True, "paused"))


def test_a_manager_that_does_not_read_holds_nothing_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as systemd:
        systemd.bind(str(tmp_path / "notify"))
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        told = [notify("WATCHDOG=1") for _ in range(2000)]
    assert told[0]
    assert not told[-1]


@pytest.mark.parametrize("cause", [cause.name for cause in Cause if cause is not Cause.NONE])
def test_every_cause_of_a_stop_says_what_to_do(cause: str) -> None:
    assert WHAT_TO_DO.get(cause, OTHERWISE).endswith(".")
    assert len(WHAT_TO_DO.get(cause, OTHERWISE)) > 40


def test_the_same_alarm_is_raised_once(tmp_path: Path) -> None:
    told: list[Alarm] = []
    alarms = Alarms(Book(tmp_path / "log.jsonl"), told.append, tmp_path / "alarms.json")
    first = alarms.raise_("SILENT", "no word")
    assert alarms.raise_("SILENT", "no word") is first
    second = alarms.raise_("DISK", "full")
    assert [alarm["number"] for alarm in alarms.standing()] == [second.number, first.number]
    assert [alarm.cause for alarm in told] == ["SILENT", "DISK"]
    acknowledged = alarms.acknowledge(first.number, "Ann")
    assert acknowledged is not None
    assert acknowledged.acknowledged_by == "Ann"
    assert alarms.acknowledge(first.number, "Ann") is None


@pytest.mark.filterwarnings("ignore:'imghdr' is deprecated:DeprecationWarning")
def test_alarms_reach_those_who_are_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    apprise = pytest.importorskip("apprise")
    sent: list[dict[str, str]] = []
    monkeypatch.setattr(apprise.Apprise, "notify", lambda self, **message: sent.append(message) or True)
    notifier = Notifier(("json://localhost:1/alarm",))
    thread = notifier.tell(Alarm(1, "2026-11-21T12:00:00+00:00", "DIED", "it ended", "Look."), "rh380n")
    assert thread is not None
    thread.join(10)
    assert sent[0]["title"] == "Bench rh380n: died"
    assert "it ended" in sent[0]["body"]
    assert Notifier(()).tell(Alarm(1, "", "DIED", "", ""), "rh380n") is None
    with pytest.raises(ConfigurationError, match="not an address apprise understands"):
        Notifier(("nonsense://x",))


@pytest.mark.parametrize("phase", sorted(PHASES))
@pytest.mark.parametrize("due", ["", "acknowledge", "reset", "resume"])
def test_what_may_be_done_in_every_state(phase: str, due: str) -> None:
    now = Situation(phase, held=True, waiting=True, proposed=True, ended=True, alarms=True, due=due)
    acts = allowed(now)
    assert "stop" in acts
    assert ("start" in acts) == (due in ("", "resume"))
    assert ("again" in acts) == (phase == "free" and due in ("", "resume"))
    assert ("reset" in acts) == (phase == "free" and due in ("", "reset"))
    assert ("skip" in acts) == (phase in RUNNING | {"paused"})
    assert ("go_on" in acts) == (phase == "paused")
    assert not {"pause", "skip", "repeat", "note", "abort"} & acts or phase not in ("free", "stopping", "resetting")
    for act in {"pause", "again", "reset", "skip"} - acts:
        assert why_not(act, now).startswith(act)


def test_storage_says_how_long_it_lasts(tmp_path: Path) -> None:
    said = storage(tmp_path / "new", 0.0)
    assert said["folder"] == str(tmp_path / "new")
    assert said["hours"] == pytest.approx(said["free_bytes"] / 16000 / 3600)
    assert storage(tmp_path, said["free_bytes"] * 2)["hours"] == 0.0
    assert not storage(tmp_path, said["free_bytes"] * 2)["enough"]
