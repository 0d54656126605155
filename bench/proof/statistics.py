"""Statistics over scores: rates with intervals, calibration of confidence, strengths at which effects are named."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.stats import beta

from bench.proof.score import CaseScore, EffectScore


def clopper_pearson(hits: int, trials: int, level: float = 0.95) -> tuple[float, float]:
    """Exact two-sided interval of a binomial rate (Clopper and Pearson 1934); (0, 1) without trials."""
    if trials == 0:
        return 0.0, 1.0
    tail = (1.0 - level) / 2.0
    low = 0.0 if hits == 0 else float(beta.ppf(tail, hits, trials - hits + 1))
    high = 1.0 if hits == trials else float(beta.ppf(1.0 - tail, hits + 1, trials - hits))
    return low, high


def brier(confidences: Sequence[tuple[float, bool]]) -> float:
    """Mean squared difference between confidence and outcome (Brier 1950), NaN without findings."""
    if not confidences:
        return math.nan
    return float(np.mean([(p - right) ** 2 for p, right in confidences]))


@dataclass(frozen=True, slots=True)
class GroupSummary:
    """One row of the proof's table; counts are (right, of).

    Attributes:
        precision: findings that answer an effect, of all findings. residual: median over cases.
        parameter_error: median relative error. coverage: parameters within their 95 % intervals.
    """

    group: str
    cases: int
    every_point: tuple[int, int]
    verdict: tuple[int, int]
    status: tuple[int, int]
    located: tuple[int, int]
    precision: tuple[int, int]
    alarms: tuple[int, int]
    residual: float
    residual_right: tuple[int, int]
    parameter_error: float
    coverage: tuple[int, int]
    brier: float
    seconds: float
    failed: int


def summarise(group: str, scores: Sequence[CaseScore]) -> GroupSummary:
    """Summary of the scores given, all of them."""
    effects = [e for s in scores for e in s.counted]
    findings = [c for s in scores for c in s.confidences]
    extras = sum(len(s.false_companions) for s in scores)
    answers = sum(e.found for e in effects)
    residuals = np.array([s.residual for s in scores if math.isfinite(s.residual)])
    errors = [x for e in effects for x in e.parameter_errors]
    covered = [x for e in effects for x in e.covered]
    return GroupSummary(
        group=group,
        cases=len(scores),
        every_point=(sum(s.every_point_right for s in scores), len(scores)),
        verdict=(sum(s.verdict_right for s in scores), len(scores)),
        status=(sum(e.status_right for e in effects), len(effects)),
        located=(sum(e.located_right for e in effects if e.status_right), sum(e.status_right for e in effects)),
        precision=(answers, answers + extras),
        alarms=(sum(bool(s.false_companions) for s in scores), len(scores)),
        residual=float(np.median(residuals)) if residuals.size else math.nan,
        residual_right=(int(np.sum(residuals <= 1.03)), int(residuals.size)),
        parameter_error=float(np.median(errors)) if errors else math.nan,
        coverage=(sum(covered), len(covered)),
        brier=brier(findings),
        seconds=float(np.median([s.seconds for s in scores])) if scores else math.nan,
        failed=sum(bool(s.failed) for s in scores),
    )


def reliability(
    scores: Sequence[CaseScore], edges: Sequence[float] = (0.0, 0.5, 0.8, 0.95, 1.0)
) -> list[dict[str, Any]]:
    """Calibration of confidence: findings, mean confidence and share right in each bin."""
    confidences = np.array([c for s in scores for c in s.confidences], dtype=np.float64).reshape(-1, 2)
    rows = []
    for low, high in itertools.pairwise(edges):
        inside = (confidences[:, 0] >= low) & ((confidences[:, 0] < high) | (high == edges[-1]))
        if inside.any():
            rows.append(
                {
                    "confidence": [low, high],
                    "findings": int(inside.sum()),
                    "mean_confidence": float(confidences[inside, 0].mean()),
                    "right": float(confidences[inside, 1].mean()),
                }
            )
    return rows


def strength_of_naming(effects: Sequence[EffectScore], share: float) -> float:
    """Strength (units of the noise floor) at which ``share`` of an effect's cases are named.

    A logistic curve in the logarithm of the strength, fitted by maximum likelihood with a weak prior on its slope, so
    that an effect that is always (never) named gives a value below (above) the range rather than none.
    """
    points = [(math.log(e.strength), e.status_right) for e in effects if e.strength]
    if not points:
        return math.nan
    x = np.array([p[0] for p in points])
    y = np.array([float(p[1]) for p in points])

    def cost(free: np.ndarray[Any, np.dtype[np.float64]]) -> float:
        z = np.exp(free[1]) * (x - free[0])
        misfit = float(np.sum(np.logaddexp(0.0, z) - y * z))
        return float(misfit + 0.5 * (free[1] - math.log(4.0)) ** 2 + 0.05 * (free[0] - float(x.mean())) ** 2)

    best = minimize(cost, np.array([float(x.mean()), math.log(4.0)]), method="Nelder-Mead")
    centre, slope = float(best.x[0]), math.exp(float(best.x[1]))
    return math.exp(centre + math.log(share / (1.0 - share)) / slope)
