"""``bench mismatch`` from end to end: recordings in; report.json, report.html and model.json out."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import evaluate
from bench.mismatch.channels import Analysis, analyse_channels
from bench.mismatch.conclude import conclude
from bench.mismatch.dataset import Dataset, load
from bench.mismatch.evaluate import FLOOR_METHOD, Scores
from bench.mismatch.experiment import propose
from bench.mismatch.findings import Finding
from bench.mismatch.given import Given
from bench.mismatch.improved import improved
from bench.mismatch.linear import ChannelModel
from bench.mismatch.motor_ripple import Ripple
from bench.simulation.model import Simulation
from bench.simulation.terms import CHANNEL_UNITS, MOTOR_TORQUE, TRANSMISSION_ERROR

Progress = Callable[[str, float], None]
FEWEST = 6


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
        return out


def run(
    recordings: Path,
    out: Path,
    simulation: Path | None = None,
    progress: Progress | None = None,
) -> Report:
    """Compare the simulation with recordings and write the report into ``out``.

    Raises RecordingError where nothing can be read, ConfigurationError where the simulation file is wrong.
    """
    tell = progress or (lambda _what, _share: None)
    model = Simulation.load(simulation) if simulation is not None else Simulation.nominal()
    given = Given.of(model)
    data = load(Path(recordings), lambda what, share: tell(what, 0.3 * share))
    report = Report("undetermined", "", data)
    channels = _channels(data, report)
    train = sum(not m.held_out for m in data.members)
    if train < FEWEST or not channels:
        report.why = (
            f"{train} recordings can be fitted, at least {FEWEST} are needed to tell noise from structure"
            if train < FEWEST
            else "no channel is there to compare: " + "; ".join(report.skipped)
        )
    else:
        tell("searching the channels", 0.35)
        report.analysis = analyse_channels(data, given, channels)
        tell("scoring what was held out", 0.85)
        report.scores, report.findings = judged(report.analysis, data, given, channels)
        report.verdict = "mismatch" if report.findings else "match"
        for number, finding in enumerate(f for f in report.findings if f.status != "named"):
            propose(finding, out, number + 1, data)
    tell("writing the report", 0.92)
    write(report, model, out)
    tell("done", 1.0)
    return report


def judged(
    analysis: Analysis, data: Dataset, given: Given, channels: Sequence[str]
) -> tuple[dict[str, Scores], list[Finding]]:
    """Scores of the channels on held-out recordings, and the findings that those do not refute."""
    evidence = _gated(analysis, data)
    scores = _scores(analysis, data, given, channels)
    return scores, conclude(data, analysis, scores, evidence)


def _channels(data: Dataset, report: Report) -> list[str]:
    present = {name for m in data.members for name in m.recording.channels}
    needs = {
        "transmission_error": ("motor_angle", "load_angle"),
        "motor_torque": ("motor_angle", "motor_torque"),
        "temperature": ("temperature", "motor_torque", "motor_angle"),
        "load_torque": ("load_torque", "load_motor_torque"),
    }
    out = []
    for channel, names in needs.items():
        missing = [name for name in names if name not in present]
        if missing:
            report.skipped.append(f"{channel} is not compared: the recordings have no {', '.join(missing)}")
        else:
            out.append(channel)
    return out


def _usable(model: ChannelModel, analysis: Analysis) -> NDArray[np.bool_]:
    if model.channel == TRANSMISSION_ERROR and analysis.transmission is not None:
        return analysis.transmission.slow_inside
    return model.rows.frame.direction != 0 if model.channel != "temperature" else model.rows.number > 0


def _gated(analysis: Analysis, data: Dataset) -> dict[tuple[str, str], tuple[float, float]]:
    """Take back what held-out recordings refute; their root mean squares without and with each finding that stays."""
    held = data.held_out()
    out: dict[tuple[str, str], tuple[float, float]] = {}
    if analysis.transmission is not None:
        evaluate.gate_harmonics(analysis.transmission, held)
    for channel, model in analysis.models.items():
        for effect, pair in evaluate.gate(model, _usable(model, analysis), held).items():
            out[channel, effect] = pair
    return out


def _scores(analysis: Analysis, data: Dataset, given: Given, channels: Sequence[str]) -> dict[str, Scores]:
    held = data.held_out()
    out: dict[str, Scores] = {}
    for channel in channels:
        if channel == TRANSMISSION_ERROR:
            if analysis.transmission is not None:
                out[channel] = evaluate.transmission(analysis.transmission, held)
        elif channel in analysis.models:
            model = analysis.models[channel]
            known = _variance(given.ripples) if channel == MOTOR_TORQUE else 0.0
            found = _variance(analysis.ripples) if channel == MOTOR_TORQUE else 0.0
            out[channel] = evaluate.linear(model, _usable(model, analysis), held, found, known)
    return out


def _variance(ripples: Sequence[Ripple]) -> float:
    """Variance of a sum of sines, in the unit of the channel squared."""
    return float(sum(0.5 * abs(r.amplitude) ** 2 for r in ripples))


def write(report: Report, model: Simulation, out: Path) -> None:
    """Write report.json, model.json and report.html."""
    from bench.mismatch.page import page

    out.mkdir(parents=True, exist_ok=True)
    improved(report.findings, report.analysis, model).save(out / "model.json")
    (out / "report.json").write_text(json.dumps(report.to_json(), indent=1, allow_nan=False) + "\n", encoding="utf-8")
    (out / "report.html").write_text(page(report), encoding="utf-8")
