"""What can be read over HTTP: state, events, history, campaigns, recordings, analyses, storage, the book."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Depends
from fastapi import Path as InPath
from fastapi import Query as InQuery
from fastapi.responses import FileResponse, StreamingResponse

from bench.campaigns.operator.remark import clean_remark
from bench.service import models as m
from bench.service.analyses.analyses import investigation_of
from bench.service.analyses.since import since_last
from bench.service.data import recordings
from bench.service.refusals import NotNow, Unknown
from bench.service.service import Service
from bench.service.web.security import REPORT_HEADERS
from bench.service.web.wiring import PROBLEMS, service_of

router = APIRouter(prefix="/api", responses=PROBLEMS)
The = Annotated[Service, Depends(service_of)]
Place = Annotated[str, InPath(pattern=r"^[\w][\w .+\-]{0,99}$")]
AnalysisId = Annotated[str, InPath(pattern=r"^[0-9A-Za-z\-]{1,40}$")]
Second = Annotated[float, InQuery(ge=0.0, le=1e9)]
Answer = dict[str, Any]
_MOST_PAGES = 64


@router.get("/state", summary="Everything a page starts with")
async def state(service: The) -> list[Answer]:
    """The messages a stream of events begins with."""
    return service.greeting()


@router.get(
    "/events",
    summary="What happens, as server-sent events",
    response_class=StreamingResponse,
    responses={200: {"content": {"text/event-stream": {}}, "description": "events"}},
)
async def events(service: The) -> StreamingResponse:
    """The state now, then every change; a beat at least every two seconds."""
    if service.stream.pages >= _MOST_PAGES:
        raise NotNow(f"{_MOST_PAGES} pages look on already; close one")
    stream = service.stream.events(service.greeting())
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}
    return StreamingResponse(stream, media_type="text/event-stream", headers=headers)


@router.get("/history/{detail}", summary="Live values so far")
async def history(detail: Literal["fine", "coarse"], service: The) -> list[Answer]:
    """``fine``: the last minutes as they came; ``coarse``: the last hours in stretches of ten seconds."""
    return service.keeper.shown.history.fine() if detail == "fine" else service.keeper.shown.history.coarse()


@router.get("/folders", summary="Folders of recordings")
async def folders(service: The) -> list[Answer]:
    """Newest first."""
    return await service.reading(recordings.folders, service.settings.folder)


@router.get("/folders/{folder}", summary="Recordings of a folder")
async def folder_recordings(folder: Place, service: The) -> list[Answer]:
    """In the order they were made; ``why`` says what is wrong with a file that is of no use."""
    return await service.reading(recordings.recordings_of, service.settings.folder, folder)


@router.get("/folders/{folder}/{file}/plot", summary="A recording for plotting")
async def plot(folder: Place, file: Place, service: The, start: Second = 0.0, stop: Second | None = None) -> Answer:
    """Minimum, mean and maximum of each channel in 800 parts of a stretch, s since the first sample; gaps as gaps."""
    return await service.reading(recordings.plot_of, service.settings.folder, folder, file, start, stop)


@router.get("/folders/{folder}/{file}/revolution", summary="Transmission error of a recording")
async def revolution(folder: Place, file: Place, service: The) -> Answer:
    """Curve and order spectrum over a revolution, with the chosen model over it."""
    measured = await service.reading(recordings.revolution_of, service.settings.folder, folder, file)
    return await service.reading(service.overlay.add, measured)


@router.get("/analyses", summary="Identifications and mismatch reports")
async def analyses(service: The) -> Answer:
    """Newest first, with progress."""
    return service.analyses.message()


@router.post("/analyses", summary="Start an identification or a mismatch report")
async def analyse(body: m.NewAnalysis, service: The) -> m.AnalysisAnswer:
    """It runs at low priority in a process of its own; nothing moves, so the controls are not needed."""

    async def act() -> m.AnalysisAnswer:
        analysis = service.analyse(body)
        return m.AnalysisAnswer(id=analysis.id, state=analysis.state)

    answer: m.AnalysisAnswer = await service.once(body.request_id, f"analyse {body.model_dump_json()}", act)
    return answer


@router.post("/analyses/{analysis_id}/cancel", summary="End an analysis")
async def cancel(analysis_id: AnalysisId, body: m.Cancel, service: The) -> m.Done:
    """What it has written so far stays."""

    async def act() -> m.Done:
        if not service.analyses.cancel(analysis_id, body.name):
            raise Unknown(f'there is no analysis "{analysis_id}" that runs')
        service.book.write("cancel", body.name, f"analysis {analysis_id}")
        return m.Done(done="cancelled")

    answer: m.Done = await service.once(body.request_id, f"cancel {analysis_id} {body.model_dump_json()}", act)
    return answer


@router.get("/analyses/{analysis_id}/since", summary="A mismatch report beside the last one of the same gearbox")
async def since(analysis_id: AnalysisId, service: The) -> list[str]:
    """Lines that say what is found anew and what no more; none without an earlier report."""
    this, others = service.analyses.reports(analysis_id, service.settings.folder.absolute())
    return await service.reading(since_last, this, others)


@router.get("/analyses/{analysis_id}/steps", summary="The steps of an investigation")
async def steps(analysis_id: AnalysisId, service: The) -> Answer:
    """``log``: its experiments, what was expected and what came; ``said``: what it said, line by line."""
    return await service.reading(investigation_of, service.analyses.investigated(analysis_id))


@router.get(
    "/analyses/{analysis_id}/report",
    summary="The report of an analysis",
    response_class=FileResponse,
    responses={200: {"content": {"text/html": {}}, "description": "a page of its own"}},
)
async def report(analysis_id: AnalysisId, service: The) -> FileResponse:
    """One self-contained page; it may show, and run nothing."""
    path = service.analyses.folder(analysis_id) / "report.html"
    if service.analyses.get(analysis_id) is None or not path.exists():
        raise Unknown(f'there is no analysis "{analysis_id}" with a report')
    return FileResponse(path, media_type="text/html", headers=REPORT_HEADERS)


@router.post("/model", summary="Choose the model drawn over the spectrum")
async def choose_model(body: m.ChooseModel, service: The) -> m.Done:
    """The model of an analysis, or none."""

    async def act() -> m.Done:
        path = None if body.analysis is None else service.model_path(body.analysis)
        await asyncio.to_thread(service.overlay.choose, path)
        service.publish_state()
        return m.Done(done="no model is drawn" if path is None else f"the model of {body.analysis} is drawn")

    answer: m.Done = await service.once(body.request_id, f"model {body.model_dump_json()}", act)
    return answer


@router.get("/storage", summary="Where recordings lie, and the room left")
async def storage(service: The) -> Answer:
    """With the command that copies them elsewhere."""
    return await asyncio.to_thread(service.storage)


@router.get("/book", summary="Entries of the record book")
async def book(
    service: The,
    words: Annotated[str, InQuery(max_length=200)] = "",
    act: Annotated[str, InQuery(max_length=40)] = "",
    limit: Annotated[int, InQuery(ge=1, le=100_000)] = 200,
) -> list[Answer]:
    """Who did what, and alarms; newest first, in local time with its offset to UTC. Without anything asked, the last.

    Every word has to stand somewhere in an entry: a name, a date, a run, a part of a sentence.
    """
    if not words and not act and limit <= 200:
        return service.book.last()[:limit]
    found: list[Answer] = await service.reading(service.book.find, words, act, limit)
    return found


@router.post("/book", summary="Write a remark into the record book")
async def remark(body: m.BookRemark, service: The) -> m.Done:
    """Of anybody, with or without a run; what is written is never changed."""

    async def do() -> m.Done:
        text = clean_remark(body.text)
        service.book.write("remark", body.name, text)
        return m.Done(done=f"written down: {text}")

    answer: m.Done = await service.once(body.request_id, f"book {body.model_dump_json()}", do)
    return answer


@router.get("/health", summary="Whether the service and its run live")
async def health(service: The) -> Answer:
    """``alive`` is false when a run has not been heard of for long.

    ``heard_s`` is for how long the run has said nothing, s; null where nothing runs.
    """
    return {"alive": service.keeper.is_alive(), "heard_s": service.keeper.heard_s}
