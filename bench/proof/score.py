"""Score one report against one sealed truth: plain rules, the same for every analyser.

Rules
-----
Named right
    A finding with the true id and status ``named``.
Ambiguous right
    A finding with status ``ambiguous`` whose effect and alternatives hold the true id and one it cannot be told from.
Unknown recognised
    A finding ``unknown`` in a channel of the effect, and no finding of another name in that channel.
Located right
    The finding's channel is one of the effect's, and whatever the truth claims (orders, angle windows, direction,
    ranges of speed, load and temperature) is met: orders within half an order, half of the true ones found and half
    of the told ones true; windows and ranges overlap. What the truth does not claim is not asked.
False companion
    Any finding that answers no concealed effect.
Residual
    Held-out RMSE after over the true noise, in the channels of predictable effects (in all where there is none).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

#: Held-out RMSE over true noise between which a folder's residual is called right: the noise of the held-out recordings
#: alone differs from the folder's by a few per cent. Below the noise lies who smooths the inputs of the prediction (the
#: load motor's torque is noisy itself); far below it no held-out residual can lie.
RESIDUAL_LIMITS = (0.7, 1.05)
_ORDER_TOLERANCE = 0.5


@dataclass(frozen=True, slots=True)
class EffectScore:
    """How one concealed effect fared.

    Attributes:
        status_right: the right name (or set of names, or ``unknown``) with the right status.
        found: the true id stands in the findings, whatever the status.
        parameter_errors: |told − true| / |true| of every parameter both give.
        covered: whether each of these lies within two told standard deviations.
    """

    effect: str
    status: str
    strength: float | None
    found: bool
    status_right: bool
    located_right: bool
    parameter_errors: tuple[float, ...] = ()
    covered: tuple[bool, ...] = ()


@dataclass(frozen=True, slots=True)
class CaseScore:
    """How one folder fared.

    Attributes:
        false_companions: effects of findings that answer nothing.
        residual: worst held-out RMSE over true noise among the channels that count, NaN where none was reported.
        confidences: (told confidence, right) of every finding.
        seconds: wall time of the analysis.
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

    @property
    def every_point_right(self) -> bool:
        """Verdict, names, status, location, no false companion, residual."""
        answered = all(e.status_right and e.located_right for e in self.effects)
        predictable = all(e.status != "unknown" for e in self.effects)
        residual = not predictable or RESIDUAL_LIMITS[0] <= self.residual <= RESIDUAL_LIMITS[1]
        return self.verdict_right and answered and residual and not self.false_companions and not self.failed


def score(truth: Mapping[str, Any], report: Mapping[str, Any] | None, seconds: float, failed: str = "") -> CaseScore:
    """Score a report (as read from JSON; None where the analysis failed) against a truth."""
    report = report or {}
    findings: Sequence[Mapping[str, Any]] = report.get("findings", [])
    used: dict[int, bool] = {}
    effects = []
    for concealed in truth["effects"]:
        index = _answer(concealed, findings, used)
        finding = findings[index] if index is not None else None
        result = _score_effect(concealed, finding, findings)
        if index is not None:
            used[index] = result.status_right
        effects.append(result)
    companions = tuple(str(f["effect"]) for i, f in enumerate(findings) if i not in used)
    return CaseScore(
        case=truth["case"],
        group=truth["group"],
        verdict_right=report.get("verdict") == truth["verdict"],
        effects=tuple(effects),
        false_companions=companions,
        residual=_residual(truth, report),
        confidences=tuple((float(f["confidence"]), used.get(i, False)) for i, f in enumerate(findings)),
        seconds=seconds,
        failed=failed,
    )


def names_of(finding: Mapping[str, Any]) -> set[str]:
    """The effect of a finding and its alternatives that are still open."""
    alternatives = finding.get("alternatives", []) if finding.get("status") == "ambiguous" else []
    return {str(finding["effect"]), *(str(a["effect"]) for a in alternatives)}


def located(concealed: Mapping[str, Any], finding: Mapping[str, Any]) -> bool:
    """Whether a finding's place agrees with everything the truth claims of it."""
    if finding.get("channel") not in concealed["channels"]:
        return False
    true, told = concealed["location"], finding.get("location", {})
    orders, windows = told.get("orders", []), told.get("angle_windows", [])
    # A tight spot may be told as its window or as its orders: what is told in one way need not be told in the other.
    orders_right = _orders_agree(true["orders"], orders) or bool(windows and not orders)
    windows_right = _windows_overlap(true["angle_windows"], windows) or bool(orders and not windows)
    return orders_right and windows_right and _conditions_overlap(true["conditions"], told.get("conditions", {}))


