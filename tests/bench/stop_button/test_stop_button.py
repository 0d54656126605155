"""The button, its listener, and whoever presses it from outside; the run is a process that only waits."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bench.cli.stop import stop as stop_command
from bench.stop_button import StopButton, listener, listening
from bench.stop_button.find import Found, bus_processes, elsewhere, how_to_stop, is_alive, looked_at, runs
from bench.stop_button.press import stop
from bench.stop_button.rest import rest_text

ROOT = Path(__file__).parents[3]
RUN = """
import signal, sys, time
from types import SimpleNamespace
from bench.stop_button import StopButton, listening
button = StopButton("run-1")
signal.signal(signal.SIGTERM, lambda *_: button.press("SIGTERM"))
with listening(button) as there:
    if "deaf" in sys.argv:
        there.close()
    print(there.port, flush=True)
    while not button.is_pressed:
        time.sleep(0.01)
    time.sleep(0.05)
    seen = (None, None) if "unseen" in sys.argv else (0.04, time.time_ns())
    button.stopped(SimpleNamespace(to_rest_s=seen[0], rest_seen_at_ns=seen[1], rungs=()))
    time.sleep(0.5)
"""


@pytest.fixture(autouse=True)
def runtime(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    # not below tmp_path, which has the name of the test: the path of a socket may have 107 bytes
    folder = tmp_path_factory.mktemp("runtime")
    monkeypatch.setenv("BENCH_RUNTIME", str(folder))
    return folder


@pytest.fixture
def processes() -> Iterator[list[subprocess.Popen[str]]]:
    started: list[subprocess.Popen[str]] = []
    yield started
    for process in started:
        process.kill()
        process.communicate()


def start(processes: list[subprocess.Popen[str]], *options: str) -> int:
    process = subprocess.Popen([sys.executable, "-c", RUN, *options], stdout=subprocess.PIPE, text=True, cwd=ROOT)
    processes.append(process)
    assert process.stdout is not None
    process.stdout.readline()
    return process.pid


def stopped(to_rest_s: float | None, rest_seen_at_ns: int | None, *rungs: Any) -> Any:
    return SimpleNamespace(to_rest_s=to_rest_s, rest_seen_at_ns=rest_seen_at_ns, rungs=rungs)


def found(pid: int) -> Found:
    return next(run for run in runs() if run.pid == pid)


def ask(port: int | None, method: str, what: str) -> Any:
    with urllib.request.urlopen(urllib.request.Request(f"http://127.0.0.1:{port}{what}", method=method)) as answer:
        assert answer.headers["Access-Control-Allow-Origin"] == "*"
        return json.load(answer)


def test_the_first_press_counts_and_its_time_is_that_of_whoever_pressed(runtime: Path) -> None:
    button = StopButton("run-1")
    with listening(button) as there:
        said = json.loads((runtime / listener.FILE).read_text())
        assert said == {"pid": os.getpid(), "port": there.port, "run": "run-1"}
        assert ask(there.port, "GET", "/state")["state"] == "running"
        at_ns = time.time_ns() - 2 * 10**9
        state = ask(there.port, "POST", f"/stop?by=Ann%20B&pressed_at_ns={at_ns}")
        assert (state["state"], state["pressed_by"], state["pressed_at_ns"]) == ("stopping", "Ann B", at_ns)
        assert button.is_pressed
        assert ask(there.port, "POST", "/stop?by=Bob")["pressed_by"] == "Ann B"
        button.stopped(stopped(0.4, at_ns + 2_400_000_000))
        state = ask(there.port, "GET", "/state")
        assert (state["state"], state["at_rest_after_s"], state["bench_to_rest_s"]) == ("at_rest", 2.4, None)
    assert not (runtime / listener.FILE).exists()


def test_a_run_that_was_halted_counts_from_the_press_not_from_when_it_woke() -> None:
    """The signal is handled first when such a run wakes up; the press with its stamp comes after it."""
    button, woke_ns = StopButton("run-1"), time.time_ns()
    assert button.press("SIGTERM").by == "SIGTERM"
    assert button.press("Ann", woke_ns - 7 * 10**9).by == "Ann"
    button.stopped(stopped(1.3, woke_ns + 10**8))
    assert button.at_rest_after_s == pytest.approx(7.1)
    assert button.state()["pressed_by"] == "Ann"


@pytest.mark.parametrize("ahead_s", [3, -3600])
def test_a_press_stamped_by_another_clock_gives_no_time(ahead_s: int) -> None:
    button, now_ns = StopButton("run-1"), time.time_ns()
    button.press("Ann", now_ns + ahead_s * 10**9)
    button.stopped(stopped(0.5, now_ns + 5 * 10**9))
    assert (button.state()["state"], button.at_rest_after_s) == ("at_rest", None)


def test_rest_that_was_seen_before_the_press_has_no_time_after_it() -> None:
    button, now_ns = StopButton("run-1"), time.time_ns()
    button.press("Ann", now_ns)
    button.stopped(stopped(0.5, now_ns - 1))
    assert (button.state()["state"], button.at_rest_after_s) == ("at_rest", None)


def test_a_bench_faster_than_the_clock_tells_its_own_time_as_its_own() -> None:
    button = StopButton("run-1")
    button.press("Ann")
    button.stopped(stopped(1.3, None, SimpleNamespace(rung="disable voltage", at_ns=None)))
    state = button.state()
    assert (state["state"], state["at_rest_after_s"], state["bench_to_rest_s"]) == ("at_rest", None, 1.3)
    assert (state["rung"], state["rung_at_ns"]) == ("disable voltage", None)
    assert "by the bench's own time" in rest_text(True, None, 1.3)
    assert rest_text(True, 7.1, None) == "7.10 s after the press both shafts were seen at rest"
    assert rest_text(True, None, None).endswith("is not known")
    assert rest_text(False, None, None) == "nobody saw the shafts at rest"


def test_rest_that_nobody_saw_is_not_said() -> None:
    button = StopButton("run-1")
    button.press("Ann")
    assert button.state()["state"] == "stopping"
    button.stopped(stopped(None, None))
    assert (button.state()["state"], button.at_rest_after_s) == ("not_seen", None)


def test_a_stop_that_nobody_pressed_for_is_none_of_the_button() -> None:
    button = StopButton("run-1")
    button.stopped(stopped(0.1, time.time_ns()))
    assert button.state()["state"] == "running"


def test_the_rung_that_took_the_torque_away_is_told_with_its_time() -> None:
    button = StopButton("run-1")
    button.press("Ann")
    assert (button.state()["rung"], button.state()["rung_at_ns"]) == (None, None)
    rungs = [
        SimpleNamespace(rung="controlled ramp", at_ns=1),
        SimpleNamespace(rung="disable voltage", at_ns=2),
        SimpleNamespace(rung="stop sending", at_ns=3),
    ]
    button.stopped(stopped(2.1, time.time_ns(), *rungs))
    state = button.state()
    assert (state["rung"], state["rung_at_ns"]) == ("disable voltage", 2)
    # a stop that comes later is another one
    button.stopped(stopped(0.1, time.time_ns(), *rungs[2:]))
    assert button.state()["rung_at_ns"] == 2


@pytest.mark.parametrize(
    "line", ["", "GET", "POST /state HTTP/1.1", "GET /stop HTTP/1.1", "POST //[", "POST /etc/passwd", "\xff" * 9000]
)
def test_nothing_else_is_answered_and_nothing_stops(line: str) -> None:
    button = StopButton("run-1")
    with listening(button) as there, socket.create_connection(("127.0.0.1", there.port or 0), 5.0) as connection:
        connection.sendall(line.encode("latin-1") + b"\r\n\r\n")
        assert connection.recv(64).split()[1] in (b"400", b"404")
    assert not button.is_pressed


def test_half_open_requests_hold_nothing_up() -> None:
    button = StopButton("run-1")
    with listening(button) as there, ExitStack() as stack:
        for _ in range(200):
            stack.enter_context(socket.create_connection(("127.0.0.1", there.port or 0), 5.0)).sendall(b"POST /st")
        began = time.monotonic()
        ask(there.port, "POST", "/stop?by=Ann")
        assert time.monotonic() - began < 5.0
    assert button.is_pressed


def test_it_listens_though_its_folder_is_gone(runtime: Path) -> None:
    runtime.rmdir()
    runtime.write_text("no folder")
    button = StopButton("run-1")
    with listening(button):
        timer = threading.Timer(0.2, lambda: button.stopped(stopped(0.1, time.time_ns())))
        timer.start()
        outcome = stop(found(os.getpid()), "Ann", 10.0)
    assert outcome.at_rest
    assert "both shafts were seen at rest" in outcome.text


def test_a_run_that_lives_says_when_it_is_at_rest(processes: list[subprocess.Popen[str]]) -> None:
    messages: list[str] = []
    outcome = stop(found(start(processes)), "Ann", 10.0, messages.append)
    assert outcome.at_rest
    assert "run-1" in messages[0]


def test_a_run_whose_rest_nobody_saw_is_said_to_be_so(processes: list[subprocess.Popen[str]]) -> None:
    outcome = stop(found(start(processes, "unseen")), "Ann", 10.0)
    assert not outcome.at_rest
    assert "nobody saw" in outcome.text


def test_a_run_without_ears_is_told_by_a_signal(processes: list[subprocess.Popen[str]], runtime: Path) -> None:
    pid = start(processes, "deaf")
    assert runs() == [Found(pid, ())], "known by the file only"
    messages: list[str] = []
    outcome = stop(found(pid), "Ann", 10.0, messages.append)
    assert "gets a signal" in messages[0]
    assert not outcome.at_rest


def test_a_run_that_hangs_is_left_aside_and_its_bus_process_told(
    processes: list[subprocess.Popen[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    bus = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)  # drivers.ethercat.process"], text=True)
    processes.append(bus)
    assert bus_processes(os.getpid()) == [bus.pid]
    pid = start(processes)
    run = found(pid)
    os.kill(pid, signal.SIGSTOP)
    monkeypatch.setattr("bench.stop_button.press.bus_processes", lambda _: [bus.pid])
    messages: list[str] = []
    outcome = stop(run, "Ann", 10.0, messages.append)
    assert not outcome.at_rest
    assert "its bus process gets the order" in messages[-1]
    assert bus.wait(5.0) == -signal.SIGTERM
    assert "look at the bench" in outcome.text


def test_a_run_that_hangs_alone_says_use_the_emergency_stop(processes: list[subprocess.Popen[str]]) -> None:
    pid = start(processes)
    run = found(pid)
    os.kill(pid, signal.SIGSTOP)
    outcome = stop(run, "Ann", 10.0)
    assert (outcome.at_rest, "use the emergency stop" in outcome.text) == (False, True)


def test_the_command_stops_whatever_runs(processes: list[subprocess.Popen[str]]) -> None:
    pid, code = start(processes), "from bench.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code, "stop", "--by", "Ann", "--json"], capture_output=True, cwd=ROOT)
    # runs of other runtime folders may go on on this computer
    said = next(one for one in json.loads(done.stdout) if one["pid"] == pid)
    assert (said["pid"], said["at_rest"], done.returncode) == (pid, True, 0)


def command(*options: str) -> subprocess.CompletedProcess[str]:
    code = "from bench.cli import main; main()"
    line = [sys.executable, "-c", code, "stop", *options]
    return subprocess.run(line, capture_output=True, text=True, cwd=ROOT, check=False)


def test_the_command_names_a_run_of_another_runtime_folder_and_leaves_it_alone(
    processes: list[subprocess.Popen[str]],
    runtime: Path,
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pid = start(processes)
    other = tmp_path_factory.mktemp("other")
    monkeypatch.setenv("BENCH_RUNTIME", str(other))
    done = command("--by", "Ann")
    assert done.returncode == 5
    assert f"No run was seen in the runtime folder {other} (BENCH_RUNTIME)." in done.stdout
    assert f"process {pid} runs a bench with the runtime folder {runtime}; " in done.stdout
    assert f"stop it: BENCH_RUNTIME={runtime} bench stop" in done.stdout
    said = next(one for one in json.loads(command("--json").stdout) if one["pid"] == pid)
    assert said["at_rest"] is None
    assert is_alive(pid)
    # with its own folder it is a run to be stopped, and none of another's
    monkeypatch.setenv("BENCH_RUNTIME", str(runtime))
    assert pid not in {run.pid for run in elsewhere()}
    assert stop(found(pid), "Ann", 10.0).at_rest


def test_where_nothing_is_seen_the_command_says_where_it_looked(
    runtime: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("bench.stop_button.find._listeners", list)
    stop_command(by="Ann", patience=1.0, as_json=False)
    assert capsys.readouterr().out == f"No run was seen; looked at: the runtime folder {runtime} (BENCH_RUNTIME).\n"
    monkeypatch.delenv("BENCH_RUNTIME")
    assert looked_at() == "every runtime folder on this computer"


def test_a_run_whose_folder_cannot_be_told_is_stopped_with_all_others() -> None:
    assert "with another runtime folder; stop every run" in how_to_stop(Found(2**22 + 1, ()))
    # the environment this process was started with is not that of the listener
    said = how_to_stop(Found(os.getpid(), (f"{listener.NAME}0123abcd-{os.getpid()}-1",)))
    assert "with another runtime folder; stop every run on this computer: env -u BENCH_RUNTIME bench stop" in said
