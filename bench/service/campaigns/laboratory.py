"""Campaigns of the laboratory: saved from the page, each a TOML file; an earlier version is kept beside it."""

from __future__ import annotations

import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bench.campaigns import parse_campaign
from bench.names import require_name
from bench.service.refusals import NotNow, Unknown
from bench.service.settings import Settings

EARLIER = "earlier"
"""Folder below that of the campaigns for versions that were replaced."""


def laboratory_folder(settings: Settings) -> Path:
    """Where campaigns are saved: the folder given with --campaigns, or one of the service's own."""
    return settings.campaigns or settings.state.absolute() / "campaigns"


def save(folder: Path, name: str, text: str, replaces: bool) -> Path:
    """Write a campaign into the laboratory's folder and return its file, ``name`` with the ending .toml.

    With ``replaces`` an earlier version goes into the folder ``earlier`` beside it, with the time as ending.

    Raises
    ------
    NotNow
        If there is one of this name and ``replaces`` is not set.
    ConfigurationError
        If the name cannot be one of a file, or the text is no campaign.
    """
    stem = require_name(name.removesuffix(".toml"), "the campaign name")
    parse_campaign(text, f"{stem}.toml")
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{stem}.toml"
    if path.exists():
        if not replaces:
            raise NotNow(f'there is a campaign "{path.name}" already; save it under another name, or replace it')
        if path.read_text("utf-8") == text:
            return path
        earlier = folder / EARLIER
        earlier.mkdir(exist_ok=True)
        os.link(path, earlier / f"{stem}-{datetime.now(UTC):%Y%m%dT%H%M%S.%fZ}.toml")
    part = folder / f".{stem}.toml.part"
    part.write_text(text, encoding="utf-8")
    os.replace(part, path)
    return path


def definition(source: str, name: str) -> dict[str, Any]:
    """Return a campaign as text and as the table it holds, for a form to begin with.

    Raises
    ------
    Unknown
        If it is a program: what that makes of itself no form can show.
    ConfigurationError
        If it cannot be read.
    """
    import tomllib

    from bench.campaigns import load_campaign

    campaign = load_campaign(source) if not source.endswith(".py") else None
    if campaign is None:
        raise Unknown(f'"{name}" is a Python program; look at its file, a form cannot show it')
    return {"name": name, "text": campaign.text, "table": tomllib.loads(campaign.text)}
