"""The proof's table, as Markdown for people and as JSON for scripts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from bench.proof.score import CaseScore
from bench.proof.statistics import (
    GroupSummary,
    clopper_pearson,
    reliability,
    strength_of_naming,
    summarise,
)

_HEAD = (
    "set",
    "folders",
    "every point right",
    "verdict",
    "name and status",
    "located",
    "findings right",
    "folders with a false finding",
    "residual / noise",
    "≤ 1.03",
    "parameter error",
    "within 2σ",
    "Brier",
    "s a folder",
)


def markdown(scores: Sequence[CaseScore], title: str = "bench prove", seal: str = "") -> str:
    """The whole proof as Markdown: one row a group, then every folder that is not right, then calibration."""
    lines = [f"# {title}", ""]
    if seal:
        lines += [f"Truth sealed before the runs; SHA-256 over all seals: `{seal}`.", ""]
    lines += [*summary_rows(scores), ""]
    lines += _null_lines(scores)
    lines += _effect_lines(scores)
    lines += _faults(scores)
    lines += _calibration(scores)
    return "\n".join(lines) + "\n"


def summary_rows(scores: Sequence[CaseScore]) -> list[str]:
    """The summary table's lines: one row a group, the last one over all."""
    groups = list(dict.fromkeys(s.group for s in scores))
    rows = [summarise(group, [s for s in scores if s.group == group]) for group in groups]
    if len(groups) > 1:
        rows.append(summarise("all", scores))
    return [_line(_HEAD), _line(["---"] * len(_HEAD)), *(_line(_cells(row)) for row in rows)]


def as_json(scores: Sequence[CaseScore], **extra: Any) -> dict[str, Any]:
    """Everything the Markdown shows, and every score."""
    groups = list(dict.fromkeys(s.group for s in scores))
    return {
        "format": "bench-proof",
        "format_version": "1.0",
        "groups": [_plain(asdict(summarise(g, [s for s in scores if s.group == g]))) for g in groups],
        "calibration": reliability(scores),
        "cases": [_plain({**asdict(s), "every_point_right": s.every_point_right}) for s in scores],
        **extra,
    }


def severity_markdown(scores: Sequence[CaseScore]) -> str:
    """S50 and S90 of each effect and the share named at each strength."""
    effects: dict[str, list[Any]] = {}
    for case in scores:
        for effect in case.effects:
            effects.setdefault(effect.effect, []).append(effect)
    lines = ["## Severity", "", _line(("effect", "cases", "S50", "S90")), _line(["---"] * 4)]
    for name, found in sorted(effects.items()):
        s50, s90 = strength_of_naming(found, 0.5), strength_of_naming(found, 0.9)
        lines.append(_line((name, str(len(found)), f"{s50:.2f}", f"{s90:.2f}")))
    return "\n".join([*lines, ""]) + "\n"


def _cells(row: GroupSummary) -> list[str]:
    return [
        row.group,
        str(row.cases) + (f" ({row.failed} failed)" if row.failed else ""),
        _share(row.every_point),
        _share(row.verdict),
        _share(row.status),
        _share(row.located),
        _share(row.precision),
        _share(row.alarms),
        _number(row.residual, 3),
        _share(row.residual_right),
        "–" if math.isnan(row.parameter_error) else f"{100.0 * row.parameter_error:.1f} %",
        _share(row.coverage),
        _number(row.brier, 3),
        _number(row.seconds, 1),
    ]


def _null_lines(scores: Sequence[CaseScore]) -> list[str]:
    nulls = [s for s in scores if s.group == "null"]
    if not nulls:
        return []
    alarms = sum(bool(s.false_companions) or not s.verdict_right for s in nulls)
    low, high = clopper_pearson(alarms, len(nulls))
    text = f"False alarms on folders without effect: {alarms} of {len(nulls)}"
    return [f"{text}, 95 % interval {100 * low:.1f} to {100 * high:.1f} % (Clopper–Pearson).", ""]


def _effect_lines(scores: Sequence[CaseScore]) -> list[str]:
    effects: dict[str, list[Any]] = {}
    for case in scores:
        for effect in case.effects:
            effects.setdefault(effect.effect, []).append(effect)
    if not effects:
        return []
    lines = ["## By effect", "", _line(("effect", "name and status", "located", "parameter error"))]
    lines.append(_line(["---"] * 4))
    for name, found in sorted(effects.items()):
        right = [e for e in found if e.status_right]
        errors = [x for e in right for x in e.parameter_errors]
        error = f"{100.0 * sum(errors) / len(errors):.1f} %" if errors else "–"
        located = (sum(e.located_right for e in right), len(right))
        lines.append(_line((name, _share((len(right), len(found))), _share(located), error)))
    return [*lines, ""]


def _faults(scores: Sequence[CaseScore]) -> list[str]:
    wrong = [s for s in scores if not s.every_point_right]
    if not wrong:
        return ["Every point right in every folder.", ""]
    lines = ["## Folders with a point that is not right", "", _line(("folder", "concealed", "what is wrong"))]
    lines.append(_line(["---"] * 3))
    lines += [_line((s.case, ", ".join(e.effect for e in s.effects) or "nothing", _complaint(s))) for s in wrong]
    return [*lines, ""]


def _complaint(case: CaseScore) -> str:
    parts = [f"failed: {case.failed}"] if case.failed else []
    if not case.verdict_right:
        parts.append("verdict")
    for effect in case.effects:
        if not effect.status_right:
            parts.append(f"{effect.effect} {'told, status wrong' if effect.found else 'not told'} ({effect.status})")
        elif not effect.located_right:
            parts.append(f"{effect.effect} misplaced")
    if case.false_companions:
        parts.append("false: " + ", ".join(case.false_companions))
    if math.isfinite(case.residual) and all(e.status != "unknown" for e in case.effects):
        parts.append(f"residual {case.residual:.3f}")
    return "; ".join(parts)


def _calibration(scores: Sequence[CaseScore]) -> list[str]:
    rows = reliability(scores)
    if not rows:
        return []
    lines = ["## Calibration of confidence", "", _line(("confidence", "findings", "mean", "right"))]
    lines.append(_line(["---"] * 4))
    for row in rows:
        low, high = row["confidence"]
        mean, right = f"{row['mean_confidence']:.3f}", f"{row['right']:.3f}"
        lines.append(_line((f"{low:g}–{high:g}", str(row["findings"]), mean, right)))
    return [*lines, ""]


def _share(pair: tuple[int, int]) -> str:
    return f"{pair[0]}/{pair[1]}" if pair[1] else "–"


def _number(value: float, digits: int) -> str:
    return "–" if math.isnan(value) else f"{value:.{digits}f}"


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _plain(values: Mapping[str, Any]) -> dict[str, Any]:
    """NaN has no place in JSON: None instead."""
    return {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in values.items()}
