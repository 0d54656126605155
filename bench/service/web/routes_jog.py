"""By hand over HTTP: a motion that goes on only while the page says so, and the torque sensor's zero."""

from __future__ import annotations

import time
from typing import Annotated

from fastapi import APIRouter, Depends

from bench.service import models as m
from bench.service.runs.runs import Run
from bench.service.service import Service
from bench.service.web.wiring import PROBLEMS, service_of

router = APIRouter(prefix="/api", responses=PROBLEMS)
The = Annotated[Service, Depends(service_of)]


@router.post("/jog", summary="Turn the bench by hand")
async def jog(body: m.Jog, service: The) -> m.RunAnswer:
    """Slow, without load, at low torque. Say ``/jog/hold`` every 0.15 s: half a second of silence ends it."""

    async def do(name: str) -> m.RunAnswer:
        return _answer(service.by_hand.begin(body.velocity, name))

    async def act() -> m.RunAnswer:
        answer: m.RunAnswer = await service.act(body.secret, "jog", do)
        return answer

    answer: m.RunAnswer = await service.once(body.request_id, f"jog {body.model_dump_json()}", act)
    return answer


@router.post("/tare", summary="Take the torque sensor's zero")
async def tare(body: m.Tare, service: The) -> m.RunAnswer:
    """At rest, without load and without torque; the run's end says what the sensor reads."""

    async def do(name: str) -> m.RunAnswer:
        return _answer(service.by_hand.tare(name))

    async def act() -> m.RunAnswer:
        answer: m.RunAnswer = await service.act(body.secret, "tare", do)
        return answer

    answer: m.RunAnswer = await service.once(body.request_id, f"tare {body.model_dump_json()}", act)
    return answer


def _answer(run: Run) -> m.RunAnswer:
    return m.RunAnswer(id=run.id, state=run.state, folder=run.folder)


@router.post("/jog/hold", summary="The button is still held, or no longer")
async def hold(body: m.Hold, service: The) -> m.Done:
    """Of the motion that was begun last; whoever lost the controls holds nothing."""
    service.lease.check(body.secret, time.monotonic())
    return m.Done(done=service.by_hand.hold(body.run, body.held))
