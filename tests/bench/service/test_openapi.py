"""The OpenAPI description, fuzzed: whatever is sent, the service answers as described and never with its own fault."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from schemathesis.checks import (
    content_type_conformance,
    not_a_server_error,
    response_schema_conformance,
    status_code_conformance,
)
from starlette.testclient import TestClient

from bench.service.settings import Settings
from bench.service.web.app import create_app
from tests.bench.service.conftest import BASE, NoLauncher
from tests.bench.service.conftest import description as described

CHECKS = [not_a_server_error, status_code_conformance, content_type_conformance, response_schema_conformance]
ENDLESS = "/api/events"


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    launcher = NoLauncher()
    application = create_app(Settings(folder=tmp_path_factory.mktemp("fuzzed")), launcher)
    with TestClient(application, base_url=BASE):
        yield application
    launcher.end_all()


@pytest.fixture(scope="module")
def description(app: Any) -> Any:
    return schemathesis.openapi.from_asgi("/openapi.json", app, headers={"Host": "127.0.0.1:8080"})


PATHS = described()["paths"]
OPERATIONS = [(path, method) for path, methods in PATHS.items() if path != ENDLESS for method in methods]


@pytest.mark.parametrize(("path", "method"), OPERATIONS, ids=lambda value: value)
def test_every_request_is_answered_as_described(description: Any, path: str, method: str) -> None:
    @given(case=description[path][method].as_strategy())
    @settings(
        max_examples=8,
        deadline=None,
        database=None,
        phases=[Phase.explicit, Phase.generate],
        suppress_health_check=list(HealthCheck),
        derandomize=True,
    )
    def fuzz(case: Any) -> None:
        case.call_and_validate(headers={"Host": "127.0.0.1:8080"}, checks=CHECKS)

    fuzz()


def test_changes_are_posts_and_every_path_is_described() -> None:
    for path, methods in PATHS.items():
        assert set(methods) <= {"get", "post"}, path
        for method in methods.values():
            assert method["summary"]
            assert method["description"]
    assert {"/api/stop", "/api/runs", "/api/events", "/api/controls/take"} <= set(PATHS)


@pytest.mark.parametrize("method", ["DELETE", "PUT", "PATCH", "OPTIONS", "HEAD", "TRACE"])
def test_a_method_that_is_not_there_is_refused_with_those_that_are(app: Any, method: str) -> None:
    client = TestClient(app, base_url=BASE)
    for path, methods in PATHS.items():
        answer = client.request(method, path.replace("{", "").replace("}", ""))
        # a path that does not match its pattern is refused for that
        assert answer.status_code == 405, path
        assert {one.strip().lower() for one in answer.headers["allow"].split(",")} == set(methods), path


@pytest.mark.parametrize("body", [b"", b"{", b"\xff\xfe", b"[]", b"null", b'"x"', b"1e999", b'{"a":NaN}', b"[" * 5000])
def test_a_body_that_is_none_is_refused_as_described(app: Any, body: bytes) -> None:
    client = TestClient(app, base_url=BASE)
    for path, methods in PATHS.items():
        if "post" not in methods:
            continue
        answer = client.post(
            path.replace("{number}", "1").replace("{", "").replace("}", ""),
            content=body,
            headers={"content-type": "application/json"},
        )
        assert str(answer.status_code) in methods["post"]["responses"], (path, answer.status_code)
        assert answer.status_code in (400, 422), (path, answer.text)
        assert answer.json()["problem"]
