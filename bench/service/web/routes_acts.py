"""Acts over HTTP: STOP, the controls, runs and what is asked of them. POST only; each act once per request id."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends
from fastapi import Path as InPath

from bench.campaigns.operator.remark import clean_remark
from bench.service import models as m
from bench.service.refusals import NotNow, Unknown
from bench.service.service import Service
from bench.service.web.wiring import PROBLEMS, service_of

router = APIRouter(prefix="/api", responses=PROBLEMS)
_SKIPPABLE = frozenset({"waiting", "running", "heating"})
_REPEATABLE = frozenset({"done", "failed", "skipped", "running", "saving"})
The = Annotated[Service, Depends(service_of)]
RunId = Annotated[str, InPath(pattern=r"^[0-9A-Za-z\-]{1,40}$")]
AlarmNumber = Annotated[int, InPath(ge=1, le=10**9)]


async def _once(service: Service, path: str, body: Any, act: Callable[[], Awaitable[Any]]) -> Any:
    return await service.once(body.request_id, f"{path} {body.model_dump_json()}", act)


async def _act_once(service: Service, what: str, body: m.Act, do: Callable[[str], Any], path: str = "") -> Any:
    """Do ``do(name)`` once, in the name of whoever holds the controls."""

    async def call(name: str) -> Any:
        result = do(name)
        return await result if asyncio.iscoroutine(result) else result

    return await _once(service, f"{what} {path}", body, lambda: service.act(body.secret, what, call))


@router.post("/stop", summary="STOP: bring the bench to rest")
async def stop(body: m.Stop, service: The) -> m.Stopped:
    """Whoever asks, whatever is going on, without the controls. Nothing begins by itself afterwards."""
    press = service.stop(body.by, body.pressed_at_ns)
    done = "nothing runs; the queue is held" if press.run is None else "the bench is being brought to rest"
    return m.Stopped(done=done, run=press.run, by=press.by, pressed_at_ns=press.pressed_at_ns)


@router.post("/controls/take", summary="Take the controls")
async def take(body: m.Take, service: The) -> m.Taken:
    """Take the controls, where they are free, offered, or from somebody who is named."""

    async def act() -> m.Taken:
        holder = service.lease.take(body.name, body.taken_from, time.monotonic())
        service.publish_state()
        return m.Taken(secret=holder.secret, id=holder.id)

    answer: m.Taken = await _once(service, "take", body, act)
    return answer


@router.post("/controls/keep", summary="Say that you are still there")
async def keep(body: m.Keep, service: The) -> m.Done:
    """A page says this every now and then; without it the controls become free after five minutes."""
    holder = service.lease.check(body.secret, time.monotonic())
    return m.Done(done=f"{holder.name} holds the controls")


@router.post("/controls/offer", summary="Hand the controls over")
async def offer(body: m.Offer, service: The) -> m.Done:
    """Offer the controls to someone by name, who then takes them."""

    async def act() -> m.Done:
        service.lease.offer(body.secret, body.to, time.monotonic())
        service.publish_state()
        return m.Done(done=f"offered to {body.to}")

    answer: m.Done = await _once(service, "offer", body, act)
    return answer


@router.post("/controls/release", summary="Let go of the controls")
async def release(body: m.Act, service: The) -> m.Done:
    """Nobody holds them afterwards; what runs goes on."""

    async def act() -> m.Done:
        service.lease.release(body.secret, time.monotonic())
        service.publish_state()
        return m.Done(done="nobody holds the controls")

    answer: m.Done = await _once(service, "release", body, act)
    return answer


@router.post("/runs", summary="Ask for a campaign")
async def new_run(body: m.NewRun, service: The) -> m.RunAnswer:
    """With the controls it joins the queue and begins when the bench is free; without, it waits for the operator.

    While the queue is held after a stop it begins alone, and the runs that waited stay held. Asked for while a run is
    still being stopped it waits with them.
    """

    async def act() -> m.RunAnswer:
        return _answer(await service.requests.new(body))

    answer: m.RunAnswer = await _once(service, "run", body, act)
    service.publish_state()
    return answer


@router.post("/runs/{run_id}/approve", summary="Put a proposed run into the queue")
async def approve(run_id: RunId, body: m.Act, service: The) -> m.RunAnswer:
    """The operator's word for what somebody else proposed."""

    answer: m.RunAnswer = await _act_once(
        service, "approve", body, lambda name: _answer(service.requests.approve(run_id, name)), run_id
    )
    return answer


@router.post("/runs/{run_id}/withdraw", summary="Take a run out of the queue")
async def withdraw(run_id: RunId, body: m.Act, service: The) -> m.RunAnswer:
    """It is not run; nothing of it was."""

    def do(name: str) -> m.RunAnswer:
        waiting = service.keeper.runs.get(run_id)
        if waiting is None or waiting.state not in ("queued", "proposed"):
            raise Unknown(f'there is no waiting run "{run_id}"')
        service.book.write("withdraw", name, waiting.title, run=run_id)
        end = {"kind": "withdrawn", "text": f"taken out of the queue by {name}"}
        return _answer(service.requests.change(waiting, state="ended", end=end))

    answer: m.RunAnswer = await _act_once(service, "withdraw", body, do, run_id)
    return answer


