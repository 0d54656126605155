"""The next experiment: a campaign whose points tell the remaining explanations of a finding apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.mismatch.discovery import AMBIGUOUS
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.report.candidates import Candidate, Range
from bench.mismatch.report.finding import Finding, NextExperiment
from bench.mismatch.report.rules import Proposal, by_rule
from bench.mismatch.report.separating import separating
from bench.whole import write_whole


def proposed(findings: Sequence[Finding], data: Dataset, out: Path) -> tuple[Finding, ...]:
    """The findings, those that are ambiguous or unknown with an experiment each; writes ``next-1.toml`` and so on."""
    covered = Range.of(data)
    complete: list[Finding] = []
    number = 0
    for finding in findings:
        experiment = _proposal(finding, data, covered) if finding.open else None
        if experiment is None:
            complete.append(finding)
            continue
        number += 1
        name = f"next-{number}.toml"
        out.mkdir(parents=True, exist_ok=True)
        write_whole(out / name, campaign(finding.name, number, experiment.points))
        points = tuple(p.to_json() for p in experiment.points)
        complete.append(replace(finding, next_experiment=NextExperiment(experiment.why, name, points)))
    return tuple(complete)


def _proposal(finding: Finding, data: Dataset, covered: Range) -> Proposal | None:
    """Points to run; None where the recordings tell no range to run in; no campaign has linear axes."""
    if data.linear or covered.fastest <= 0.0:
        return None
    found = separating(finding, covered, data.ratio) if finding.status == AMBIGUOUS else None
    return found or by_rule(finding, covered)


def campaign(title: str, number: int, points: Sequence[Candidate]) -> str:
    """The points as a campaign file, a stage each so that they are run in this order."""
    lines = [
        f"# Tells apart what the recordings could not: {title}.",
        'format = "bench-campaign"',
        'format_version = "1.0"',
        f'name = "next-{number}"',
        f'title = "Next experiment {number}"',
    ]
    for k, point in enumerate(points):
        lines += ["", "[[stages]]", f'name = "step {k + 1}"', 'order = "listed"', "", "[[stages.points]]"]
        lines.append(f'sequence = "{point.sequence}"')
        if point.velocity:
            lines.append(f'velocities = ["{np.degrees(point.velocity):.4g} deg/s"]')
        if point.torque:
            lines.append(f'load_torques = ["{point.torque:g} N*m"]')
        if point.temperature is not None:
            lines.append(f'temperatures = ["{point.temperature:g} degC"]')
        if point.options:
            lines.append("options = { " + ", ".join(f"{key} = {value}" for key, value in point.options) + " }")
    return "\n".join(lines) + "\n"
