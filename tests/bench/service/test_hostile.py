"""What is sent or found by accident or by malice costs the one who sent it, never the service and never STOP."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import uvicorn

from bench.configuration import load_bench
from bench.errors import BenchError
from bench.service.campaigns import planning
from bench.service.readers import Readers
from bench.service.refusals import NotNow
from bench.service.web.patient import MOST_HALF_OPEN, PatientProtocol
from tests.bench.recording.builders import write
from tests.bench.service.conftest import Client
from tests.bench.service.test_joining import CAMPAIGN

HALF = b"POST /api/stop HTTP/1.1\r\nHost: x\r\nContent-Length: 100\r\n\r\n{"
ENDLESS = CAMPAIGN + "options = {{ revolutions = {revolutions} }}\n"


async def application(scope: Any, receive: Any, send: Any) -> None:
    while (await receive()).get("more_body"):
        pass
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
    await send({"type": "http.response.body", "body": b"ok"})


@pytest.fixture
def port(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A server with the service's patience, which is short here."""
    monkeypatch.setattr("bench.service.web.patient.WHOLE_S", 0.5)
    listening = socket.create_server(("127.0.0.1", 0), backlog=1024)
    config = uvicorn.Config(application, http=PatientProtocol, ws="none", lifespan="off", log_level="critical")
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]})
    thread.start()
    yield listening.getsockname()[1]
    server.should_exit = True
    thread.join(10)
    assert not PatientProtocol.half_open


def connected(port: int, said: bytes = b"") -> socket.socket:
    connection = socket.create_connection(("127.0.0.1", port), timeout=10)
    connection.sendall(said)
    return connection


def asked(port: int) -> tuple[bytes, float]:
    """Ask for an answer; return it and how long it took, s."""
    begin = time.monotonic()
    with connected(port, b"POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 2\r\n\r\n{}") as connection:
        return connection.recv(15), time.monotonic() - begin


@pytest.mark.parametrize("said", [b"", b"GET / HT", b"GET / HTTP/1.1\r\nHost: x\r\n", HALF])
def test_a_request_that_does_not_become_whole_is_hung_up_on(port: int, said: bytes) -> None:
    begin = time.monotonic()
    with connected(port, said) as connection, contextlib.suppress(ConnectionResetError):
        assert connection.recv(1) == b""
    assert 0.3 < time.monotonic() - begin < 5.0


def test_a_crowd_of_half_open_requests_holds_nobody_up(port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("bench.service.web.patient.WHOLE_S", 60.0)
    crowd = [connected(port, HALF) for _ in range(MOST_HALF_OPEN + 50)]
    answer, seconds = asked(port)
    assert answer == b"HTTP/1.1 200 OK"
    assert seconds < 1.0
    assert len(PatientProtocol.half_open) <= MOST_HALF_OPEN
    for connection in crowd:
        connection.close()
    deadline = time.monotonic() + 5.0
    while PatientProtocol.half_open and time.monotonic() < deadline:
        time.sleep(0.01)


def test_a_connection_that_was_answered_may_wait_for_its_next_request(port: int) -> None:
    with connected(port) as connection:
        for _ in range(2):
            connection.sendall(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
            answer = b""
            while not answer.endswith(b"ok"):
                answer += connection.recv(4096)
            assert answer.startswith(b"HTTP/1.1 200 OK")
            time.sleep(0.8)


@pytest.mark.parametrize("revolutions", ["inf", "1e300", "1e9"])
def test_a_campaign_of_endless_numbers_is_refused_and_soon(
    revolutions: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(planning, "PLAN_S", 0.5)
    path = tmp_path / "endless.toml"
    path.write_text(ENDLESS.format(revolutions=revolutions), encoding="utf-8")
    begin = time.monotonic()
    with pytest.raises(BenchError):
        planning._possible(str(path), load_bench("rh380n"), None, "run", tmp_path)
    assert time.monotonic() - begin < 10.0


def test_only_so_many_wait_and_none_holds_up_the_end() -> None:
    go = threading.Event()

    async def scene() -> None:
        readers = Readers("plans", at_once=1, most_waiting=1)
        tasks = [asyncio.create_task(readers(go.wait, 20)) for _ in range(2)]
        await asyncio.sleep(0.05)
        with pytest.raises(NotNow, match="too many plans"):
            await readers(go.wait, 20)
        assert all(thread.daemon for thread in threading.enumerate() if thread.name == "reader")
        go.set()
        assert await asyncio.gather(*tasks) == [True, True]

    asyncio.run(scene())


def test_links_that_lead_out_are_refused_and_broken_ones_are_not_there(client: Client, tmp_path: Path) -> None:
    root, outside = tmp_path / "recordings", tmp_path / "outside"
    (root / "inside").mkdir(parents=True)
    outside.mkdir()
    write(outside / "0001-secret.h5")
    (root / "out").symlink_to(outside)
    (root / "broken").symlink_to(tmp_path / "nowhere")
    (root / "loop").symlink_to(root / "loop")
    (root / "inside" / "0001-secret.h5").symlink_to(outside / "0001-secret.h5")
    (root / "inside" / "0002-gone.h5").symlink_to(outside / "gone.h5")
    names = {folder["name"] for folder in client.get("folders")}
    assert names == set()
    for path in ("out", "broken", "loop", "inside/0001-secret.h5/plot", "inside/0002-gone.h5/plot"):
        assert client.http.get(f"/api/folders/{path}").status_code == 404, path
    listed = client.get("folders/inside")
    assert all(recording["id"] is None for recording in listed)


def test_a_file_that_crashes_its_reader_does_not_crash_the_service(
    client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "recordings" / "first" / "0001-constant_velocity.h5"
    path.parent.mkdir(parents=True)
    path.touch()
    monkeypatch.setattr("bench.service.data.recordings.plot", crash)
    answer = client.http.get(f"/api/folders/first/{path.name}/plot")
    assert (answer.status_code, "crash" in answer.json()["problem"]) == (422, True)
    assert client.http.post("/api/stop", json={}).status_code == 200


def crash(path: Path, *stretch: float | None) -> None:
    os.abort()
