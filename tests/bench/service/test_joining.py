"""``bench run`` and a service for the same bench: it joins the queue and follows the run."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from rich.console import Console

from bench.cli._joined import _report_end
from bench.configuration import load_bench
from bench.errors import DeviceError
from bench.locks import bus_in_use, folder_in_use, service_for, serving
from bench.service.client import Client, Refused
from tests.bench.service.conftest import DEADLINE_S, served

CAMPAIGN = """
format = "bench-campaign"
format_version = "1.0"
name = "joined"
title = "Two fast points"
[[stages]]
name = "one"
[[stages.points]]
sequence = "constant_velocity"
velocities = ["60 deg/s", "-60 deg/s"]
"""
BENCH_RUN = [sys.executable, "-c", "from bench.cli import main; main()", "run"]


def test_one_service_a_bus_and_its_address_is_found() -> None:
    file = load_bench("rh380n")
    assert service_for(file) is None
    with serving(file, {"url": "http://127.0.0.1:1"}):
        found = service_for(file)
        assert found is not None
        assert (found["url"], found["pid"]) == ("http://127.0.0.1:1", os.getpid())
        assert service_for(load_bench("rv80n")) is None
        with pytest.raises(DeviceError, match="a service for emulated-rh380n runs already"), serving(file, {}):
            pass
    # what is left of a service that was killed is no service
    assert service_for(file) is None


def test_one_service_a_folder(tmp_path: Path) -> None:
    with folder_in_use(tmp_path / ".service", {"url": "http://127.0.0.1:1"}):
        with (
            pytest.raises(DeviceError, match=r"http://127\.0\.0\.1:1 keeps its recordings in .* too"),
            folder_in_use(tmp_path / ".service", {}),
        ):
            pass
        with folder_in_use(tmp_path / "other", {}):
            pass


def test_a_bus_has_one_user() -> None:
    from bench.configuration import on_interface

    file = on_interface(load_bench("rh380n"), "eth9")
    with bus_in_use(file):
        with pytest.raises(DeviceError, match=f"eth9 is in use by process {os.getpid()}"), bus_in_use(file):
            pass
        with bus_in_use(load_bench("rh380n")), bus_in_use(load_bench("rh380n")):
            pass


def test_what_a_service_cannot_take_is_refused_before_it_is_asked() -> None:
    client = Client("http://127.0.0.1:1", folder="/recordings")
    with pytest.raises(Refused, match="give a name without folder"):
        client.ask("quick", Path("else/where"), False, 0)
    with pytest.raises(Refused, match="is a program"):
        client.ask("mine.py", None, False, 0)
    with pytest.raises(DeviceError, match="does not answer"):
        client.ask("quick", Path("/recordings/first"), False, 0)


def test_a_service_that_falls_silent_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bench.service.client._TIMEOUT_S", 0.3)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            page, _ = server.accept()
            with page:
                page.recv(65536)
                page.sendall(b'HTTP/1.1 200 OK\r\nContent-Length: 1000\r\n\r\ndata: {"type": "beat"}\n')
                time.sleep(1.0)

        thread = threading.Thread(target=answer)
        thread.start()
        events = Client(f"http://127.0.0.1:{server.getsockname()[1]}").events()
        assert next(events) == {"type": "beat"}
        with pytest.raises(DeviceError, match="does not answer any more"):
            next(events)
        thread.join()


def test_bench_run_joins_the_queue_follows_and_reports(tmp_path: Path) -> None:
    campaign = tmp_path / "joined.toml"
    campaign.write_text(CAMPAIGN)
    # a name longer than a Unix socket's path may be
    recordings = tmp_path / ("recordings-of-the-laboratory-" * 4)
    with served(recordings) as address:
        done = subprocess.run(
            [*BENCH_RUN, str(campaign), "--out", "first", "--json"], capture_output=True, text=True, cwd=tmp_path
        )
        assert done.returncode == 0, done.stderr
        answer = json.loads(done.stdout)
        assert (answer["kind"], answer["recordings"]) == ("finished", 2)
        assert Path(answer["folder"]) == recordings / "first"
        assert len(list(Path(answer["folder"]).glob("*.h5"))) == 2
        assert "joins its queue" in done.stderr
        # Ctrl-C in the shell brings the bench to rest, as it does without a service
        follower = subprocess.Popen(
            [*BENCH_RUN, "paper", "--real-time", "--json"], cwd=tmp_path, stdout=subprocess.PIPE
        )
        deadline = time.monotonic() + DEADLINE_S
        folder = recordings
        while not list(folder.glob("paper-*/journal.sqlite")):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        follower.send_signal(signal.SIGINT)
        assert follower.wait(DEADLINE_S) == 130
        runs = folder / ".service" / "runs.json"
        while json.loads(runs.read_text("utf-8"))[-1]["state"] != "ended":
            assert time.monotonic() < deadline
            time.sleep(0.05)
        assert json.loads(runs.read_text("utf-8"))[-1]["end"]["kind"] == "interrupted"
        if follower.stdout is not None:
            follower.stdout.close()
        # what the guide shows of the API does what it says
        guide = (Path(__file__).parents[3] / "docs" / "operator.md").read_text("utf-8")
        (script,) = [part.split("```")[0] for part in guide.split("```python\n")[1:]]
        exec(compile(script.replace("http://127.0.0.1:8080", address), "docs/operator.md", "exec"), {})
        last = json.loads(runs.read_text("utf-8"))[-1]
        assert last["by"] == "Ann"
        # STOP came at once: the run has not begun, or is brought to rest
        while last["state"] not in ("queued", "ended"):
            assert time.monotonic() < deadline + DEADLINE_S
            time.sleep(0.05)
            last = json.loads(runs.read_text("utf-8"))[-1]
        assert last["end"].get("kind", "interrupted") == "interrupted"


@pytest.mark.parametrize(
    ("kind", "cause", "code"),
    [
        ("tripped", "RECORDER", 7),
        ("tripped", "BUS_ENDED", 5),
        ("tripped", "MOTOR_SPEED", 4),
        ("tripped", "of another program", 4),
        ("interrupted", "OPERATOR", 130),
    ],
)
def test_a_run_that_joined_ends_with_the_code_of_what_stopped_it(kind: str, cause: str, code: int) -> None:
    run = {"id": "1", "folder": "first", "end": {"kind": kind, "cause": cause, "text": "why"}}
    assert _report_end(run, Console(quiet=True), as_json=False) == code
