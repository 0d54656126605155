"""Campaigns that may be started: shipped ones, those of the campaigns folder, and the text of a TOML file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from bench.campaigns import load_campaign, parse_campaign, shipped_campaigns
from bench.configuration import BenchFile
from bench.errors import BenchError
from bench.service.campaigns import planning
from bench.service.campaigns.laboratory import definition, laboratory_folder, save
from bench.service.campaigns.toml import toml
from bench.service.refusals import NotNow, Unknown
from bench.service.settings import Settings

_ASKED = 6
"""So many next experiments are offered."""


class Catalog:
    """The campaigns of one service. A Python file is a program: it is taken from the campaigns folder only."""

    def __init__(self, settings: Settings, bench: BenchFile) -> None:
        self._settings, self._bench = settings, bench
        self._analyses = settings.state.absolute() / "analyses"

    def list(self) -> list[dict[str, Any]]:
        """Return name and title of each, or what is wrong with it."""
        out = []
        for name, source in self._offered_campaigns().items():
            try:
                title = load_campaign(source).title + self._asked_by(source)
                out.append({"name": name, "title": title, "problem": None, "laboratory": self._is_own(source)})
            except BenchError as error:
                out.append({"name": name, "title": name, "problem": str(error), "laboratory": self._is_own(source)})
        return out

    def plan(self, name: str) -> dict[str, Any]:
        """Return the plan of a campaign from room temperature.

        Raises
        ------
        Unknown
            If there is none of this name.
        BenchError
            If it is wrong or would break a limit.
        """
        return planning.plan(self.source(name, None, ""), self._bench)

    def draft(self, text: str | None, table: dict[str, Any] | None) -> dict[str, Any]:
        """Return the plan of a campaign that is being written, and its text; as :meth:`plan` it refuses what is wrong.

        Raises
        ------
        NotNow
            If neither or both of text and table are given.
        """
        written = self.written(text, table)
        return {"text": written, **planning.plan_text(written, self._bench)}

    def written(self, text: str | None, table: dict[str, Any] | None) -> str:
        """Return the TOML text of a draft.

        Raises
        ------
        NotNow
            If neither or both of text and table are given.
        """
        if (text is None) == (table is None):
            raise NotNow("give either text, the content of a TOML file, or table, what it holds")
        return toml(table or {}) if text is None else text

    def save(self, name: str, text: str, replaces: bool) -> Path:
        """Save a campaign of the laboratory; one that breaks a limit of this bench may be saved, not run."""
        return save(laboratory_folder(self._settings), name, text, replaces)

    def definition(self, name: str) -> dict[str, Any]:
        """Return a campaign that is offered as text and table.

        Raises
        ------
        Unknown
            If there is none of this name, or it is a program.
        """
        offered = self._offered_campaigns()
        if name not in offered:
            raise Unknown(f'there is no campaign "{name}"; there are {", ".join(offered)}')
        return definition(offered[name], name)

    def _is_own(self, source: str) -> bool:
        return Path(source).parent == laboratory_folder(self._settings).absolute()

    def source(self, name: str | None, text: str | None, run_id: str) -> str:
        """Return what a run process loads: a shipped name or a path; the text sent is kept beside the run.

        Raises
        ------
        Unknown
            If there is no campaign of this name.
        NotNow
            If neither or both of name and text are given.
        ConfigurationError
            If the text is no campaign.
        """
        if (name is None) == (text is None):
            raise NotNow("give either campaign, a name the service offers, or text, the content of a TOML file")
        if text is None:
            offered = self._offered_campaigns()
            if name not in offered:
                raise Unknown(f'there is no campaign "{name}"; there are {", ".join(offered)}')
            return offered[str(name)]
        parse_campaign(text, "the campaign sent")
        path = self._settings.state.absolute() / "runs" / run_id / "campaign.toml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return str(path)

    def _offered_campaigns(self) -> dict[str, str]:
        # the short one first: what a newcomer wants to try
        offered = {name: name for name in sorted(shipped_campaigns(), key=lambda name: (name != "quick", name))}
        folder = laboratory_folder(self._settings)
        if folder.is_dir():
            files = (
                path for path in sorted(folder.iterdir()) if path.suffix in (".toml", ".py") and path.name[0] != "."
            )
            offered |= {path.name: str(path.absolute()) for path in files}
        # what a mismatch report asks for next, the newest report first
        asked = sorted(self._analyses.glob("*/next-*.toml"), reverse=True)
        return offered | {next_name(path): str(path) for path in asked[:_ASKED]}

    def _asked_by(self, source: str) -> str:
        path = Path(source)
        if path.parent.parent != self._analyses:
            return ""
        try:
            folder = json.loads(path.with_name("analysis.json").read_text("utf-8"))["folder"]
        except (OSError, ValueError, KeyError, TypeError):
            return ", asked for by a report"
        return f", asked for by the report on {folder}"


def next_name(path: Path) -> str:
    """Name under which the next experiment of an analysis is offered; ``path`` is its campaign file."""
    return f"{path.stem} of {path.parent.name}"
