"""The report as ``report.json`` 1.1. What is no finite number is null; nothing is rounded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.report import location
from bench.mismatch.report.content import Content
from bench.mismatch.report.finding import Finding
from bench.simulation.linear import all_in_metres
from bench.simulation.terms import CHANNEL_UNITS

FORMAT, FORMAT_VERSION = "bench-mismatch-report", "1.1"
SCORES = ("as_given", "before", "after")


def to_json(report: Content) -> dict[str, Any]:
    """The whole report."""
    members = report.data.members
    out: dict[str, Any] = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "verdict": report.verdict,
        "simulation": asdict(report.simulation),
        "recordings": {
            "train": [m.name for m in members if not m.held_out],
            "held_out": [m.name for m in members if m.held_out],
            "rejected": [{"file": file, "why": why} for file, why in report.data.rejected],
        },
        "channels": [channel(outcome) for outcome in report.outcomes],
        "findings": [finding(one) for one in report.findings],
        "notes": [*report.data.notes, *report.skipped, *(n for o in report.outcomes for n in o.notes)],
    }
    if report.why:
        out["why"] = report.why
    if report.left_out:
        out["leave_one_out"] = [asdict(row) for row in report.left_out]
    cleaned: dict[str, Any] = plain(out)
    if report.data.linear:
        cleaned = all_in_metres(cleaned)
    return cleaned


def channel(outcome: ChannelOutcome) -> dict[str, Any]:
    """A compared channel."""
    tested = outcome.structure
    out: dict[str, Any] = {
        "channel": outcome.channel,
        "unit": CHANNEL_UNITS[outcome.channel],
        "noise_floor": outcome.floor,
        "noise_floor_std": outcome.floor_std,
        "noise_floor_method": outcome.floor_method,
        **{f"held_out_rmse_{name}": outcome.rmse.get(name) for name in SCORES},
        "structure": None if tested is None else {"p_value": tested.p_value, "method": tested.method},
    }
    if not np.any(outcome.held_out):
        out |= {f"in_sample_rmse_{name}": outcome.in_sample.get(name) for name in SCORES}
    return out


def finding(one: Finding) -> dict[str, Any]:
    """A finding; its root mean squares bear the name of the recordings they are of."""
    found = one.discovery
    label = "held_out_rmse" if one.held_out else "in_sample_rmse"
    evidence: dict[str, Any] = {"held_out_rmse_before": None, "held_out_rmse_after": None}
    evidence |= {f"{label}_before": one.before, f"{label}_after": one.after, "p_value": found.p_value}
    out: dict[str, Any] = {
        "effect": one.effect,
        "name": one.name,
        "words": found.words,
        "status": one.status,
        "confidence": found.confidence,
        "channel": one.channel,
        "also_in": list(one.also_in),
        "location": location.to_json(one.location, one.text, one.share_of_excess),
        "equation": found.equation,
        "parameters": [dict(p) for p in found.parameters],
        "evidence": evidence,
        "alternatives": [
            {"effect": a.effect, "name": a.name, "held_out_rmse": None}
            | {label: a.rmse, "as_good": a.as_good, "why_not": a.why_not}
            for a in one.alternatives
        ],
    }
    if found.table:
        out["table"] = [dict(row) for row in found.table]
    if one.next_experiment is not None:
        experiment = one.next_experiment
        out["next_experiment"] = {
            "why": experiment.why,
            "file": experiment.file,
            "points": [dict(p) for p in experiment.points],
        }
    return out


def plain(value: Any) -> Any:
    """A value as JSON holds it: lists, numbers without infinities, None."""
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.ndarray):
        return [plain(entry) for entry in value.tolist()]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    return value
