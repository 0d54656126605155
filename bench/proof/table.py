"""The proof's tables as Markdown."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence

from bench.proof.results import Provenance
from bench.proof.score import CaseScore, EffectScore
from bench.proof.statistics import (
    GroupSummary,
    clopper_pearson,
    reliability,
    strength_of_naming,
    summarise,
)

_HEAD = (
    "set",
    "asked",
    "done",
    "every point right",
    "verdict",
    "name and status",
    "located",
    "findings right",
    "folders with a false finding",
    "residual / noise",
    "≤ 1.03",
    "parameter error",
    "in 95 % interval",
    "Brier",
    "s a folder",
)


#: Whether it is an unknown kind, whether the library has its form → how the table calls it.
_FORMS = {
    (False, True): "in the library",
    (False, False): "not in the library",
    (True, True): "unknown kind that a free function of one quantity draws",
    (True, False): "unknown kind with a state or several quantities",
}


def markdown(scores: Sequence[CaseScore], how: Provenance, severity: bool = False) -> str:
    """The whole proof as Markdown: how it came about, one row a set, then everything that is not right."""
    lines = ["# bench prove", "", f"{how.summary}.", ""]
    if how.seal:
        lines += [f"Truth sealed before the runs; SHA-256 over all seals: `{how.seal}`.", ""]
    if severity:
        return "\n".join([*lines, *severity_lines(scores), ""]) + "\n"
    return "\n".join([*lines, *summary_rows(scores, how.asked), "", *body(scores)]) + "\n"


def summary_rows(scores: Sequence[CaseScore], asked: Mapping[str, int] | None = None) -> list[str]:
    """The summary table's lines: one row a set, the last one over all; ``asked`` folders of each set."""
    groups = list(dict.fromkeys([*(asked or {}), *(s.group for s in scores)]))
    rows = [summarise(group, [s for s in scores if s.group == group]) for group in groups]
    wanted = {row.group: row.cases for row in rows} | dict(asked or {})
    if len(groups) > 1:
        rows.append(summarise("all", scores))
        wanted["all"] = sum(wanted.values())
    return [_line(_HEAD), _line(["---"] * len(_HEAD)), *(_line(_cells(row, wanted[row.group])) for row in rows)]


def body(scores: Sequence[CaseScore]) -> list[str]:
    """Everything below the summary."""
    lines: list[str] = []
    unpredicted = sum(not s.recomputed for s in scores)
    if unpredicted:
        lines += [
            f"Residuals of {unpredicted} of {len(scores)} folders are as told by the report: nothing predicts them.",
            "",
        ]
    lines += _null_lines(scores)
    lines += _effect_lines(scores)
    lines += _form_lines(scores)
    lines += _faint_lines(scores)
    lines += _again_lines(scores)
    lines += _faults(scores)
    return lines + _calibration(scores)


def severity_lines(scores: Sequence[CaseScore]) -> list[str]:
    """S50 and S90 of each effect and the share named at each strength."""
    effects = _by_effect(scores)
    lines = [_line(("effect", "cases", "S50", "S90")), _line(["---"] * 4)]
    for name, found in sorted(effects.items()):
        tried = [e.strength for e in found if e.strength]
        ends = [_within(strength_of_naming(found, share), tried) for share in (0.5, 0.9)]
        lines.append(_line((name, str(len(found)), *ends)))
    return lines


def _within(strength: float, tried: Sequence[float]) -> str:
    """A strength as far as it was tried: beyond the faintest and the strongest nothing was measured."""
    if not tried:
        return "–"
    if strength < min(tried):
        return f"< {min(tried):.2f}"
    return f"> {max(tried):.2f}" if strength > max(tried) else f"{strength:.2f}"


def _by_effect(scores: Sequence[CaseScore]) -> dict[str, list[EffectScore]]:
    effects: dict[str, list[EffectScore]] = {}
    for case in scores:
        for effect in case.counted:
            effects.setdefault(effect.effect, []).append(effect)
    return effects


