"""Match, mismatch or undetermined: what the findings, the noise floor and the test of what is left come to."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import AMBIGUOUS, UNKNOWN, ChannelOutcome
from bench.mismatch.regression.sensitivity import PARAMETER
from bench.mismatch.report.content import Content
from bench.mismatch.report.figures import finite, square_error
from bench.mismatch.report.finding import Finding
from bench.simulation.terms import CHANNEL_UNITS, TRANSMISSION_ERROR

MATCH, MISMATCH, UNDETERMINED = "match", "mismatch", "undetermined"


def judged(outcomes: Sequence[ChannelOutcome], findings: Sequence[Finding]) -> tuple[str, str]:
    """The verdict, and why it is undetermined (else empty).

    ``match`` only where in every channel what is left is not distinguished from noise, and is no larger than the noise
    floor within its uncertainty.
    """
    if findings:
        return MISMATCH, ""
    if not outcomes:
        return UNDETERMINED, "no channel could be compared"
    doubts = [doubt for doubt in map(_doubt, outcomes) if doubt]
    return (UNDETERMINED, "; ".join(doubts)) if doubts else (MATCH, "")


def _doubt(outcome: ChannelOutcome) -> str:
    """Why a channel without a finding is no match; empty where it is one."""
    name, unit = in_words(outcome.channel), CHANNEL_UNITS[outcome.channel]
    p = None if outcome.structure is None else finite(outcome.structure.p_value)
    if p is None:
        return f"what is left of the {name} could not be tested for structure"
    if p < criteria.ERROR_RATE_OF_A_CHANNEL:
        return f"what is left of the {name} is not noise (p {p:.1e}), and nothing was found that explains it"
    after = finite(outcome.settled)
    if after is None:
        return f"no recording of the {name} could be held out"
    std = finite(outcome.floor_std)
    if std is None:
        text = f"{after:.3g} {unit} of the {name} is left, and its noise is about {outcome.floor:.3g} {unit}"
        return f"{text}, but how well that noise is known could not be computed"
    # how well a floor is known, how well a few recordings tell what is left, and what the calibration leaves open
    drawn = square_error(outcome) or 0.0
    error = float(np.hypot(2.0 * outcome.floor * std, drawn))
    most = (
        (criteria.MORE_THAN_NOISE * outcome.floor) ** 2 + criteria.FLOOR_ERRORS**2 * outcome.doubt + outcome.of_levels
    )
    if after**2 > most + criteria.FLOOR_ERRORS * error:
        noise = f"{outcome.floor:.3g} ± {std:.2g} {unit}"
        return f"what is left of the {name}, {after:.3g} {unit}, is more than the noise, {noise}"
    # a few recordings far off hardly move the median recording
    every, limit = finite(outcome.rmse.get("after")), criteria.MORE_THAN_NOISE**2 * most + criteria.FLOOR_ERRORS * error
    if outcome.channel == TRANSMISSION_ERROR:
        # torques waver with the control loops in some recordings, angles in steady motion do not: how recordings differ
        # is no matter of chance there
        every = finite(outcome.altogether)
        # of many orders together a calibration is off by what it says, not by errors that add up
        limit = (criteria.MORE_THAN_NOISE * outcome.floor) ** 2 + outcome.of_levels
        limit += criteria.FLOOR_ERRORS * (outcome.doubt + 2.0 * outcome.floor * std)
    if every is not None and every**2 > limit:
        return f"a few recordings leave more of the {name} than noise: {every:.3g} {unit} over all, {after:.3g} usually"
    return ""


def sentence(report: Content) -> str:
    """The verdict in one sentence."""
    if report.verdict == UNDETERMINED:
        return f"Undetermined: {report.why}."
    if report.verdict == MATCH:
        return f"Match: {_match(report.outcomes)}."
    wrong = [_described(f) for f in report.findings if f.effect == PARAMETER]
    left = [_described(f) for f in report.findings if f.effect != PARAMETER]
    parts = [*wrong, *(["the simulation leaves out " + "; ".join(left)] if left else [])]
    return f"Mismatch: {'; '.join(parts)}."


def _match(outcomes: Sequence[ChannelOutcome]) -> str:
    channels = ", ".join(in_words(o.channel) for o in outcomes)
    values = [p for o in outcomes if o.structure is not None and (p := finite(o.structure.p_value)) is not None]
    chance = f" (p {min(values):.2g} at least)" if values else ""
    left = f"what the calibrated simulation leaves of {channels} on recordings held out"
    return f"{left} is not distinguished from noise{chance}"


def _described(finding: Finding) -> str:
    channel = in_words(finding.channel)
    if finding.effect == PARAMETER:
        return f"{finding.discovery.words} ({channel})"
    if finding.status == AMBIGUOUS:
        others = [a.name for a in finding.alternatives if a.as_good]
        text = " or ".join(others) if others else "an alternative"
        return f"{finding.name}, not distinguished from {text} ({channel}: {finding.text})"
    if finding.status == UNKNOWN:
        return f"{finding.name} in {channel} ({finding.text})"
    return f"{finding.name} ({channel}: {finding.text})"


def in_words(channel: str) -> str:
    """A channel's name for people."""
    return channel.replace("_", " ")


def kind_of_simulation(scores: Iterable[tuple[float | None, float | None]], recalibrated: Collection[str]) -> str:
    """What a report's ``model.json`` holds: an improved simulation where the findings lower what is left of a channel
    (``scores``: before and with them), a recalibrated one where numbers were calibrated anew, else what was given.
    """
    if any(before is not None and after is not None and after < before for before, after in scores):
        return "improved simulation"
    return "recalibrated simulation" if recalibrated else "simulation as given"
