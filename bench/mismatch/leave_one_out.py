"""Would it have been found? Every nominal term is switched off in turn, and the recordings are asked for it.

The comparison is made against the simulation as it was given: a free function that was found could take a term's
place unseen. The term is a candidate as any other of the nominal simulation is. It counts as named where a finding
bears its id; as found under another name where something is reported in its channel that is not found with the term
in force, or has grown clearly. Its numbers are given as the simulation has it: without the changes of it that were
found as well, and as uncertain as these make them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from bench.mismatch import criteria, score, simulation_file
from bench.mismatch.analysis import Analysis, analyse
from bench.mismatch.given import Given
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.loading import load
from bench.mismatch.recordings.source import Paths
from bench.mismatch.report.finding import Finding, conclude
from bench.mismatch.report.left_out import AMBIGUOUS, NAMED, NOT_ASKED, NOT_FOUND, OTHERWISE, LeftOut
from bench.simulation.linear import in_metres
from bench.simulation.model import NOMINAL_TERMS, Simulation, Term
from bench.simulation.terms import CHANNEL_UNITS, LIBRARY
from bench.simulation.terms import Term as LibraryTerm

_IDLE = 1e-12
"""largest regressor below which a term does not act in the recordings"""


GROWN = 1.0 + criteria.SHAPE
"""times the size it has with the term in force, from which a finding has taken the place of a term left out"""
Sizes = Mapping[tuple[str, ...], float]


@dataclass(frozen=True, slots=True)
class Question:
    """One term to leave out, picklable: a worker reads the folder itself, once for all its questions, with rates
    smoothed over ``span`` s.
    """

    recordings: Paths
    model: Simulation
    channels: tuple[str, ...]
    known: Sizes
    effect: str
    span: float


Map = Callable[[Callable[[Question], LeftOut], Sequence[Question]], Iterable[LeftOut]]


def leave_one_out(
    data: Dataset,
    model: Simulation,
    channels: Sequence[str],
    whole: Sequence[Finding],
    recordings: Paths,
    progress: Callable[[str, float], None],
    elsewhere: Map | None = None,
    effects: Sequence[str] = NOMINAL_TERMS,
) -> list[LeftOut]:
    """Switch off each of the nominal terms ``effects`` that is in force in ``model``, one after another.

    ``whole``: findings with nothing switched off; what those say is no answer to a term left out. ``elsewhere``
    maps the questions over other processes, which read ``recordings`` themselves; the rows are the same.
    """
    known: dict[tuple[str, ...], float] = {}
    for finding in whole:
        # two damaged places, or two functions of one quantity, have one kind
        known[_kind(finding)] = max(_size(finding), known.get(_kind(finding), 0.0))
    span = data.folder.manner.smoothing
    questions = [Question(recordings, model, tuple(channels), known, effect, span) for effect in effects]
    out: list[LeftOut] = []
    answers = (_left_out_fit(data, q) for q in questions) if elsewhere is None else iter(elsewhere(answer, questions))
    for number, question in enumerate(questions):
        progress(question.effect, number / len(questions))
        out.append(next(answers))
    return out


def answer(question: Question) -> LeftOut:
    """Answer a question in a process of its own."""
    return _left_out_fit(_loaded(question.recordings, question.span), question)


@lru_cache(1)
def _loaded(recordings: Paths, span: float) -> Dataset:
    return load(recordings, span=span)


def _left_out_fit(data: Dataset, question: Question) -> LeftOut:
    term, model = LIBRARY[question.effect], question.model
    channel = next(iter(term.forms))
    why = _why_not_fitted(term, channel, data, model, question.channels)
    if why:
        return LeftOut(term.effect, term.name, channel, NOT_ASKED, why=why)
    left = model.with_term(Term(term.effect, False))
    analysis = analyse(data, Given.of(left), [channel], formulas=False)
    held = [m for m in data.members if m.held_out] or data.members
    models = {
        "before": simulation_file.recalibrated(analysis, data.gearbox),
        "after": simulation_file.improved(analysis, data.gearbox),
    }
    rmse = score.rmse(data, analysis, models, held)[channel]
    found = conclude(tuple(analysis.outcomes.values()), data)
    return _row(term, channel, analysis, rmse, found, question.known, data.linear)


def _why_not_fitted(term: LibraryTerm, channel: str, data: Dataset, model: Simulation, channels: Sequence[str]) -> str:
    if not model.enabled(term.effect):
        return "already switched off in the simulation given"
    if channel not in channels:
        return f"the recordings cannot be compared in {channel}"
    frame = data.rows[channel].frame
    if term.effect != "te.fourier" and not np.any(np.abs(term.forms[channel][0].columns(frame, ())) > _IDLE):
        return "nothing in these recordings depends on it"
    return ""


def _row(
    term: LibraryTerm,
    channel: str,
    analysis: Analysis,
    rmse: dict[str, float | None],
    findings: Sequence[Finding],
    known: Sizes,
    linear: bool,
) -> LeftOut:
    out = LeftOut(
        term.effect,
        term.name,
        channel,
        NOT_FOUND,
        [f.effect for f in findings],
        rmse_without=rmse["before"],
        rmse_found=rmse["after"],
        noise_floor=analysis.outcomes[channel].floor,
    )
    found = next((f for f in findings if _is(f, term.effect)), None)
    if found is not None:
        out.outcome = AMBIGUOUS if found.status == "ambiguous" else NAMED
        out.confidence = found.discovery.confidence
        out.parameters = ", ".join(
            f"{p['symbol']} = {p['value']:.4g}"
            + ("" if p.get("std") is None else f" ± {p['std']:.1g}")
            + f" {in_metres(p['unit']) if linear else p['unit']}"
            for p in (found.discovery.alone or found.discovery.parameters)[:3]
        )
    elif any(_size(f) > GROWN * known.get(_kind(f), 0.0) for f in findings):
        out.outcome = OTHERWISE
    elif findings:
        which = ", ".join(dict.fromkeys(_called(f) for f in findings))
        out.why = f"what it leaves is part of what these recordings have with the term, too: {which}"
    else:
        out.why = _nothing_found(rmse["before"], analysis.outcomes[channel].floor, channel)
    return out


def _kind(finding: Finding) -> tuple[str, ...]:
    """What a finding is called and depends on."""
    return finding.channel, finding.effect, *finding.discovery.variables


def _size(finding: Finding) -> float:
    """Root mean square of what a finding adds to its rows, in the channel's unit."""
    return float(np.sqrt(np.mean(finding.discovery.added**2)))


def _called(finding: Finding) -> str:
    return "structure without a name" if finding.status == "unknown" else finding.effect


def _nothing_found(left: float | None, floor: float, channel: str) -> str:
    """Why a term that was left out was not found, nor anything else: by what is ``left`` of held-out recordings and
    the noise ``floor``, in the channel's unit.
    """
    without = "the rest of the simulation, calibrated without it,"
    if left is None:
        return f"{without} leaves nothing that was found"
    unit = CHANNEL_UNITS[channel]
    if left <= criteria.MORE_THAN_NOISE * floor:
        return f"{without} leaves {left:.3g} {unit}, which is not distinguished from noise of {floor:.3g} {unit}"
    return f"{without} leaves {left:.3g} {unit} beside noise of {floor:.3g} {unit}, and nothing was found in it"


def _is(finding: Finding, effect: str) -> bool:
    """Whether a finding is the term; the orders of a series that is switched off are reported one by one."""
    return finding.effect == effect or (effect == "te.fourier" and finding.effect == "te.harmonic")
