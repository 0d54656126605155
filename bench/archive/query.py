"""A search in the archive; each part that is given narrows the result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

MOST = 500
"""Recordings of one answer."""


@dataclass(frozen=True, slots=True)
class Query:
    """A search.

    Attributes
    ----------
    words : each must stand somewhere: folder, recording, campaign, point, events, remarks, comments, tags; any case.
    since, until : of the begin, Unix time in s; ``until`` is excluded.
    person, gearbox, bench : parts of a name or serial number, any case.
    kind, result, tag : exactly, of :data:`bench.recording.header.KINDS` and :data:`bench.archive.RESULTS`.
    load_torque, velocity, temperature : the set point, N·m, rad/s, °C, within a thousandth or the last digit shown.
    archived : whether what was archived is found as well.
    limit, offset : which part of what is found is returned, newest first.
    """

    words: str = ""
    since: float | None = None
    until: float | None = None
    person: str = ""
    gearbox: str = ""
    bench: str = ""
    kind: str = ""
    result: str = ""
    tag: str = ""
    load_torque: float | None = None
    velocity: float | None = None
    temperature: float | None = None
    archived: bool = False
    limit: int = 100
    offset: int = 0

    def conditions(self) -> tuple[str, list[Any]]:
        """Return the SQL condition over the table ``recordings`` and its values."""
        parts: list[tuple[str, list[Any]]] = []
        if not self.archived:
            parts.append(("archived = 0", []))
        parts += [("text LIKE ? ESCAPE '\\'", [_like_pattern(word)]) for word in self.words.lower().split()]
        parts += [
            (f"{column} {sign} ?", [value])
            for column, sign, value in (("started_s", ">=", self.since), ("started_s", "<", self.until))
            if value is not None
        ]
        parts += [
            (f"{column} LIKE ? ESCAPE '\\'", [_like_pattern(value)])
            for column, value in (("person", self.person), ("gearbox", self.gearbox), ("bench", self.bench))
            if value
        ]
        parts += [
            (f"{column} = ?", [value]) for column, value in (("kind", self.kind), ("result", self.result)) if value
        ]
        if self.tag:
            parts.append(("instr(tags, ?) > 0", [f"\n{self.tag}\n"]))
        for column, value, least in (
            ("load_torque", self.load_torque, 0.5),
            ("velocity", self.velocity, 1e-3),
            ("temperature", self.temperature, 0.05),
        ):
            if value is not None:
                parts.append((f"abs({column} - ?) <= ?", [value, max(least, 1e-3 * abs(value))]))
        return " AND ".join(part for part, _ in parts) or "1", [value for _, values in parts for value in values]


def _like_pattern(word: str) -> str:
    safe = word.replace("\\", "\\\\").replace("%", "\\%").replace("_", "\\_")
    return f"%{safe}%"
