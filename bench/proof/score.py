"""Score one report against one sealed truth: plain rules, the same for every analyser.

Rules
-----
Named right
    A finding with the true id and status ``named``.
Ambiguous right
    A finding with status ``ambiguous`` that holds the true id and one it cannot be told from, each as its effect or as
    an alternative that the report itself calls as good.
Unknown recognised
    A finding ``unknown`` in a channel of the effect, and no finding in that channel with a name nobody concealed.
Located right
    :mod:`bench.proof.location`: ranges, direction, orders, windows and recordings; what is not told is wrong.
Parameters
    Those of ``model.json``, with their signs.
False companion
    Any finding that answers no concealed effect.
Too faint
    An effect that the sealed truth calls too faint asks for nothing: told or not, it is neither right nor wrong.
Residual
    Recomputed from ``model.json`` and the recordings (:mod:`bench.proof.recompute`), over the generator's noise in the
    same recordings, in the channels of predictable effects (in all where there is none).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bench.proof.location import misplaced

#: Held-out RMSE over true noise between which a folder's residual is called right: the noise of the held-out recordings
#: alone differs from the folder's by a few per cent. Below the noise lies who smooths the inputs of the prediction: of
#: the load torque's noise the load motor has a part. On the quietest bench that is drawn the sensor has 0.6 * 2 N*m and
#: the motor 1 N*m, each with a spread of 0.2 in its logarithm: 0.56 of the whole is the sensor's alone two standard
#: deviations off. Below that no held-out residual can lie.
RESIDUAL_LIMITS = (0.55, 1.05)
#: A told 95 % interval is this many told standard deviations to either side.
INTERVAL = 1.96
#: Words with which a report says that an alternative is as good; a key ``as_good`` says it as well.
_AS_GOOD = ("as well", "as good", "cannot tell", "cannot be told")


@dataclass(frozen=True, slots=True)
class EffectScore:
    """How one concealed effect fared.

    Attributes:
        status_right: the right name (or set of names, or ``unknown``) with the right status.
        found: the true id stands in the findings, whatever the status.
        misplaced: what is wrong with the place of the finding that answers it.
        in_library: whether nature took a form that the analyser's library has; None where that is no question.
        parameter_errors: |told − true| / |true| of every parameter both give.
        covered: whether each of these lies within its told 95 % interval.
        share_error: |told − recomputed| share of the excess, None where either is missing.
        too_faint: nobody could see it, by the sealed truth; it does not count.
    """

    effect: str
    status: str
    strength: float | None
    found: bool
    status_right: bool
    located_right: bool
    parameter_errors: tuple[float, ...] = ()
    covered: tuple[bool, ...] = ()
    misplaced: tuple[str, ...] = ()
    in_library: bool | None = None
    share_error: float | None = None
    too_faint: bool = False


@dataclass(frozen=True, slots=True)
class CaseScore:
    """How one folder fared.

    Attributes:
        false_companions: effects of findings that answer nothing.
        residual: worst RMSE over true noise among the channels that count, NaN where nothing predicts them.
        recomputed: whether it was worked out from ``model.json``; else it is what the report tells.
        confidences: (told confidence, right) of every finding that tells one.
        seconds: wall time of the analysis.
        again: what of the model holds on new data (:mod:`bench.proof.through.loop`), None where nobody asked.
    """

    case: str
    group: str
    verdict_right: bool
    effects: tuple[EffectScore, ...]
    false_companions: tuple[str, ...]
    residual: float
    confidences: tuple[tuple[float, bool], ...]
    seconds: float
    failed: str = ""
    recomputed: bool = True
    again: Mapping[str, Any] | None = None

    @property
    def holds(self) -> bool | None:
        """Whether the model predicts another campaign to the noise in every channel; None where nobody asked."""
        if self.again is None:
            return None
        ratios = self.again["residual"].values()
        return bool(ratios) and max(ratios) <= RESIDUAL_LIMITS[1]

    @property
    def counted(self) -> tuple[EffectScore, ...]:
        """The effects that could be seen."""
        return tuple(e for e in self.effects if not e.too_faint)

    @property
    def every_point_right(self) -> bool:
        """Verdict, names, status, location, no false companion, residual."""
        answered = all(e.status_right and e.located_right for e in self.counted)
        predictable = all(e.status != "unknown" for e in self.counted)
        residual = not predictable or RESIDUAL_LIMITS[0] <= self.residual <= RESIDUAL_LIMITS[1]
        return self.verdict_right and answered and residual and not self.false_companions and not self.failed


def score(
    truth: Mapping[str, Any],
    report: Mapping[str, Any] | None,
    seconds: float,
    failed: str = "",
    recomputed: Mapping[str, Any] | None = None,
) -> CaseScore:
    """Score a report (as read from JSON; None where the analysis failed) against a truth.

    ``recomputed`` is what :func:`bench.proof.recompute.recompute` works out; without it, or where this version has
    nothing that predicts, the report's residuals are taken, and the score says so. A ``model.json`` that is missing or
    does not predict has no residual, and is not right.
    """
    report = report or {}
    findings: Sequence[Mapping[str, Any]] = report.get("findings", [])
    present = {e["effect"] for e in truth["effects"]}
    used: dict[int, bool] = {}
    faint: set[int] = set()
    effects = []
    # one that could be seen is answered first
    for concealed in sorted(truth["effects"], key=lambda e: bool(e.get("too_faint"))):
        index = _answer(concealed, findings, used)
        result = _score_effect(concealed, index, findings, present, recomputed or {})
        if index is not None:
            used[index] = result.status_right
            faint |= {index} if result.too_faint else set()
        effects.append(result)
    companions = tuple(str(f["effect"]) for i, f in enumerate(findings) if i not in used)
    predicted = bool(recomputed and recomputed["predictor"])
    return CaseScore(
        case=truth["case"],
        group=truth["group"],
        verdict_right=report.get("verdict") in _verdicts(truth),
        effects=tuple(effects),
        false_companions=companions,
        residual=_residual(
            truth, recomputed["residual"] if recomputed and predicted else _reported_residuals(truth, report)
        ),
        confidences=tuple(
            (float(f["confidence"]), used.get(i, False))
            for i, f in enumerate(findings)
            if f["confidence"] is not None and i not in faint
        ),
        seconds=seconds,
        failed=failed,
        recomputed=predicted,
        again=recomputed.get("again") if recomputed else None,
    )


def _verdicts(truth: Mapping[str, Any]) -> set[str]:
    """Verdicts that are right; of what is too faint to be seen either is."""
    seen = [e for e in truth["effects"] if not e.get("too_faint")]
    return {truth["verdict"]} if seen or not truth["effects"] else {"match", "mismatch"}


def names_of(finding: Mapping[str, Any]) -> set[str]:
    """The effect of a finding and, of an ambiguous one, the alternatives that the report calls as good."""
    alternatives = finding.get("alternatives", []) if finding.get("status") == "ambiguous" else []
    return {str(finding["effect"]), *(str(a["effect"]) for a in alternatives if called_as_good(a))}


def called_as_good(alternative: Mapping[str, Any]) -> bool:
    """Whether the report itself says that an alternative explains the recordings as well."""
    if alternative.get("as_good") is not None:
        return bool(alternative["as_good"])
    why_not = str(alternative.get("why_not") or "").lower()
    return not why_not or any(words in why_not for words in _AS_GOOD)


def _answer(
    concealed: Mapping[str, Any], findings: Sequence[Mapping[str, Any]], used: Mapping[int, bool]
) -> int | None:
    """The finding that answers an effect: its own name first, then any that holds one of its names, then unknown."""
    free = [i for i in range(len(findings)) if i not in used]
    effect = concealed["effect"]
    accepted = {effect, *concealed["also"]}
    channels = concealed["channels"]
    tests: tuple[Callable[[Mapping[str, Any]], bool], ...] = (
        lambda f: f["effect"] == effect and (effect != "unknown" or f["channel"] in channels),
        lambda f: bool(names_of(f) & accepted) and effect != "unknown",
        lambda f: f["effect"] == "unknown" and f["channel"] in channels,
    )
    for test in tests:
        for i in free:
            if test(findings[i]):
                return i
    return None


def _score_effect(
    concealed: Mapping[str, Any],
    index: int | None,
    findings: Sequence[Mapping[str, Any]],
    present: set[str],
    recomputed: Mapping[str, Any],
) -> EffectScore:
    """``index`` is that of the finding that answers; ``present`` are the ids of all effects in the folder."""
    effect, status = concealed["effect"], concealed["status"]
    finding = findings[index] if index is not None else None
    right = False
    if finding is not None and finding.get("status") == status:
        if status == "named":
            right = finding["effect"] == effect
        elif status == "ambiguous":
            names = names_of(finding)
            right = effect in names and bool(names & set(concealed["also"]))
        else:
            false = [f for f in findings if f["effect"] not in (*present, "unknown")]
            named = [f for f in false if f["channel"] in concealed["channels"]]
            right = finding["effect"] == "unknown" and not named
    wrong = misplaced(concealed, finding) if finding is not None else ["not told"]
    # Where two effects cannot be told apart, neither can their parameters.
    compared = right and status == "named"
    parameters = recomputed.get("parameters", {}).get(effect, {}) if compared else {}
    errors, covered = _parameters(concealed, parameters)
    return EffectScore(
        effect=effect,
        status=status,
        strength=concealed["strength"],
        found=any(effect in names_of(f) for f in findings),
        status_right=right,
        located_right=not wrong,
        parameter_errors=errors,
        covered=covered,
        misplaced=tuple(wrong),
        in_library=concealed.get("in_library"),
        share_error=_share_error(finding, recomputed.get("shares", {}).get(str(index))) if right else None,
        too_faint=bool(concealed.get("too_faint")),
    )


def _share_error(finding: Mapping[str, Any] | None, recomputed: float | None) -> float | None:
    share = (finding or {}).get("location", {}).get("share_of_excess")
    return None if share is None or recomputed is None else abs(float(share) - recomputed)


def _parameters(
    concealed: Mapping[str, Any], reported: Mapping[str, Sequence[float | None]]
) -> tuple[tuple[float, ...], tuple[bool, ...]]:
    """Relative errors, and whether the told intervals cover, of the parameters (symbol → value, std) both give."""
    errors, covered = [], []
    for true in concealed["parameters"]:
        value, std = reported.get(true["symbol"], (None, None))
        if value is None or not true["value"]:
            continue
        gap = abs(value - true["value"])
        errors.append(gap / abs(true["value"]))
        if std is not None:
            covered.append(gap <= INTERVAL * std)
    return tuple(errors), tuple(covered)


def _residual(truth: Mapping[str, Any], ratios: Mapping[str, float]) -> float:
    """The worst ratio among the channels of predictable effects; of all where there are none."""
    predictable = (e for e in truth["effects"] if e["status"] != "unknown" and not e.get("too_faint"))
    counted = {e["channels"][0] for e in predictable} or set(truth["noise_rms"])
    picked = [ratio for channel, ratio in ratios.items() if channel in counted]
    return max(picked) if picked else math.nan


def _reported_residuals(truth: Mapping[str, Any], report: Mapping[str, Any]) -> dict[str, float]:
    return {
        row["channel"]: float(row["held_out_rmse_after"]) / truth["noise_rms"][row["channel"]]
        for row in report.get("channels", [])
        if row.get("held_out_rmse_after") is not None and row["channel"] in truth["noise_rms"]
    }
