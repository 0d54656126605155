"""``bench mismatch`` from end to end: recordings in; report.json, report.html and model.json out."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from bench.mismatch.assess import FEWEST, Progress, assess, channels_of
from bench.mismatch.channels import Analysis
from bench.mismatch.dataset import Dataset, load
from bench.mismatch.evaluate import FLOOR_METHOD, Scores
from bench.mismatch.experiment import propose
from bench.mismatch.findings import Finding
from bench.mismatch.given import Given
from bench.mismatch.improved import improved
from bench.mismatch.leave_one_out import LeftOut, Map, leave_one_out
from bench.mismatch.unexplained import undetermined
from bench.simulation.model import Simulation
from bench.simulation.terms import CHANNEL_UNITS


@dataclass(slots=True)
class Report:
    """Everything the report says, and what it was made from."""

    verdict: str
    why: str
    data: Dataset
    scores: dict[str, Scores] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    analysis: Analysis | None = None
    skipped: list[str] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)

    def to_json(self) -> dict[str, Any]:
        """The mismatch report 1.0."""
        members = self.data.members
        out: dict[str, Any] = {
            "format": "bench-mismatch-report",
            "format_version": "1.0",
            "verdict": self.verdict,
            "recordings": {
                "train": [m.name for m in members if not m.held_out],
                "held_out": [m.name for m in members if m.held_out],
                "rejected": [{"file": file, "why": why} for file, why in self.data.rejected],
            },
            "channels": [
                {
                    "channel": channel,
                    "unit": CHANNEL_UNITS[channel],
                    "noise_floor": score.floor,
                    "noise_floor_method": FLOOR_METHOD,
                    "held_out_rmse_before": score.before,
                    "held_out_rmse_after": score.after,
                }
                for channel, score in self.scores.items()
            ],
            "findings": [finding.to_json() for finding in self.findings],
            "notes": [*self.data.notes, *self.skipped],
        }
        if self.why:
            out["why"] = self.why
        if self.left_out:
            out["leave_one_out"] = [asdict(row) for row in self.left_out]
        return out


def run(
    recordings: Path,
    out: Path,
    simulation: Path | None = None,
    progress: Progress | None = None,
    leaving_out: bool = False,
    elsewhere: Map | None = None,
    jobs: int = 1,
) -> Report:
    """Compare the simulation with recordings and write the report into ``out``; a large folder is read on ``jobs``
    processes.

    With ``leaving_out`` every nominal term is switched off in turn as well (``elsewhere`` maps them over other
    processes). Raises RecordingError where nothing can be read, ConfigurationError where the simulation file is wrong.
    """
    tell = progress or (lambda _what, _share: None)
    model = Simulation.load(simulation) if simulation is not None else Simulation.nominal()
    given = Given.of(model)
    data = load(Path(recordings), lambda what, share: tell(what, 0.3 * share), jobs)
    report = Report("undetermined", "", data)
    channels, report.skipped = channels_of(data)
    train = sum(not m.held_out for m in data.members)
    if train < FEWEST:
        report.why = f"{train} recordings can be fitted, at least {FEWEST} are needed to tell noise from structure"
    elif not channels:
        report.why = "no channel is there to compare: " + "; ".join(report.skipped)
    else:
        found = assess(data, given, channels, lambda what, share: tell(what, 0.35 + 0.55 * share))
        report.analysis, report.scores, report.findings = found.analysis, found.scores, found.findings
        report.why = "" if report.findings else undetermined(found.analysis, found.scores)
        if not report.why:
            report.verdict = "mismatch" if report.findings else "match"
        for number, finding in enumerate(f for f in report.findings if f.status != "named"):
            propose(finding, found.analysis, out, number + 1, data)
        if leaving_out:
            better = improved(report.findings, report.analysis, model)
            report.left_out = leave_one_out(
                data, better, channels, found, Path(recordings), lambda what, _: tell(f"without {what}", 0.9), elsewhere
            )
    tell("writing the report", 0.92)
    write(report, model, out)
    tell("done", 1.0)
    return report


def write(report: Report, model: Simulation, out: Path) -> None:
    """Write report.json, model.json and report.html."""
    from bench.mismatch.page import page

    out.mkdir(parents=True, exist_ok=True)
    improved(report.findings, report.analysis, model).save(out / "model.json")
    (out / "report.json").write_text(json.dumps(report.to_json(), indent=1, allow_nan=False) + "\n", encoding="utf-8")
    (out / "report.html").write_text(page(report), encoding="utf-8")
