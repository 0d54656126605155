"""Everything a comparison says: the verdict, the channels, the findings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bench.mismatch.report.content import Content
from bench.mismatch.report.to_json import to_json
from bench.mismatch.report.verdict import sentence
from bench.simulation.linear import in_metres


@dataclass(slots=True)
class Report(Content):
    """Everything the report says, in one sentence and as a file."""

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        text = sentence(self)
        return in_metres(text) if self.data.linear else text

    def to_json(self) -> dict[str, Any]:
        """The mismatch report 1.1."""
        return to_json(self)
