"""The archive over HTTP: search, comments and tags, putting aside, and downloads. Nothing can be deleted here."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends, Query
from fastapi import Path as InPath
from fastapi.responses import FileResponse, StreamingResponse
from starlette.background import BackgroundTask

from bench.archive import KINDS, RESULTS
from bench.archive import Query as Search
from bench.recording.header import KINDS as RECORDING_KINDS
from bench.service import models as m
from bench.service.data import downloads
from bench.service.data.recordings import inside
from bench.service.service import Service
from bench.service.web.wiring import PROBLEMS, service_of

router = APIRouter(prefix="/api", responses=PROBLEMS)
The = Annotated[Service, Depends(service_of)]
Place = Annotated[str, InPath(pattern=r"^[\w][\w .+\-]{0,99}$")]
Words = Annotated[str, Query(max_length=200)]
Moment = Annotated[str, Query(max_length=40, pattern=r"^[0-9T:.+Z\- ]*$")]
Value = Annotated[float | None, Query(ge=-1e9, le=1e9)]
Answer = dict[str, Any]
_FILE: dict[int | str, dict[str, Any]] = {200: {"content": {"application/octet-stream": {}}, "description": "a file"}}


@router.get("/archive", summary="Search recordings and campaigns")
async def search(
    service: The,
    words: Words = "",
    since: Moment = "",
    until: Moment = "",
    person: Words = "",
    gearbox: Words = "",
    bench: Words = "",
    kind: Words = "",
    result: Words = "",
    tag: Words = "",
    load_torque: Value = None,
    velocity: Value = None,
    temperature: Value = None,
    archived: bool = False,
    limit: Annotated[int, Query(ge=0, le=500)] = 100,
    offset: Annotated[int, Query(ge=0, le=10**9)] = 0,
) -> Answer:
    """Newest first, with how many there are at all, and how many in which folder.

    ``since`` and ``until`` are dates or times (ISO 8601), of this computer's zone where they name none; a date as
    ``until`` is included. Torque in N·m, velocity in rad/s, temperature in °C.
    """
    asked = Search(
        words,
        downloads.moment(since, False),
        downloads.moment(until, True),
        person,
        gearbox,
        bench,
        kind,
        result,
        tag,
        load_torque,
        velocity,
        temperature,
        archived,
        limit,
        offset,
    )
    return asdict(await service.searching(service.archive.find, asked))


@router.get("/archive/words", summary="What may be searched for")
async def choices(service: The) -> Answer:
    """Kinds and results of recordings, kinds of notes."""
    return {"kinds": RECORDING_KINDS, "results": RESULTS, "notes": KINDS}


@router.post("/archive/notes", summary="Comment, tag, or put aside")
async def note(body: m.NewNote, service: The) -> m.Done:
    """A line in the folder of the recordings, which never change themselves; nothing moves, no controls are needed."""

    async def act() -> m.Done:
        return m.Done(done=await service.searching(service.archive.note, body))

    answer: m.Done = await service.once(body.request_id, f"note {body.model_dump_json()}", act)
    return answer


@router.get(
    "/folders/{folder}/download",
    summary="A whole campaign as one file",
    response_class=StreamingResponse,
    responses=_FILE,
)
async def download_folder(folder: Place, service: The) -> StreamingResponse:
    """A tar archive of every file of the folder, as they lie there."""
    path = inside(service.settings.folder, folder)
    return StreamingResponse(
        downloads.tar(path), media_type="application/octet-stream", headers=downloads.attached(f"{folder}.tar")
    )


@router.get(
    "/folders/{folder}/{file}/download", summary="A recording as a file", response_class=FileResponse, responses=_FILE
)
async def download(
    folder: Place, file: Place, service: The, form: Literal["hdf5", "csv", "mat"] = "hdf5"
) -> FileResponse:
    """As it lies there, or exported in a process of its own; a long one takes its time then."""
    path = downloads.recording(inside(inside(service.settings.folder, folder), file))
    if form == "hdf5":
        return FileResponse(path, media_type="application/octet-stream", headers=downloads.attached(path.name))
    made = await service.exports(path, form)
    return FileResponse(
        made,
        media_type="application/octet-stream",
        headers=downloads.attached(made.name),
        background=BackgroundTask(downloads.remove, made.parent),
    )
