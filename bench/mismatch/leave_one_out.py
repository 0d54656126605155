"""Would it have been found? Every nominal term is switched off in turn, and the recordings are asked for it.

The comparison is made against the simulation as improved by what was found, so that a term left out stands alone. A
term counts as named where a finding bears its id; as found under another name where something else is told in its
channels; what an ablation cannot show is said with the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from bench.mismatch.assess import Assessment, assess
from bench.mismatch.channels import SENSOR_ERRORS
from bench.mismatch.dataset import Dataset, load
from bench.mismatch.findings import Finding
from bench.mismatch.given import Given
from bench.simulation.frame import Frame
from bench.simulation.model import NOMINAL_TERMS, Simulation, Term
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR
from bench.simulation.terms import Term as LibraryTerm

NAMED, AMBIGUOUS, OTHERWISE, NOT_FOUND, NOT_ASKED = (
    "named",
    "ambiguous",
    "found under another name",
    "not found",
    "not asked",
)
_IDLE = 1e-12
"""largest regressor below which a term does not act in the recordings"""


@dataclass(slots=True)
class LeftOut:
    """What became of one nominal term switched off. RMSE per sample on held-out recordings, in the channel's unit."""

    effect: str
    name: str
    channel: str
    outcome: str
    said: list[str] = field(default_factory=list)
    """what the report called, strongest first"""
    confidence: float | None = None
    rmse_without: float | None = None
    rmse_found: float | None = None
    noise_floor: float | None = None
    parameters: str = ""
    why: str = ""


@dataclass(frozen=True, slots=True)
class Question:
    """One term to leave out, picklable: a worker reads the folder itself, once for all its questions."""

    recordings: Path
    model: Simulation
    channels: tuple[str, ...]
    known: frozenset[str]
    effect: str


Map = Callable[[Callable[[Question], LeftOut], Sequence[Question]], Iterable[LeftOut]]


def leave_one_out(
    data: Dataset,
    model: Simulation,
    channels: Sequence[str],
    whole: Assessment,
    recordings: Path,
    progress: Callable[[str, float], None],
    elsewhere: Map | None = None,
    effects: Sequence[str] = NOMINAL_TERMS,
) -> list[LeftOut]:
    """Switch off each of the nominal terms ``effects`` that is in force in ``model``, one after another.

    ``whole``: the comparison with nothing switched off; what that found is no answer to a term left out. ``elsewhere``
    maps the questions over other processes, which read ``recordings`` themselves; the rows are the same.
    """
    known = frozenset(f.effect for f in whole.findings if f.status == "unknown")
    questions = [Question(recordings, model, tuple(channels), known, effect) for effect in effects]
    out: list[LeftOut] = []
    answers = (_asked(data, q) for q in questions) if elsewhere is None else iter(elsewhere(answer, questions))
    for number, question in enumerate(questions):
        progress(question.effect, number / len(questions))
        out.append(next(answers))
    return out


def answer(question: Question) -> LeftOut:
    """Answer a question in a process of its own."""
    return _asked(_loaded(question.recordings), question)


@lru_cache(1)
def _loaded(recordings: Path) -> Dataset:
    return load(recordings)


def _asked(data: Dataset, question: Question) -> LeftOut:
    term, model, channels = LIBRARY[question.effect], question.model, question.channels
    channel = next(iter(term.forms))
    why = _not_asked(term, channel, data, model, channels)
    if why:
        return LeftOut(term.effect, term.name, channel, NOT_ASKED, why=why)
    asked = [c for c in channels if c == channel or (c == LOAD_TORQUE and _corrects(model, channel))]
    given = Given.of(model.with_term(Term(term.effect, False)))
    return _row(term, channel, assess(data, given, asked), question.known)


def _corrects(model: Simulation, channel: str) -> bool:
    """Whether an error of the torque sensor, known from the load torque, is taken into account in a channel."""
    sensor = any(model.enabled(effect) for effect in SENSOR_ERRORS if effect in model.terms)
    return sensor and channel in (MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR)


def _not_asked(term: LibraryTerm, channel: str, data: Dataset, model: Simulation, channels: Sequence[str]) -> str:
    if not model.enabled(term.effect):
        return "already switched off in the simulation given"
    if channel not in channels:
        return f"the recordings cannot be compared in {channel}"
    frame = _frame(data, channel)
    if term.effect != "te.fourier" and not np.any(np.abs(term.forms[channel][0].columns(frame, ())) > _IDLE):
        return "nothing in these recordings depends on it"
    return ""


def _frame(data: Dataset, channel: str) -> Frame:
    rows = {TEMPERATURE: data.heat, TRANSMISSION_ERROR: data.angle}.get(channel, data.slow.get(channel))
    assert rows is not None
    return rows.frame


def _row(term: LibraryTerm, channel: str, found: Assessment, known: frozenset[str]) -> LeftOut:
    score = found.scores[channel]
    told = [f for f in found.findings if channel in (f.channel, *f.also_in) or f.effect == term.effect]
    own = next((f for f in told if _is(f, term.effect)), None)
    out = LeftOut(
        term.effect,
        term.name,
        channel,
        NOT_FOUND,
        [f.effect for f in told],
        rmse_without=score.before,
        rmse_found=score.after,
        noise_floor=score.floor,
    )
    if own is not None:
        out.outcome = AMBIGUOUS if own.status == "ambiguous" else NAMED
        out.confidence = round(own.confidence, 3)
        out.parameters = ", ".join(
            f"{p['symbol']} = {p['value']:.4g} ± {p['std']:.1g} {p['unit']}" for p in own.parameters[:3]
        )
    elif any(f.effect not in known for f in told):
        out.outcome = OTHERWISE
    else:
        out.why = (
            "what it leaves is told within structure without a name, which these recordings hold with it, too"
            if told
            else "the rest of the simulation, calibrated without it, leaves too little to be told from noise"
        )
    return out


def _is(finding: Finding, effect: str) -> bool:
    """Whether a finding is the term; orders of a series that is switched off are that series, told order by order."""
    return finding.effect == effect or (effect == "te.fourier" and finding.effect == "te.harmonic")


def table(rows: Sequence[LeftOut]) -> str:
    """The rows as a Markdown table, for the terminal and for documents."""
    lines = [
        "| term left out | channel | would it have been found? | RMSE without → with it | noise | said |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        pair = "–" if row.rmse_without is None else f"{row.rmse_without:.3g} → {row.rmse_found:.3g}"
        floor = "–" if row.noise_floor is None else f"{row.noise_floor:.3g}"
        sure = "" if row.confidence is None else f" ({row.confidence:.2f})"
        said = row.parameters or row.why or ", ".join(row.said) or "–"
        lines.append(f"| `{row.effect}` | {row.channel} | {row.outcome}{sure} | {pair} | {floor} | {said} |")
    return "\n".join(lines)
