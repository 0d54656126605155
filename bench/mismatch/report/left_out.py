"""What became of a nominal term that was switched off: a row of the report's ``leave_one_out``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

NAMED, AMBIGUOUS, OTHERWISE, NOT_FOUND, NOT_ASKED = (
    "named",
    "ambiguous",
    "found under another name",
    "not found",
    "not asked",
)


@dataclass(slots=True)
class LeftOut:
    """What became of one nominal term switched off. RMSE per sample on held-out recordings, in the channel's unit."""

    effect: str
    name: str
    channel: str
    outcome: str
    said: list[str] = field(default_factory=list)
    """what the report called, strongest first"""
    confidence: float | None = None
    rmse_without: float | None = None
    rmse_found: float | None = None
    noise_floor: float | None = None
    parameters: str = ""
    why: str = ""


def table(rows: Sequence[LeftOut]) -> str:
    """The rows as a Markdown table, for the terminal and for documents."""
    lines = [
        "| term left out | channel | would it have been found? | RMSE without → with it | noise | said |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        sure = "" if row.confidence is None else f" ({row.confidence:.2f})"
        pair = "–" if row.rmse_without is None else f"{_number(row.rmse_without)} → {_number(row.rmse_found)}"
        line = f"| `{row.effect}` | {row.channel} | {row.outcome}{sure} | {pair} | {_number(row.noise_floor)} |"
        lines.append(f"{line} {said(row)} |")
    return "\n".join(lines)


def said(row: LeftOut) -> str:
    """What was said of a term: its values, or why not, or what else was reported."""
    return row.parameters or row.why or ", ".join(row.said) or "–"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"
