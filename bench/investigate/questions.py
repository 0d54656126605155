"""What a report leaves open, and between which explanations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch.report.finding import Finding
from bench.mismatch.report.truth import is_regressor

MOST_ALTERNATIVES = 3


@dataclass(frozen=True, slots=True)
class Question:
    """A finding that is not settled, and ``why``; ``alternatives`` are effects that can be fitted in its place."""

    finding: Finding
    why: str
    alternatives: tuple[str, ...]

    @property
    def key(self) -> tuple[str, ...]:
        """Identity of the question from one analysis to the next: its channel and all its explanations."""
        return (self.finding.channel, *sorted({self.finding.effect, *self.alternatives}))


def questions(findings: Sequence[Finding], confidence: float) -> tuple[Question, ...]:
    """The findings that are ambiguous, unknown, or named with less than ``confidence``, in the report's order."""
    out = []
    for finding in findings:
        sure = finding.discovery.confidence
        weak = sure is not None and sure < confidence
        if not finding.open and not weak:
            continue
        kept = [a for a in finding.alternatives if a.as_good or (not finding.open and weak)]
        alternatives = [
            a.effect for a in kept if a.effect != finding.effect and is_regressor(a.effect, finding.channel)
        ]
        why = finding.status if finding.open else f"confidence {sure:.2f}, asked for {confidence:.2f}"
        out.append(Question(finding, why, tuple(dict.fromkeys(alternatives))[:MOST_ALTERNATIVES]))
    return tuple(out)


def loss_of(finding: Finding, effect: str) -> float | None:
    """Log predictive density that an explanation loses against a finding; None where it was not worked out."""
    for alternative in finding.discovery.alternatives:
        if alternative.effect == effect and np.isfinite(alternative.loss):
            return float(alternative.loss)
    return None
