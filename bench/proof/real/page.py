"""``docs/real.md``: what the analyser and an expert say of recordings that others made."""

from __future__ import annotations

import re
from collections.abc import Sequence

from bench.mismatch import criteria
from bench.mismatch.report.left_out import NOT_ASKED
from bench.mismatch.report.left_out import table as left_out_table
from bench.proof.real.examine import SURE, Examined
from bench.proof.real.sets import RealSet

_NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d+)?(e[+-]?\d+)?")
_ABOUT = f"""# Recordings of others

This page shows public recordings of other people's machines. Each set is analysed in two ways on the same
samples. The **expert's** regression was written by hand: its terms were chosen with the recordings that may be
fitted, and are listed below with their values. The **analyser** is `bench mismatch`, which gets nothing but the
mapping of the import. The held-out RMSE is per sample, for both over the same samples of the same recordings,
which were not used in any fit.

- *named*: terms of the expert that the analyser names. A term that the nominal simulation contains (inertia,
  Coulomb and viscous friction) counts if the analyser would have found it without the simulation having it
  (leave-one-out). A term is not counted if the expert's regression does not distinguish its value from zero:
  less than {criteria.TOLD:g} standard deviations.
- *false names*: findings with a name and a confidence above {SURE:g} that are not among the expert's terms.
- Sets marked *apart* were first analysed when the method was finished, and nothing in the analyser was changed
  for them. They are analysed again whenever this page is made. As their results are known now, they are not
  apart for later changes.
- *First sight* is the result when a set was imported and analysed for the first time, before anything was
  changed. All sets that are neither apart nor in that table were known while the method was developed.

The recordings are not part of this project. Download the files listed below, for each set into a folder of its
name, and make this page with

```sh
bench prove --real FOLDER --table docs/real.md
```
"""
_HEADS = (
    "set",
    "what",
    "named",
    "false names",
    "RMSE of the expert",
    "of the analyser",
    "ratio",
    "nothing found",
    "noise",
)
_HEAD = "| " + " | ".join(_HEADS) + " |"
_LINE = "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"


def page(rows: Sequence[Examined], blocks: str = "") -> str:
    """The whole page as Markdown; ``blocks``: how, from what and when, a sentence."""
    lines = [_ABOUT, _HEAD, _LINE]
    lines += [_row(row) for row in rows]
    lines += ["", *_totals(rows), *_first_sight(rows)]
    lines += ["", blocks] if blocks else []
    for row in rows:
        lines += ["", *_section(row)]
    return "\n".join(lines) + "\n"


def _row(row: Examined) -> str:
    name = f"[{row.real.name}](#{row.real.name})" + (" (apart)" if row.real.apart else "")
    if row.missing or row.failed:
        return f"| {name} | {row.real.title} | {'files are missing' if row.missing else 'failed'} |" + " – |" * 6
    assert row.regression is not None
    named = f"{sum(row.named.values())} of {len(row.named)}"
    false = ", ".join(f"`{false_name}`" for false_name in row.false_names) or "none"
    share = "–" if row.rmse is None else f"{row.rmse / row.regression.held_out:.2f}"
    cells = (named, false, _number(row.regression.held_out), _number(row.rmse), share)
    return f"| {name} | {row.real.title} | " + " | ".join((*cells, _number(row.before), _number(row.floor))) + " |"


def _totals(rows: Sequence[Examined]) -> list[str]:
    done = [row for row in rows if row.regression is not None]
    if not done:
        return ["No set was examined."]
    named = sum(all(row.named.values()) for row in done)
    near = sum(_near(row) for row in done)
    false = sum(len(row.false_names) for row in done)
    return [
        f"Of {len(done)} sets: all of the expert's terms named in {named}, held-out RMSE within 10 % of the expert's "
        f"(or below) in {near}, false names {false}."
    ]


def _first_sight(rows: Sequence[Examined]) -> list[str]:
    """What came out of sets when they were seen for the first time, where that was written down."""
    seen = [(row.real.name, row.real.first) for row in rows if row.real.first is not None]
    if not seen:
        return []
    lines = ["", "First sight, before anything was changed:", ""]
    lines += [
        "| set | commit | what came out | ratio | changed since with it in view |",
        "| --- | --- | --- | --- | --- |",
    ]
    for name, sight in seen:
        ratio = "–" if sight.ratio is None else f"{sight.ratio:.2f}"
        lines.append(f"| [{name}](#{name}) | `{sight.commit}`, {sight.date} | {sight.said} | {ratio} | {sight.since} |")
    return lines


def _near(row: Examined) -> bool:
    """Whether the analyser predicts as well as the expert, within a tenth."""
    return row.regression is not None and row.rmse is not None and row.rmse <= 1.1 * row.regression.held_out


def _section(row: Examined) -> list[str]:
    real = row.real
    lines = [f"## {real.name}", "", f"{_upper(real.title)}. {real.source}. Licence: {real.licence}.", ""]
    lines += [f"- `{file.name}`: {file.at}, SHA-256 `{file.sha256}`" for file in real.files]
    lines.append("")
    if row.missing:
        return [*lines, "Not examined: files are missing.", *(f"- {why}" for why in row.missing)]
    if row.failed:
        return [*lines, f"Failed: {row.failed}"]
    lines += [f"The expert: {real.expert.how}.", "", *_expert(row), "", f"The analyser says {row.verdict}:", ""]
    lines += [f"- {one}" for one in row.said] or ["- nothing is missing"]
    absent = [effect for effect, named in row.named.items() if not named]
    if absent:
        lines += ["", "Not found: " + ", ".join(f"`{one}`" for one in absent) + "."]
    examined = [one for one in row.left_out if one.outcome != NOT_ASKED and one.channel == real.expert.channel]
    if examined:
        lines += ["", left_out_table(examined)]
    lines += ["", *_notes(row.notes)] if row.notes else []
    lines += ["", real.remark] if real.remark else []
    return lines


def _notes(notes: Sequence[str]) -> list[str]:
    """What the import said; of sentences that differ in their numbers the first."""
    alike: dict[str, list[str]] = {}
    for note in notes:
        alike.setdefault(_NUMBER.sub("…", note), []).append(note)
    more = " ({} more recordings: the same with other numbers)".format
    return [f"At import: {group[0]}" + (more(len(group) - 1) if len(group) > 1 else "") for group in alike.values()]


def _expert(row: Examined) -> list[str]:
    assert row.regression is not None
    real: RealSet = row.real
    lines = ["| term | column | value | unit | the analyser's id |", "| --- | --- | --- | --- | --- |"]
    for term, value, std in zip(real.expert.terms, row.regression.values, row.regression.std, strict=True):
        effect = f"`{term.effect}`" if term.effect else "–"
        lines.append(f"| {term.symbol} | `{term.column}` | {value:.4g} ± {std:.1g} | {term.unit} | {effect} |")
    return lines


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:]


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"
