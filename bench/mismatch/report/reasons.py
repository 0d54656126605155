"""Why a figure of the report is not there."""

from __future__ import annotations

import numpy as np

from bench.mismatch.discovery import UNKNOWN, ChannelOutcome
from bench.mismatch.report.finding import Finding

NO_HELD_OUT = "no recording could be held out"
NO_STRUCTURE = "what is left was not tested"
NO_CONFIDENCE = "no calibration of confidences covers such a finding"
A_NAME_IS_LIKELIER = "a name below predicts best, but beside something else without a name it may be a part of that"
NO_SURROGATES = "no surrogates were drawn for it"
NO_STD = "the fit gives none: it was chosen, not fitted"
NO_VALUE = "the recordings do not determine it"
NO_ROWS_COMPARED = "it was compared by predictive densities only"
NOT_EVALUATED = "the model could not be evaluated on these recordings"


def of_confidence(finding: Finding) -> str:
    """Why a finding has no confidence."""
    likelier = finding.status == UNKNOWN and any(a.as_good and a.effect != UNKNOWN for a in finding.alternatives)
    return A_NAME_IS_LIKELIER if likelier else NO_CONFIDENCE


def of_score(outcome: ChannelOutcome, score: str, kind: str) -> str:
    """Why a channel has no held-out root mean square ``score`` (as_given, before, after)."""
    if not np.any(outcome.held_out):
        return NO_HELD_OUT
    if score == "as_given" and kind == "nominal":
        return "the nominal simulation has no values before it is calibrated"
    if score == "as_given":
        return "the simulation given leaves values of this channel to be calibrated"
    return NOT_EVALUATED


def of_rmse(finding: Finding) -> str:
    """Why a finding has no root mean square with or without it."""
    return NOT_EVALUATED if finding.after is None else "its contribution to these recordings is not known"


def of_share(finding: Finding) -> str:
    """Why a finding has no share of the energy above the noise."""
    if not finding.held_out:
        return NO_HELD_OUT
    if finding.after is None or finding.before is None:
        return of_rmse(finding)
    return "what is left without it is no more than the noise"
