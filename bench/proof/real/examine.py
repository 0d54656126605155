"""One public set: import it, let the analyser and the expert look at the same samples, compare what they say."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bench.errors import BenchError
from bench.importing import import_recordings
from bench.mismatch import criteria
from bench.mismatch.prediction import compared
from bench.mismatch.recordings.dataset import Dataset, Member
from bench.mismatch.report.finding import Finding, made_of
from bench.mismatch.report.left_out import NAMED, LeftOut
from bench.mismatch.run import run
from bench.mismatch.score import prepared_members
from bench.proof.real.expert import Regression, Stretch, regress
from bench.proof.real.sets import AUXILIARY, Expert, RealSet
from bench.recording.folder import Rejected
from bench.simulation.linear import in_metres
from bench.simulation.terms import LIBRARY

SURE = 0.8
"""confidence above which a wrong name counts as a false one"""
Notify = Callable[[str], None]


@dataclass(slots=True)
class Examined:
    """A set's row: ``missing`` files, or what expert and analyser say. Root mean squares are of held-out samples."""

    real: RealSet
    missing: Sequence[str] = ()
    failed: str = ""
    broken: bool = False
    """whether it failed otherwise than by an answer of the analyser: that it cannot judge is one"""
    notes: list[str] = field(default_factory=list)
    verdict: str = ""
    regression: Regression | None = None
    said: list[str] = field(default_factory=list)
    """the findings: name, status, confidence"""
    named: dict[str, bool] = field(default_factory=dict)
    """each of the expert's effects: whether the analyser tells it, or would have, were it not in the simulation"""
    false_names: list[str] = field(default_factory=list)
    rmse: float | None = None
    before: float | None = None
    floor: float | None = None
    left_out: Sequence[LeftOut] = ()
    seconds: float = 0.0


def examine(
    real: RealSet, folder: Path, out: Path, leaving_out: bool = True, notify: Notify = lambda _: None
) -> Examined:
    """Examine a set whose files lie in ``folder/NAME``; recordings and report go into ``out/NAME``, made anew."""
    row = Examined(real, real.missing(folder))
    if row.missing:
        return row
    began = time.monotonic()
    folder_of_set = out / real.name
    shutil.rmtree(folder_of_set, ignore_errors=True)
    try:
        _compare(row, folder, folder_of_set, leaving_out, notify)
    except BenchError as error:
        row.failed, row.broken = str(error), True
    except Exception as error:  # noqa: BLE001 - what is examined may break; the other sets are examined all the same
        row.failed, row.broken = f"the analysis ended in an error: {type(error).__name__}: {error}", True
    row.seconds = time.monotonic() - began
    return row


def _compare(row: Examined, folder: Path, folder_of_set: Path, leaving_out: bool, notify: Notify) -> None:
    real = row.real
    folder_of_set.mkdir(parents=True)
    mapping = folder_of_set / "mapping.toml"
    mapping.write_text(real.mapping, encoding="utf-8")
    imported = list(import_recordings(mapping, folder_of_set / "recordings", folder / real.name))
    for one in imported:
        if isinstance(one, Rejected):
            row.notes.append(one.why)
        else:
            row.notes += [warning.removeprefix(f"{mapping}: ") for warning in one.warnings]
    if imported and all(isinstance(one, Rejected) for one in imported):
        row.failed, row.broken = f"nothing could be imported: {row.notes[0]}", True
        return
    report = run(
        folder_of_set / "recordings",
        folder_of_set / "report",
        progress=lambda what, _: notify(f"{real.name}: {what}"),
        leaving_out=leaving_out,
    )
    row.verdict = report.verdict
    row.left_out = report.left_out
    row.said = [in_metres(line) if report.data.linear else line for line in map(_described, report.findings)]
    channel = real.expert.channel
    outcome = next((o for o in report.outcomes if o.channel == channel), None)
    if outcome is None:
        row.failed = f"the analyser does not compare {channel}: {report.why or '; '.join(report.skipped)}"
        return
    row.rmse, row.before, row.floor = outcome.rmse.get("after"), outcome.rmse.get("before"), outcome.floor
    right = {*(line for effect in real.expert.effects for line in effect.split("|")), *real.expert.also}
    row.false_names = [
        f.effect
        for f in report.findings
        if f.status == NAMED and (f.discovery.confidence or 0.0) > SURE and f.effect not in right
    ]
    row.regression = regress(
        real.expert,
        _stretches(report.data, channel, [m for m in report.data.members if not m.held_out]),
        _stretches(report.data, channel, [m for m in report.data.members if m.held_out]),
    )
    expected = expected_of(real.expert, row.regression)
    row.named = {effect: _is_named(effect, report.findings, report.left_out) for effect in expected}


def expected_of(expert: Expert, found: Regression) -> list[str]:
    """Effects that the analyser should name, each once: where a term of the expert's regression differs significantly
    from zero.
    """
    significant = np.abs(found.values) > criteria.TOLD * found.std
    return list(dict.fromkeys(t.effect for t, sure in zip(expert.terms, significant, strict=True) if sure and t.effect))


def _described(finding: Finding) -> str:
    sure = finding.discovery.confidence
    text = f"`{finding.effect}`" if finding.effect in LIBRARY else finding.name
    if finding.effect not in LIBRARY and finding.discovery.equation:
        text += f" ({finding.discovery.equation})"
    return f"{text}: {finding.status}" + ("" if sure is None else f", {sure:.2f}")


def _is_named(effects: str, findings: Sequence[Finding], left_out: Sequence[LeftOut]) -> bool:
    return any(_one_is_named(effect, findings, left_out) for effect in effects.split("|"))


def _one_is_named(effect: str, findings: Sequence[Finding], left_out: Sequence[LeftOut]) -> bool:
    if effect.startswith(AUXILIARY):
        return any(effect in made_of(f) for f in findings)
    if effect in LIBRARY and LIBRARY[effect].nominal:
        return any(row.effect == effect and row.outcome == NAMED for row in left_out)
    return any(f.effect == effect and f.status == NAMED for f in findings)


def _stretches(data: Dataset, channel: str, members: Sequence[Member]) -> list[Stretch]:
    """The samples of some recordings that the analyser compares, no others."""
    out = []
    for part in prepared_members(data, {m.index: m for m in members}):
        if channel not in part.measured:
            continue
        side = compared(part, channel)
        piece = data.parts[int(part.frame.recording[0])]
        first = 0 if piece.rows is None else piece.rows[0]
        rows = np.flatnonzero(side.counts)
        out.append(Stretch(piece.recording, rows + first, side.measured[rows]))
    return out
