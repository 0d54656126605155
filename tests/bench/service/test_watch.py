"""What watches a run: systemd's watchdog, the writer, the alarms and who they are sent to, the room on the disk."""

from __future__ import annotations

import asyncio
import configparser
import os
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bench.errors import ConfigurationError
from bench.safety import Cause
from bench.safety.paths import state_root
from bench.service.alarms.alarm_kinds import KINDS, kind_of
from bench.service.alarms.alarms import Alarm, Alarms
from bench.service.alarms.notify import Notifier
from bench.service.files.book import Book
from bench.service.files.disk import Disk
from bench.service.files.kept import Broken
from bench.service.files.storage import storage
from bench.service.runs.allowed import BEGINS, PHASES, RUNNING, Situation, allowed_acts, why_not
from bench.service.runs.keeper import Keeper
from bench.service.watchdog import feed, is_well, notify, writer_lives
from tests.program import bench


def test_the_unit_is_one_and_its_watchdog_and_privileges_are_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = bench(["serve", "--systemd-unit", "--bus", "eth1", "--port", "8090"])
    assert done.code == 0, done.err
    unit = configparser.ConfigParser(interpolation=None, strict=False)
    unit.optionxform = str  # type: ignore[assignment, method-assign]
    unit.read_string(done.out)
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
        file.write_text(done.out)
        result = subprocess.run([verifier, "verify", str(file)], capture_output=True, text=True)
        assert (result.returncode, "gearbench" in result.stderr) == (0, False), result.stderr


def service_with(folder: Path, alive: bool, phase: str) -> Any:
    run = SimpleNamespace(folder=str(folder))
    shown = SimpleNamespace(status={"phase": phase})
    keeper = SimpleNamespace(runs=SimpleNamespace(running=lambda: run), is_alive=lambda: alive, shown=shown)
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
        sent = [notify("WATCHDOG=1") for _ in range(2000)]
    assert sent[0]
    assert not sent[-1]


@pytest.mark.parametrize("cause", [cause.name for cause in Cause if cause is not Cause.NONE])
def test_every_cause_of_a_stop_has_its_own_next_act(cause: str) -> None:
    assert cause in KINDS
    assert not KINDS[cause].clears_itself
    text = KINDS[cause].next_act
    assert text.endswith(".")
    # in the order in which the bench wants it
    acts = [text.index(word) for word in ("cknowledge", "reset the bench", "go on") if word in text]
    assert acts == sorted(acts)


def test_no_alarm_says_what_nobody_has_seen() -> None:
    for cause, kind in KINDS.items():
        assert "has moved" not in kind.next_act, cause
        assert "have stopped by" not in kind.next_act, cause
        assert "at rest" not in kind.next_act or "come to rest" in kind.next_act, cause


@pytest.fixture
def alarms(tmp_path: Path) -> Iterator[Alarms]:
    disk = Disk()
    yield new_alarms(tmp_path, disk)
    assert disk.close(10.0)


def new_alarms(folder: Path, disk: Disk, raised: list[Alarm] | None = None) -> Alarms:
    notify = (raised if raised is not None else []).append
    book = Book(folder / "log.jsonl", disk)
    return Alarms(book, notify, lambda: None, folder / "alarms.json", disk, Broken())


def test_the_same_alarm_is_raised_once_and_told_once(tmp_path: Path) -> None:
    raised: list[Alarm] = []
    disk = Disk()
    alarms = new_alarms(tmp_path, disk, raised)
    first = alarms.raise_("DIED", "no word", "point 3 of 9")
    assert alarms.raise_("DIED", "no word") is first
    second = alarms.raise_("RECORDER", "full")
    assert [alarm["number"] for alarm in alarms.current()] == [second.number, first.number]
    assert [alarm.cause for alarm in raised] == ["DIED", "RECORDER"]
    assert alarms.to_acknowledge()
    assert alarms.acknowledge(first.number, "Ann") == first
    assert alarms.acknowledge(first.number, "Ann") is None
    assert disk.settled(10.0)
    # a service that was killed comes back with what stands
    assert new_alarms(tmp_path, disk).current() == alarms.current()
    assert disk.close(10.0)