@router.post("/runs/{run_id}/again", summary="Go on where a run stopped")
async def again(run_id: RunId, body: m.Act, service: The) -> m.RunAnswer:
    """The same campaign in the same folder: what is done is not repeated. After a stop this is the act "resume"."""
    answer: m.RunAnswer = await _act_once(
        service, "again", body, lambda name: _answer(service.requests.again(run_id, name)), run_id
    )
    return answer


@router.post("/reset", summary="Reset the bench after a stop")
async def reset(body: m.ResetAct, service: The) -> m.RunAnswer:
    """The drives lose their faults, and it is looked whether the cause is gone; no torque is given."""

    def do(name: str) -> m.RunAnswer:
        return _answer(service.after_stop.reset(name, body.run))

    answer: m.RunAnswer = await _act_once(service, "reset", body, do)
    return answer


@router.post("/queue/go-on", summary="Let the queue go on after a stop")
async def queue(body: m.Act, service: The) -> m.Done:
    """After STOP or an alarm no run that waits begins until this is said."""

    def do(name: str) -> m.Done:
        service.book.write("queue", name, "the queue goes on")
        service.keeper.go_on_with_queue()
        return m.Done(done="the queue goes on")

    answer: m.Done = await _act_once(service, "queue", body, do)
    return answer


async def _wish(service: Service, wish: str, body: m.RunAct, **more: str) -> m.Done:
    def do(name: str) -> m.Done:
        return m.Done(done=service.requests.wish(name, wish, body.run, **more))

    answer: m.Done = await _act_once(service, wish, body, do)
    return answer


@router.post("/run/pause", summary="Pause after the point that runs")
async def pause(body: m.RunAct, service: The) -> m.Done:
    """The point that runs is finished; the next waits."""
    return await _wish(service, "pause", body)


@router.post("/run/go-on", summary="End a pause")
async def go_on(body: m.RunAct, service: The) -> m.Done:
    """Go on with the next point."""
    return await _wish(service, "go_on", body)


@router.post("/run/skip", summary="Skip a point")
async def skip(body: m.PointAct, service: The) -> m.Done:
    """A point that runs is brought to rest and cut short; one still to come is left out of this run."""
    return await _on_point(service, "skip", body, _SKIPPABLE)


@router.post("/run/repeat", summary="Repeat a point")
async def repeat(body: m.PointAct, service: The) -> m.Done:
    """The point is measured once more, after the one that runs; every take is kept."""
    return await _on_point(service, "repeat", body, _REPEATABLE)


@router.post("/run/note", summary="Write a remark into the recording")
async def note(body: m.NoteAct, service: The) -> m.Done:
    """It stands in the events of the recording that runs, or of the next."""
    return await _wish(service, "note", body, text=clean_remark(body.text))


@router.post("/run/abort", summary="End the run in order")
async def abort(body: m.RunAct, service: The) -> m.Done:
    """The bench is brought to rest, the recording finished; what is missing can be measured later."""

    def do(name: str) -> m.Done:
        title = service.requests.require_running(body.run).title
        service.keeper.stop(name)
        service.book.write("abort", name, f"{title} aborted", run=body.run)
        return m.Done(done="the bench is being brought to rest")

    answer: m.Done = await _act_once(service, "abort", body, do)
    return answer


@router.post("/alarms/{number}/acknowledge", summary="Acknowledge an alarm")
async def acknowledge(number: AlarmNumber, body: m.Act, service: The) -> m.Done:
    """It has been read and something was done about it."""

    def do(name: str) -> m.Done:
        if service.alarms.acknowledge(number, name) is None:
            raise Unknown(f"there is no alarm {number} to be acknowledged")
        service.after_stop.acknowledge(name)
        service.keeper.changed()
        return m.Done(done=f"acknowledged by {name}")

    answer: m.Done = await _act_once(service, "acknowledge", body, do, str(number))
    return answer


async def _on_point(service: Service, wish: str, body: m.PointAct, states: frozenset[str]) -> m.Done:
    def do(name: str) -> m.Done:
        service.requests.require_running(body.run)
        _require_point(service, body.point, states)
        return m.Done(done=service.requests.wish(name, wish, body.run, identity=body.point))

    answer: m.Done = await _act_once(service, wish, body, do)
    return answer


def _require_point(service: Service, identity: str, states: frozenset[str]) -> None:
    point = service.keeper.shown.points.get(identity)
    if point is None:
        raise NotNow(f"the run has no point {identity}")
    if point["state"] not in states:
        raise NotNow(f"point {point['number']} is {point['state']} already")


def _answer(run: Any) -> m.RunAnswer:
    return m.RunAnswer(id=run.id, state=run.state, folder=run.folder)
