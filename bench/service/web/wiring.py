"""What routes have in common: the service behind a request, and the answers to what is refused."""

from __future__ import annotations

from typing import Any

from fastapi import Request
from fastapi.responses import JSONResponse

from bench.errors import BenchError, ConfigurationError, LimitError, RecordingError
from bench.service.data.recordings import UnknownPlace
from bench.service.files.once import IdUsedAgain
from bench.service.models import Problem
from bench.service.refusals import NotNow, Unknown
from bench.service.runs.lease import NotHeld
from bench.service.service import Service

STATUS: tuple[tuple[type[Exception], int], ...] = (
    (NotHeld, 403),
    (Unknown, 404),
    (UnknownPlace, 404),
    (NotNow, 409),
    (IdUsedAgain, 409),
    (LimitError, 422),
    (ConfigurationError, 422),
    (RecordingError, 422),
    (BenchError, 422),
)
"""HTTP status of a refusal, the first that fits."""

PROBLEMS: dict[int | str, dict[str, Any]] = {
    status: {"model": Problem, "description": description}
    for status, description in (
        (400, "the body cannot be read"),
        (401, "the token is missing or wrong"),
        (403, "somebody else holds the controls, or another site asks"),
        (404, "there is no such thing"),
        (405, "another method is wanted, see Allow"),
        (409, "not possible now"),
        (411, "the length of the request is missing"),
        (413, "the request is too long"),
        (415, "not JSON"),
        (421, "the service has another name"),
        (422, "the request is wrong"),
    )
}


def service_of(request: Request) -> Service:
    """Return the service a request is for."""
    service: Service = request.app.state.service
    return service


def problem(status: int, why: str) -> JSONResponse:
    """Return a refusal: one sentence."""
    return JSONResponse({"problem": why}, status)


def refusal(error: Exception) -> JSONResponse:
    """Return the answer for an error a user can mend."""
    return problem(next(status for kind, status in STATUS if isinstance(error, kind)), str(error))
