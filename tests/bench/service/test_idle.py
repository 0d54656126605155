"""Between runs: the bench is read without torque, a process stands ready, and a run is done by that very process."""

from __future__ import annotations

import io
import json
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from bench.configuration import load_bench
from bench.cycle.rig import Rig
from bench.service.process.condition import condition
from bench.service.process.ready import Order, Spec, _watch
from bench.service.runs.launcher import serve
from bench.service.runs.runs import process_of
from bench.service.runs.standby import Standby, leads_to
from tests.bench.service.conftest import DEADLINE_S, served


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    with served(tmp_path / "recordings") as url:
        yield url


def message(address: str, kind: str) -> dict[str, Any]:
    with urllib.request.urlopen(f"{address}/api/state", timeout=10) as answer:
        return next((message for message in json.load(answer) if message["type"] == kind), {})


def post(address: str, path: str, **body: Any) -> Any:
    data = {"request_id": f"request-{time.monotonic_ns()}", **body}
    request = urllib.request.Request(f"{address}/api/{path}", json.dumps(data).encode())
    request.add_header("Content-Type", "application/json")
    with urllib.request.urlopen(request, timeout=60) as answer:
        return json.load(answer)


def until(what: Callable[[], Any]) -> None:
    deadline = time.monotonic() + 2 * DEADLINE_S
    while not what():
        assert time.monotonic() < deadline, "it did not happen in time"
        time.sleep(0.05)


def test_a_bench_that_is_open_tells_values_drives_circuits_and_bus_without_moving() -> None:
    with Rig(load_bench("rh380n")) as rig:
        seen = condition(rig, "idle")
        assert seen is not None
        assert seen["drives"] == {"input_drive": "SWITCH_ON_DISABLED", "load_drive": "SWITCH_ON_DISABLED"}
        assert seen["inputs"] == {"emergency_stop": False, "safe_torque_off": False}
        assert seen["bus"]["bad"] == 0
        assert seen["bus"]["cycles"] > 0
        assert seen["values"]["temperature"] == pytest.approx(rig.temperature, abs=0.1)
        assert seen["values"]["motor_velocity"] == pytest.approx(0.0, abs=1e-3)
        rig.enable()
        enabled = condition(rig, "run")
        assert enabled is not None
        assert set(enabled["drives"].values()) == {"OPERATION_ENABLED"}
        assert json.dumps(enabled, allow_nan=False)


def test_a_bench_that_was_not_read_tells_nothing() -> None:
    assert condition(Rig(load_bench("rh380n")), "idle") is None


def test_the_bench_is_read_between_runs_and_the_process_that_stood_ready_does_the_run(
    address: str, tmp_path: Path
) -> None:
    until(lambda: message(address, "condition").get("source") == "idle")
    assert message(address, "condition")["drives"]["load_drive"] == "SWITCH_ON_DISABLED"
    first = message(address, "condition")["at"]
    until(lambda: message(address, "condition")["at"] > first)
    secret = post(address, "controls/take", name="Ann")["secret"]
    run = post(address, "runs", name="Ann", secret=secret, campaign="quick", real_time=True)
    until(lambda: message(address, "condition").get("source") == "run")
    (running,) = [one for one in message(address, "runs")["runs"] if one["state"] == "running"]
    command = Path(f"/proc/{running['pid']}/cmdline").read_bytes()
    assert b"bench.service.process.ready" in command
    # a service that is started anew finds it by its job
    job = tmp_path / "recordings" / ".service" / "runs" / run["id"] / "job.json"
    assert process_of(job) == running["pid"]
    post(address, "run/abort", secret=secret, run=run["id"])
    until(lambda: message(address, "runs")["runs"][-1]["state"] == "ended")
    assert message(address, "runs")["runs"][-1]["end"]["kind"] == "interrupted"
    until(lambda: message(address, "condition").get("source") == "idle")


def test_a_job_is_started_without_a_process_that_stands_ready(tmp_path: Path) -> None:
    assert Standby().take(str(tmp_path / "job.json"), str(tmp_path / "log.txt")) is None
    messages: list[dict[str, Any]] = []
    order = json.dumps({"job": str(tmp_path / "none.json"), "log": str(tmp_path / "log.txt")})
    serve(io.StringIO(order + "\n"), messages.append)
    assert messages[0]["job"] == str(tmp_path / "none.json")
    until(lambda: any("exited" in one for one in messages))
    assert "none.json" in (tmp_path / "log.txt").read_text()


def test_a_job_that_has_come_already_waits_for_no_bench_to_be_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO('{"job": "job.json", "log": "log.txt"}\n'))
    order = Order()
    until(lambda: order.wait(0.0))
    opened: list[Rig] = []
    monkeypatch.setattr(Rig, "open", opened.append)
    messages: list[dict[str, Any]] = []
    _watch(Spec("", "rh380n"), order, messages.append)
    assert opened == messages == []


def test_a_process_that_stood_ready_is_found_by_where_its_link_leads(tmp_path: Path) -> None:
    job = tmp_path / "job.json"
    link = tmp_path / "ready-1"
    link.symlink_to(job)
    wanted = str(job).encode()
    assert leads_to(str(link).encode(), wanted)
    assert not leads_to(str(link).encode(), b"/another/job.json")
    assert not leads_to(str(tmp_path / "ready-2").encode(), wanted)
    (tmp_path / "other").symlink_to(job)
    assert not leads_to(str(tmp_path / "other").encode(), wanted)
