"""Who may talk to the service: Host and Origin are checked, beyond loopback a token is needed."""

from __future__ import annotations

import hmac
from collections.abc import Mapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import TYPE_CHECKING

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse

from bench.service.settings import Settings

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

COOKIE = "bench_session"
LONGEST_BODY = 300_000
HEADERS: dict[str, str] = {
    "Content-Security-Policy": (
        "default-src 'self'; connect-src 'self' http://127.0.0.1:*; img-src 'self' data:;"
        " style-src 'self' 'unsafe-inline'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "X-Frame-Options": "DENY",
    "Cache-Control": "no-cache",
}
"""On every answer; plots set styles, a run's own stop listener is asked, nothing else comes from elsewhere."""
REPORT_HEADERS: dict[str, str] = {
    "Content-Security-Policy": (
        "sandbox allow-downloads; default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'self'"
    ),
    "X-Frame-Options": "SAMEORIGIN",
}
"""Reports are pages made of data: they may show, inside the operator's page as well, and do nothing."""
_OPEN = ("/api/session", "/static/")
"""Paths that need no token: where one is shown, and the page's own files, which say nothing of the bench."""


@dataclass(frozen=True, slots=True)
class Refused:
    """Why a request is not answered."""

    status: int
    why: str


def check(
    settings: Settings, method: str, path: str, headers: Mapping[str, str], cookies: Mapping[str, str]
) -> Refused | None:
    """Return why a request is refused, None if it may pass. Header names are in lower case."""
    host = headers.get("host", "")
    if host.lower() not in settings.hosts:
        named = ", ".join(sorted(settings.hosts))
        return Refused(421, f'the service is not called "{host}"; it is {named}, other names are given with --name')
    if method not in ("GET", "HEAD"):
        origin = headers.get("origin")
        if origin is not None and origin.lower() not in {f"{settings.scheme}://{name}" for name in settings.hosts}:
            return Refused(403, f'a page of "{origin}" may not change anything here; use the page of the service')
        if headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
            return Refused(403, "another site may not change anything here; use the page of the service")
        kind = headers.get("content-type", "").split(";")[0].strip().lower()
        if method == "POST" and kind != "application/json":
            return Refused(415, "a change is asked for with JSON (Content-Type: application/json)")
    if settings.token is None or path == "/" or path.startswith(_OPEN):
        return None
    if _matches(settings.token, headers.get("authorization", "").removeprefix("Bearer ")):
        return None
    if _matches(settings.token, cookies.get(COOKIE, "")):
        return None
    return Refused(401, "the token is missing or wrong; open the page with the address the service printed")


class Guard:
    """ASGI middleware: refuses what :func:`check` refuses and bodies that are too long, adds the safe headers."""

    def __init__(self, app: ASGIApp, settings: Settings) -> None:
        self._app, self._settings = app, settings

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check, then hand on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return

        async def send_safe(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        headers = {name.lower(): value for name, value in Headers(scope=scope).items()}
        refused = check(self._settings, scope["method"], scope["path"], headers, _cookies(headers.get("cookie", "")))
        length = headers.get("content-length", "0")
        if refused is None and "transfer-encoding" in headers and scope["method"] == "POST":
            refused = Refused(411, "the length of a request has to be said (Content-Length)")
        if refused is None and not (length.isdigit() and int(length) <= LONGEST_BODY):
            refused = Refused(413, f"a request may hold {LONGEST_BODY} bytes")
        if refused is not None:
            await JSONResponse({"problem": refused.why}, refused.status)(scope, receive, send_safe)
        else:
            await self._app(scope, receive, send_safe)


def _cookies(header: str) -> dict[str, str]:
    try:
        return {name: morsel.value for name, morsel in SimpleCookie(header).items()}
    except CookieError:
        return {}


def _matches(token: str, shown: str) -> bool:
    return hmac.compare_digest(token.encode(), shown.encode("utf-8", "replace"))
