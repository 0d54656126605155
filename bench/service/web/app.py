"""The web application: pages, API, OpenAPI description (``/openapi.json``); every request passes the checks first."""

from __future__ import annotations

import asyncio
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib import resources
from typing import Annotated

from fastapi import Depends, FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import FileResponse, JSONResponse
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException

from bench.errors import BenchError
from bench.service import models
from bench.service.runs.launcher import Launcher
from bench.service.service import Service
from bench.service.settings import Settings
from bench.service.watchdog import feed
from bench.service.web import routes_acts, routes_archive, routes_data, routes_jog, routes_plan, routes_trend
from bench.service.web.security import COOKIE, Guard, check
from bench.service.web.wiring import PROBLEMS, problem, refusal, service_of
from bench.version import __version__


def create_app(settings: Settings, launcher: Launcher) -> FastAPI:
    """Return the application; its service begins and ends with it."""

    @asynccontextmanager
    async def life(app: FastAPI) -> AsyncIterator[None]:
        service = Service(settings, launcher)
        app.state.service = service
        service.open()
        # routes are put together when they are first asked for; STOP may be the first request
        app.openapi()
        watchdog = asyncio.get_running_loop().create_task(feed(service))
        try:
            yield
        finally:
            watchdog.cancel()
            await service.close()

    app = FastAPI(
        title="Gearbox bench",
        version=__version__,
        description="One bench: its runs, operators, recordings. Changes by POST only, each once per request id.",
        lifespan=life,
        docs_url=None,
        redoc_url=None,
    )
    app.include_router(routes_acts.router)
    app.include_router(routes_data.router)
    app.include_router(routes_plan.router)
    app.include_router(routes_archive.router)
    app.include_router(routes_trend.router)
    app.include_router(routes_jog.router)

    @app.post("/api/session", responses=PROBLEMS, summary="Show the token")
    async def session(body: models.Session, service: Annotated[Service, Depends(service_of)]) -> Response:
        """A cookie stands for the token afterwards, in this browser only."""
        token = service.settings.token
        answer = JSONResponse({"done": "welcome"})
        if token is not None:
            if check(settings, "GET", "/api/state", {"host": next(iter(settings.hosts))}, {COOKIE: body.token}):
                return problem(401, "the token is wrong")
            answer.set_cookie(
                COOKIE, token, max_age=30 * 86400, httponly=True, samesite="strict", secure=settings.scheme == "https"
            )
        return answer

    _add_page(app)
    _add_refusals(app)
    app.add_middleware(Guard, settings=settings)
    return app


def _add_page(app: FastAPI) -> None:
    static = resources.files("bench.service") / "static"

    @app.get("/", include_in_schema=False)
    async def page() -> FileResponse:
        return FileResponse(str(static / "index.html"), headers={"Cache-Control": "no-cache"})

    app.mount("/static", StaticFiles(directory=str(static)), name="static")


def _add_refusals(app: FastAPI) -> None:
    @app.exception_handler(BenchError)
    async def on_bench_error(request: Request, error: Exception) -> JSONResponse:
        return refusal(error)

    @app.exception_handler(RequestValidationError)
    async def on_wrong_request(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, RequestValidationError)
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        return problem(422, f"{where}: {first['msg']}")

    @app.exception_handler(HTTPException)
    async def on_http(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, HTTPException)
        answer = problem(error.status_code, str(error.detail))
        answer.headers.update(error.headers or {})
        described = _methods(request) if error.status_code == 405 else set()
        if described:
            answer.headers["Allow"] = ", ".join(sorted(described))
        return answer


def _methods(request: Request) -> set[str]:
    """Every method that is described for the path of a request: more than one route may have it."""
    found: set[str] = set()
    for template, methods in request.app.openapi()["paths"].items():
        if re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", template), request.url.path):
            found |= {method.upper() for method in methods}
    return found
