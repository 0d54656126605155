"""Campaigns over HTTP: what is offered, their plans; a draft planned while it is written, saved for the laboratory."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Depends
from fastapi import Path as InPath

from bench.service import models as m
from bench.service.campaigns.schema import campaign_schema
from bench.service.service import Service
from bench.service.web.wiring import PROBLEMS, service_of

router = APIRouter(prefix="/api", responses=PROBLEMS)
The = Annotated[Service, Depends(service_of)]
Place = Annotated[str, InPath(pattern=r"^[\w][\w .+\-]{0,99}$")]
Answer = dict[str, Any]


@router.get("/campaigns", summary="Campaigns that may be started")
async def campaigns(service: The) -> list[Answer]:
    """Shipped ones and those of the laboratory; ``problem`` says why one cannot be."""
    return await service.plans(service.catalog.list)


@router.post("/campaigns", summary="Save a campaign of the laboratory")
async def save(body: m.SaveCampaign, service: The) -> m.SavedCampaign:
    """Nothing moves, so the controls are not needed; a version that is replaced is kept."""

    async def act() -> m.SavedCampaign:
        text = service.catalog.written(body.text, body.table)
        path = await service.plans(service.catalog.save, body.campaign, text, body.replaces)
        service.book.write("campaign", body.name, f"saved the campaign {path.name}")
        return m.SavedCampaign(done=f"saved as {path.name}", campaign=path.name)

    answer: m.SavedCampaign = await service.once(body.request_id, f"save {body.model_dump_json()}", act)
    return answer


@router.get("/campaigns/{name}/plan", summary="The plan of a campaign")
async def plan(name: Place, service: The) -> Answer:
    """Every point with time, temperature and energy, from room temperature."""
    return await service.plans(service.catalog.plan, name)


@router.get("/campaigns/{name}/definition", summary="A campaign as text and table")
async def definition(name: Place, service: The) -> Answer:
    """What a form begins with, to change it or to make another of it."""
    return await service.plans(service.catalog.definition, name)


@router.get("/campaign-schema", summary="The JSON schema of a campaign")
async def schema(service: The) -> Answer:
    """Made of the definitions that read campaign files, with the options of every sequence that is installed."""
    return await service.plans(campaign_schema)


@router.post("/plan", summary="Plan a draft")
async def plan_draft(body: m.Draft, service: The) -> Answer:
    """The plan, and the draft as TOML text; nothing is kept. One sentence if it is wrong or would break a limit."""
    return await service.plans(service.catalog.draft, body.text, body.table)