def test_an_alarm_that_is_over_goes_by_itself_and_stands_in_the_book(alarms: Alarms) -> None:
    alarms.set("SILENT", "no word for 10 s")
    alarms.set("SILENT", "no word for 10 s")
    (alarm,) = alarms.current()
    assert alarm["clears_itself"]
    assert not alarms.to_acknowledge()
    assert alarms.acknowledge(alarm["number"], "Ann") is None
    alarms.set("SILENT", None)
    assert alarms.current() == []
    assert kind_of("nobody knows it").clears_itself is False


@pytest.mark.parametrize(("phase", "patience_s"), [("measuring", 10.0), ("resetting", 180.0), ("opening", 180.0)])
def test_a_run_is_silent_after_what_its_phase_may_take_and_no_longer_than_it_is(phase: str, patience_s: float) -> None:
    service: Any = SimpleNamespace(
        runs=SimpleNamespace(running=lambda: SimpleNamespace(title="Reset")),
        shown=SimpleNamespace(status={"phase": phase}),
        heard=time.monotonic() - 0.9 * patience_s,
    )
    silent: Any = Keeper.silent
    assert silent.fget(service) is None
    service.heard = time.monotonic() - 1.1 * patience_s
    assert silent.fget(service) == f"the run Reset has sent nothing for {patience_s:.0f} s"
    service.heard = time.monotonic()
    assert silent.fget(service) is None


@pytest.mark.filterwarnings("ignore:'imghdr' is deprecated:DeprecationWarning")
def test_alarms_reach_those_who_are_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    apprise = pytest.importorskip("apprise")
    sent: list[dict[str, str]] = []
    monkeypatch.setattr(apprise.Apprise, "notify", lambda self, **message: sent.append(message) or True)
    notifier = Notifier(("json://localhost:1/alarm",))
    thread = notifier.send(Alarm(1, "2026-11-21T12:00:00+00:00", "DIED", "it ended", "Look."), "rh380n")
    assert thread is not None
    thread.join(10)
    assert sent[0]["title"] == "Bench rh380n: died"
    assert "it ended" in sent[0]["body"]
    assert Notifier(()).send(Alarm(1, "", "DIED", "", ""), "rh380n") is None
    with pytest.raises(ConfigurationError, match="not an address apprise understands"):
        Notifier(("nonsense://x",))


@pytest.mark.parametrize("phase", sorted(PHASES))
@pytest.mark.parametrize("due", ["", "acknowledge", "reset", "resume"])
def test_what_may_be_done_in_every_state(phase: str, due: str) -> None:
    now = Situation(phase, held=True, waiting=True, proposed=True, ended=True, due=due)
    acts = allowed_acts(now)
    assert {"stop", "withdraw", "queue", "approve"} <= acts
    assert ("start" in acts) == (due in ("", "resume"))
    assert ("again" in acts) == (phase == "free" and due in ("", "resume"))
    assert ("reset" in acts) == (phase == "free" and due in ("", "reset"))
    assert ("skip" in acts) == (phase in RUNNING | {"paused"})
    assert ("go_on" in acts) == (phase == "paused")
    assert not {"pause", "skip", "repeat", "note", "abort"} & acts or phase not in ("free", "stopping", "resetting")
    for act in {"pause", "again", "reset", "skip"} - acts:
        assert why_not(act, now).startswith(act)
    # as long as an alarm stands that nobody has read, nothing gives torque
    alarmed = replace(now, alarms=True)
    assert allowed_acts(alarmed) == acts - BEGINS | {"acknowledge"}
    assert all("acknowledge" in why_not(act, alarmed) for act in BEGINS)


def test_storage_says_how_long_it_lasts(tmp_path: Path) -> None:
    said = storage(tmp_path / "new", 0.0)
    assert said["folder"] == str(tmp_path / "new")
    assert said["hours"] == pytest.approx(said["free_bytes"] / 16000 / 3600)
    assert storage(tmp_path, said["free_bytes"] * 2)["hours"] == 0.0
    assert not storage(tmp_path, said["free_bytes"] * 2)["enough"]