def _answer(
    concealed: Mapping[str, Any], findings: Sequence[Mapping[str, Any]], used: Mapping[int, bool]
) -> int | None:
    """The finding that answers an effect: its own name first, then any that holds one of its names, then unknown."""
    free = [i for i in range(len(findings)) if i not in used]
    own = concealed["effect"]
    accepted = {own, *concealed["also"]}
    channels = concealed["channels"]
    tests: tuple[Callable[[Mapping[str, Any]], bool], ...] = (
        lambda f: f["effect"] == own and (own != "unknown" or f["channel"] in channels),
        lambda f: bool(names_of(f) & accepted) and own != "unknown",
        lambda f: f["effect"] == "unknown" and f["channel"] in channels,
    )
    for test in tests:
        for i in free:
            if test(findings[i]):
                return i
    return None


def _score_effect(
    concealed: Mapping[str, Any], finding: Mapping[str, Any] | None, findings: Sequence[Mapping[str, Any]]
) -> EffectScore:
    own, status = concealed["effect"], concealed["status"]
    right = False
    if finding is not None and finding.get("status") == status:
        if status == "named":
            right = finding["effect"] == own
        elif status == "ambiguous":
            names = names_of(finding)
            right = own in names and bool(names & set(concealed["also"]))
        else:
            named = [f for f in findings if f["effect"] != "unknown" and f["channel"] in concealed["channels"]]
            right = finding["effect"] == "unknown" and not named
    # Where two effects cannot be told apart, neither can their parameters.
    compared = right and status == "named" and finding is not None
    errors, covered = _parameters(concealed, finding) if compared and finding is not None else ((), ())
    return EffectScore(
        effect=own,
        status=status,
        strength=concealed["strength"],
        found=any(own in names_of(f) for f in findings),
        status_right=right,
        located_right=finding is not None and located(concealed, finding),
        parameter_errors=errors,
        covered=covered,
    )


def _parameters(concealed: Mapping[str, Any], finding: Mapping[str, Any]) -> tuple[tuple[float, ...], tuple[bool, ...]]:
    told = {p["symbol"]: p for p in finding.get("parameters", [])}
    errors, covered = [], []
    for true in concealed["parameters"]:
        if true["symbol"] in told and true["value"]:
            match = told[true["symbol"]]
            gap = abs(abs(float(match["value"])) - abs(true["value"]))
            errors.append(gap / abs(true["value"]))
            if match.get("std") is not None:
                covered.append(gap <= 2.0 * float(match["std"]))
    return tuple(errors), tuple(covered)


def _residual(truth: Mapping[str, Any], report: Mapping[str, Any]) -> float:
    counted = {e["channels"][0] for e in truth["effects"] if e["status"] != "unknown"} or set(truth["noise_rms"])
    ratios = [
        float(row["held_out_rmse_after"]) / truth["noise_rms"][row["channel"]]
        for row in report.get("channels", [])
        if row["channel"] in counted and row.get("held_out_rmse_after") is not None
    ]
    return max(ratios) if ratios else math.nan


def _orders_agree(true: Sequence[float], told: Sequence[float]) -> bool:
    if not true:
        return True
    if not told:
        return False
    gaps = np.abs(np.subtract.outer(np.asarray(true, float), np.asarray(told, float)))
    near = gaps <= _ORDER_TOLERANCE
    return bool(near.any(axis=1).mean() >= 0.5 and near.any(axis=0).mean() >= 0.5)


def _windows_overlap(true: Sequence[Sequence[float]], told: Sequence[Sequence[float]]) -> bool:
    if not true:
        return True
    grid = np.linspace(0.0, 2.0 * np.pi, 3600, endpoint=False)

    def covered(windows: Sequence[Sequence[float]]) -> np.ndarray[Any, np.dtype[np.bool_]]:
        inside = np.zeros(grid.size, dtype=bool)
        for low, high in windows:
            inside |= np.mod(grid - low, 2.0 * np.pi) <= min(
                high - low if high >= low else high - low + 2 * np.pi, 6.2831
            )
        return inside

    a, b = covered(true), covered(told)
    return bool((a & b).any() and b.mean() <= max(0.5, 2.0 * a.mean()))


def _conditions_overlap(true: Mapping[str, Any], told: Mapping[str, Any]) -> bool:
    for name, claim in true.items():
        answer = told.get(name)
        if answer is None:
            continue
        if name == "direction":
            if claim != "both" and answer != claim:
                return False
        elif min(claim[1], answer[1]) < max(claim[0], answer[0]):
            return False
    return True