def _cells(row: GroupSummary, asked: int) -> list[str]:
    return [
        row.group,
        str(asked),
        str(row.cases - row.failed),
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
    nulls = [s for s in scores if s.group.startswith("null")]
    if not nulls:
        return []
    # With weak orders nothing else is concealed: missing them is no alarm, anything beside them is.
    alarms = sum(bool(s.false_companions) or (not s.verdict_right and not s.effects) for s in nulls)
    low, high = clopper_pearson(alarms, len(nulls))
    text = f"False alarms on folders without effect: {alarms} of {len(nulls)}"
    return [f"{text}, 95 % interval {100 * low:.1f} to {100 * high:.1f} % (Clopper–Pearson).", ""]


def _effect_lines(scores: Sequence[CaseScore]) -> list[str]:
    effects = _by_effect(scores)
    if not effects:
        return []
    lines = ["### By effect", "", _line(("effect", "name and status", "located", "parameter error"))]
    lines.append(_line(["---"] * 4))
    for name, found in sorted(effects.items()):
        right = [e for e in found if e.status_right]
        errors = [x for e in right for x in e.parameter_errors]
        error = f"{100.0 * sum(errors) / len(errors):.1f} %" if errors else "–"
        located = (sum(e.located_right for e in right), len(right))
        lines.append(_line((name, _share((len(right), len(found))), _share(located), error)))
    return [*lines, ""]


def _form_lines(scores: Sequence[CaseScore]) -> list[str]:
    """Effects whose very form the library has, beside those whose form it has not."""
    counted = [e for s in scores for e in s.counted if e.in_library is not None]
    if not counted:
        return []
    head = ("nature's form", "effects", "name and status", "located", "parameter error")
    lines = ["### By form", "", _line(head), _line(["---"] * len(head))]
    for unknown in (False, True):
        for inside in (True, False):
            mine = [e for e in counted if e.in_library is inside and (e.status == "unknown") is unknown]
            if not mine:
                continue
            right = [e for e in mine if e.status_right]
            errors = [x for e in right for x in e.parameter_errors]
            name = _FORMS[unknown, inside]
            error = f"{100.0 * statistics.median(errors):.1f} % (median)" if errors else "–"
            located = (sum(e.located_right for e in right), len(right))
            lines.append(_line((name, str(len(mine)), _share((len(right), len(mine))), _share(located), error)))
    return [*lines, ""]


def _faint_lines(scores: Sequence[CaseScore]) -> list[str]:
    """Effects that were drawn too small to be seen: they stand apart."""
    faint = [(s.case, e) for s in scores for e in s.effects if e.too_faint]
    if not faint:
        return []
    found = sum(e.found for _case, e in faint)
    named = ", ".join(f"{e.effect} in {case} ({e.strength:g} of the noise)" for case, e in faint)
    return [f"Too faint to be seen, by the sealed truth, and not counted: {len(faint)}, told {found}: {named}.", ""]


def _again_lines(scores: Sequence[CaseScore]) -> list[str]:
    """Whether the models hold in another campaign on the same plant."""
    played = [(s, s.again) for s in scores if s.again is not None]
    if not played:
        return []
    holds, match = sum(bool(s.holds) for s, _ in played), sum(again["verdict"] == "match" for _, again in played)
    head = ("folder", "residual / noise in the other campaign", "verdict there", "emulator playing it / two noises", "")
    lines = ["### Model on new data", ""]
    lines.append(f"At the noise in every channel, before any search: {holds} of {len(played)}; verdict match: {match}.")
    lines += ["", _line(head), _line(["---"] * len(head))]
    for s, again in played:
        lines.append(
            _line((s.case, _each(again["residual"]), again["verdict"] or "–", _each(again["played"]), again["why"]))
        )
    return [*lines, ""]


def _each(ratios: Mapping[str, float]) -> str:
    return ", ".join(f"{channel.replace('_', ' ')} {value:.2f}" for channel, value in ratios.items()) or "–"


def _faults(scores: Sequence[CaseScore]) -> list[str]:
    wrong = [s for s in scores if not s.every_point_right]
    if not wrong:
        return ["Every point right in every folder.", ""]
    lines = ["### Folders with a point that is not right", "", _line(("folder", "concealed", "what is wrong"))]
    lines.append(_line(["---"] * 3))
    lines += [_line((s.case, ", ".join(e.effect for e in s.effects) or "nothing", _complaint(s))) for s in wrong]
    return [*lines, ""]


def _complaint(case: CaseScore) -> str:
    parts = [f"failed: {case.failed}"] if case.failed else []
    if not case.verdict_right:
        parts.append("verdict")
    for effect in case.counted:
        if not effect.status_right:
            parts.append(f"{effect.effect} {'told, status wrong' if effect.found else 'not told'} ({effect.status})")
        elif not effect.located_right:
            parts.append(f"{effect.effect} misplaced ({', '.join(effect.misplaced)})")
    if case.false_companions:
        parts.append("false: " + ", ".join(case.false_companions))
    if math.isfinite(case.residual) and all(e.status != "unknown" for e in case.counted):
        parts.append(f"residual {case.residual:.3f}")
    return "; ".join(parts)


def _calibration(scores: Sequence[CaseScore]) -> list[str]:
    rows = reliability(scores)
    if not rows:
        return []
    lines = ["### Calibration of confidence", "", _line(("confidence", "findings", "mean", "right"))]
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
