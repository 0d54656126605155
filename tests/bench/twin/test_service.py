"""A run of the service with a twin: what it sees is an alarm on the page, and by choice a pause."""

from __future__ import annotations

import shutil
import time
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from bench.service.runs.keeper import Keeper
from bench.service.settings import Settings
from tests.bench.service.conftest import BASE, Client, NoLauncher, made_app, own_locks
from tests.bench.twin.conftest import Known

__all__ = ["own_locks"]
LONGEST_S = 400.0
"""a twin gives way to everybody: on a machine that is busy it takes its time"""


def test_what_the_twin_sees_is_an_alarm_and_a_pause(
    known: Known, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wishes: list[tuple[str, Any]] = []

    def send_to_run(self: Keeper, wish: str, **more: Any) -> bool:
        wishes.append((wish, more["run"]))
        return True

    monkeypatch.setattr(Keeper, "send_to_run", send_to_run)
    root = tmp_path / "recordings"
    analysis = root / ".service" / "analyses" / "one"
    analysis.mkdir(parents=True)
    shutil.copy(known.model, analysis / "model.json")
    (analysis / "analysis.json").write_text(
        '{"id": "one", "kind": "identify", "folder": "known", "asked_at": "", "by": "Ann", "state": "done"}'
    )
    launcher = NoLauncher()
    with TestClient(made_app(Settings(folder=root), launcher), base_url=BASE) as http:
        client = Client(http, launcher)
        client.take()
        body = {"name": "Ann", "secret": client.secret, "campaign": "quick", "folder": "watched"}
        refused = client.ask("runs", 404, **body, twin="another")
        assert "no analysis" in refused["problem"]
        run = client.ask("runs", **body, twin="one", twin_pause=True)
        client.until(lambda: client.state("runs")["runs"][-1]["state"] == "running")
        # as a run leaves them: each whole from the moment it has its name
        shutil.copytree(known.walks, tmp_path / "made")
        (tmp_path / "made").rename(run["folder"])
        deadline = time.monotonic() + LONGEST_S
        while not client.state("state")["alarms"]:
            assert time.monotonic() < deadline, client.get("book")
            time.sleep(0.2)
        (alarm,) = client.state("state")["alarms"]
        assert alarm["cause"] == "TWIN"
        assert "the model no longer holds, likely since" in alarm["text"]
        assert "bench mismatch" in alarm["what_to_do"]
        # what the page compares before and since with
        assert alarm["folder"] == "watched"
        assert alarm["point"] in alarm["text"]
        client.until(lambda: wishes)
        assert wishes == [("pause", run["id"])]
    launcher.end_all()
