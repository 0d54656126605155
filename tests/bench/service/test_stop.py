"""A limit stops a real run: the alarm says why, and torque comes back by three acts of whoever holds the controls."""

from __future__ import annotations

import json
import re
import secrets
import socket
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bench.configuration import load_bench
from tests.bench.service.conftest import DEADLINE_S, served
from tests.bench.service.test_joining import CAMPAIGN
from tests.program import bench


class Operator:
    def __init__(self, address: str) -> None:
        self._address = address
        self.secret = self.post("controls/take", name="Ann")["secret"]

    def post(self, path: str, **body: Any) -> Any:
        content = json.dumps({"request_id": secrets.token_hex(8), **body}).encode()
        request = urllib.request.Request(f"{self._address}/api/{path}", content)
        request.add_header("Content-Type", "application/json")
        try:
            with urllib.request.urlopen(request, timeout=DEADLINE_S) as answer:
                return json.load(answer)
        except urllib.error.HTTPError as error:
            with error:
                return {"status": error.code, **json.load(error)}

    def act(self, path: str, **more: Any) -> Any:
        return self.post(path, secret=self.secret, **more)

    def message(self, kind: str) -> Any:
        with urllib.request.urlopen(f"{self._address}/api/state", timeout=30) as answer:
            return next(message for message in json.load(answer) if message["type"] == kind)

    def until(self, what: Callable[[], Any]) -> Any:
        deadline = time.monotonic() + DEADLINE_S
        while not (found := what()):
            assert time.monotonic() < deadline, "it did not happen in time"
            time.sleep(0.05)
        return found

    def ended(self, number: int) -> Any:
        """The n-th run, once it has ended."""
        runs = self.message("runs")["runs"]
        return runs[number] if len(runs) > number and runs[number]["state"] == "ended" else None


def test_acknowledge_reset_and_go_on_after_a_stop(tmp_path: Path) -> None:
    text = load_bench("rh380n").text
    strict = tmp_path / "strict.toml"
    (line,) = [row for row in text.splitlines() if row.startswith("velocity_error")]
    strict.write_text(text.replace(line, 'velocity_error = "0.02 rad/s"'))
    with served(tmp_path / "recordings", "--bench", str(strict)) as address:
        ann = Operator(address)
        run = ann.post("runs", name="Ann", secret=ann.secret, text=CAMPAIGN, folder="strict")
        end = ann.until(lambda: ann.ended(0))["end"]
        assert (end["kind"], end["cause"]) == ("tripped", "VELOCITY_ERROR")
        (alarm,) = ann.message("state")["alarms"]
        assert "limits.velocity_error" in alarm["text"]
        assert "does not follow" in alarm["what_to_do"]
        for path, more in ((f"runs/{run['id']}/again", {}), ("reset", {"run": run["id"]})):
            refused = ann.act(path, **more)
            assert (refused["status"], "next is to acknowledge" in refused["problem"]) == (409, True)
        ann.act(f"alarms/{alarm['number']}/acknowledge")
        assert ann.message("state")["latch"]["due"] == "reset"
        assert "next is to reset" in ann.act(f"runs/{run['id']}/again")["problem"]
        ann.act("reset", run=run["id"])
        assert ann.until(lambda: ann.ended(1))["end"]["kind"] == "finished"
        assert ann.message("state")["latch"]["due"] == "resume"
        ann.act(f"runs/{run['id']}/again")
        # it gets torque again, and stops again for the same reason
        assert ann.until(lambda: ann.ended(2))["end"]["kind"] == "tripped"
        assert ann.message("state")["latch"]["due"] == "acknowledge"
        with urllib.request.urlopen(f"{address}/api/book", timeout=30) as answer:
            acts = [entry["act"] for entry in json.load(answer) if entry["by"] == "Ann"]
        assert [act for act in reversed(acts) if act in ("acknowledge", "reset", "again")] == [
            "acknowledge",
            "reset",
            "again",
        ]


WRONG = {
    "--host 0.0.0.0": "TLS|--tls-certificate",
    "--tls-certificate c.pem": "--tls-key",
    "--tls-certificate c.pem --tls-key k.pem": "there is no such file",
    "--campaigns nowhere": "there is no such folder",
    "--model nowhere.json": "there is no such file",
    "--folder file": "a file, and a folder is wanted",
    "--port TAKEN": "another program has port",
}


@pytest.mark.parametrize("options", WRONG)
def test_what_cannot_be_served_is_refused_with_a_sentence(
    options: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    with socket.create_server(("127.0.0.1", 0)) as taken:
        given = options.replace("TAKEN", str(taken.getsockname()[1])).split()
        done = bench(["serve", *given])
    assert (done.code, done.out) == (3, "")
    (sentence,) = done.err.splitlines()
    assert sentence.startswith("error: ")
    assert re.search(WRONG[options], sentence)
