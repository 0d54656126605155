"""Trends over HTTP: which gearboxes there are, and each over its campaigns."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query

from bench.service.data import downloads
from bench.service.service import Service
from bench.service.web.wiring import PROBLEMS, service_of

router = APIRouter(prefix="/api", responses=PROBLEMS)
The = Annotated[Service, Depends(service_of)]
Serial = Annotated[str, Query(max_length=200)]
Moment = Annotated[str, Query(max_length=40, pattern=r"^[0-9T:.+Z\- ]*$")]
Answer = dict[str, Any]


@router.get("/gearboxes", summary="Serial numbers of gearboxes")
async def gearboxes(service: The) -> list[Answer]:
    """With how many campaigns there are of each; the empty one stands for recordings that name none."""
    found: list[Answer] = await service.searching(service.archive.gearboxes)
    return found


@router.get("/trend", summary="A gearbox over its campaigns")
async def trend(service: The, gearbox: Serial, since: Moment = "") -> Answer:
    """Series with limits of control, and what changed since the last campaign, of what is identified so far.

    An identification of a folder (``POST /api/analyses``) adds it. ``since`` leaves out what was before a date.
    """
    found: Answer = await service.searching(service.archive.trend, gearbox, downloads.moment(since, False))
    return found
