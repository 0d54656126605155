"""Whom the service lets in: loopback or TLS with a token, its own names, its own page; and no privileges left."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from starlette.testclient import TestClient

from bench.configuration import load_bench
from bench.errors import ConfigurationError, DeviceError
from bench.locks import service_for
from bench.service.client import Client as ServiceClient
from bench.service.client import Refused
from bench.service.settings import Settings
from bench.service.web.security import LONGEST_BODY, check
from tests.bench.service.conftest import BASE, Client, NoLauncher, made_app, served

TOKEN = "a-token-nobody-guesses"
HOST = {"host": "127.0.0.1:8080"}
JSON = {**HOST, "content-type": "application/json"}
TLS: dict[str, Any] = {"certificate": Path("c.pem"), "key": Path("k.pem")}


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"host": "0.0.0.0"}, "needs --tls-certificate and --tls-key and --token-file"),
        ({"host": "192.168.1.5", "token": TOKEN}, "needs --tls-certificate"),
        ({"host": "bench.lab", **TLS}, "needs --token-file"),
        ({"host": "::1:2", "token": "short", **TLS}, "shorter than 16"),
        ({"host": "::", "token": TOKEN, **TLS}, "needs --name"),
        ({"certificate": Path("c.pem")}, "only one of them"),
    ],
)
def test_an_address_others_reach_needs_tls_and_a_token(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ConfigurationError, match=sentence):
        Settings(**options)


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "::1", "127.8.8.8"])
def test_loopback_needs_neither(host: str) -> None:
    assert Settings(host=host).is_loopback


def test_only_its_own_names_are_answered() -> None:
    settings = Settings()
    for host in ("127.0.0.1:8080", "localhost:8080", "LOCALHOST:8080"):
        assert check(settings, "GET", "/", {"host": host}, {}) is None
    for host in ("evil.example", "evil.example:8080", "127.0.0.1", "127.0.0.1:81", ""):
        refused = check(settings, "GET", "/", {"host": host}, {})
        assert refused is not None
        assert refused.status == 421
    usual = Settings(host="bench.lab", port=443, token=TOKEN, **TLS)
    assert {"bench.lab", "bench.lab:443"} <= usual.hosts
    assert Settings(host="::1").url == "http://[::1]:8080"
    named = Settings(host="0.0.0.0", port=8443, names=("bench.lab",), token=TOKEN, **TLS)
    assert check(named, "GET", "/", {"host": "bench.lab:8443"}, {}) is None
    assert named.url == "https://bench.lab:8443"


@pytest.mark.parametrize(
    ("more", "status"),
    [
        ({"origin": "http://evil.example"}, 403),
        ({"origin": "https://127.0.0.1:8080"}, 403),
        ({"origin": "null"}, 403),
        ({"sec-fetch-site": "cross-site"}, 403),
        ({"content-type": "text/plain"}, 415),
        ({"content-type": "application/x-www-form-urlencoded"}, 415),
    ],
)
def test_other_sites_change_nothing(more: dict[str, str], status: int) -> None:
    refused = check(Settings(), "POST", "/api/stop", {**JSON, **more}, {})
    assert refused is not None
    assert refused.status == status
    same_site = {**JSON, "origin": "http://127.0.0.1:8080", "sec-fetch-site": "same-origin"}
    assert check(Settings(), "POST", "/api/stop", same_site, {}) is None


@given(st.text(max_size=40))
def test_no_token_but_the_token_opens(shown: str) -> None:
    settings = Settings(token=TOKEN)
    headers = {**HOST, "authorization": f"Bearer {shown}"}
    assert (check(settings, "GET", "/api/state", headers, {}) is None) == (shown == TOKEN)
    assert (check(settings, "GET", "/api/state", HOST, {"bench_session": shown}) is None) == (shown == TOKEN)


def test_a_token_is_shown_once_and_a_cookie_stands_for_it(tmp_path: Path) -> None:
    launcher = NoLauncher()
    with TestClient(made_app(Settings(folder=tmp_path, token=TOKEN), launcher), base_url=BASE) as http:
        assert http.get("/").status_code == 200
        assert http.get("/static/app.js").status_code == 200
        assert http.get("/api/state").status_code == 401
        assert http.post("/api/stop", json={}).status_code == 401
        assert http.post("/api/session", json={"token": "wrong"}).status_code == 401
        answer = http.post("/api/session", json={"token": TOKEN})
        assert "HttpOnly" in answer.headers["set-cookie"]
        assert "SameSite=strict" in answer.headers["set-cookie"]
        assert http.get("/api/state").status_code == 200
        assert TOKEN not in http.get("/api/state").text


def test_answers_carry_the_safe_headers_and_long_bodies_are_refused(client: Client) -> None:
    for path in ("/", "/static/app.js", "/api/state", "/api/none"):
        answer = client.http.get(path)
        assert answer.headers["x-content-type-options"] == "nosniff"
        assert "default-src 'self'" in answer.headers["content-security-policy"]
    long = client.http.post(
        "/api/stop", content=b" " * (LONGEST_BODY + 1), headers={"content-type": "application/json"}
    )
    assert long.status_code == 413


def test_the_page_asks_nothing_of_any_other_host() -> None:
    static = Path(sys.modules["bench.service"].__file__ or "").parent / "static"
    for file in static.glob("*.*"):
        # the run's own stop listener is on this computer
        text = file.read_text("utf-8").replace("http://www.w3.org/2000/svg", "").replace("http://127.0.0.1:${port}", "")
        assert "http://" not in text, file
        assert "https://" not in text, file
    assert "MIT License" in (static / "vendor" / "uplot" / "LICENSE").read_text("utf-8")


@pytest.mark.parametrize("name", ["..", ".service", "a/b", "..%2f..", "%2e%2e", "\u202e", "C:\\x"])
def test_names_lead_nowhere_else(client: Client, name: str) -> None:
    assert client.http.get(f"/api/folders/{name}").status_code in (404, 422)
    assert client.http.get(f"/api/folders/{name}/x.h5/plot").status_code in (404, 422)


def test_no_capability_is_left_and_none_comes_back() -> None:
    script = (
        "import subprocess, sys; from bench.service.privileges import drop; drop();"
        "print(open('/proc/self/status').read());"
        "print(subprocess.run([sys.executable, '-c', \"print(open('/proc/self/status').read())\"],"
        " capture_output=True, text=True).stdout)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    for kind in ("CapEff", "CapPrm", "CapAmb"):
        masks = [line.split()[1] for line in done.stdout.splitlines() if line.startswith(kind)]
        assert masks == ["0" * 16] * 2, kind


def test_tls_and_token_from_end_to_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if shutil.which("openssl") is None:
        pytest.skip("there is no openssl here to make a certificate with")
    names = ["-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"]
    made = [
        "openssl",
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-keyout",
        "k.pem",
        "-out",
        "c.pem",
    ]
    subprocess.run([*made, *names], cwd=tmp_path, check=True, capture_output=True)
    certificate, key, token = tmp_path / "c.pem", tmp_path / "k.pem", tmp_path / "token"
    options = ["--tls-certificate", str(certificate), "--tls-key", str(key), "--token-file", str(token)]
    with served(tmp_path / "recordings", *options, "--name", "localhost") as address:
        assert token.stat().st_mode & 0o077 == 0
        found = service_for(load_bench("rh380n"))
        assert found is not None
        assert found["url"] == address.replace("http://127.0.0.1", "https://localhost")
        client = ServiceClient.at(found)
        assert client.get("health")["alive"]
        with pytest.raises(Refused, match="the token is missing or wrong"):
            ServiceClient(found["url"], "guessed", found["certificate"]).get("health")
        with pytest.raises(DeviceError, match="certificate"):
            ServiceClient(found["url"], found["token"]).get("health")
