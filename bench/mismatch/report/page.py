"""The report for people: one self-contained page, the verdict first, then each finding with a plot without and with it.

A figure that could not be computed is told as such, with the reason.
"""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bench.mismatch.discovery import ChannelOutcome
from bench.mismatch.report import reasons
from bench.mismatch.report.figures import finite
from bench.mismatch.report.finding import Alternative, Finding, NextExperiment
from bench.mismatch.report.left_out import said
from bench.mismatch.report.opening import opening
from bench.mismatch.report.plots import LINEAR_UNITS, UNITS, plot
from bench.mismatch.report.report import Report
from bench.mismatch.report.style import STYLE
from bench.mismatch.report.symbols import equation, parameters
from bench.mismatch.report.verdict import in_words, kind_of_simulation
from bench.simulation.linear import in_metres

MOST_NAMES = 3
STATUS = {
    "named": "named",
    "ambiguous": "ambiguous: not distinguished from an alternative",
    "unknown": "unknown: no term of the library explains it",
}
LEAST_P = 1e-99
SCORES = {"as_given": "as given", "before": "recalibrated", "after": "improved"}
"""root mean squares of a channel, as the page calls them"""


def page(report: Report) -> str:
    """The page as HTML, plots inside."""
    verdict = report.sentence.partition(":")[0]
    members = report.data.members
    held = sum(m.held_out for m in members)
    scored = ""
    if report.outcomes:
        scored = (
            f", {held} of them held out: nothing that is scored on them was fitted to them"
            if held
            else ", none of them held out: what is scored was also fitted"
        )
    scores = [(_score(o, "before"), _score(o, "after")) for o in report.outcomes if report.findings]
    model = kind_of_simulation(scores, report.simulation.recalibrated)
    body = [
        "<h1>Simulation against recordings</h1>",
        opening(report),
        _compared(report),
        _channels(report),
        *(_finding(finding, report) for finding in report.findings),
        _left_out(report),
        _list("Not used", [f"{file}: {why}" for file, why in report.data.rejected]),
        _list("Notes", [*report.data.notes, *report.skipped, *(n for o in report.outcomes for n in o.notes)]),
        f'<p class="dim">{len(members)} recordings or blocks{_e(scored)}. <code>model.json</code> holds the {model}, '
        "<code>report.json</code> everything on this page.</p>",
    ]
    head = (
        '<meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{_e(verdict)}: simulation against recordings</title><style>{STYLE}</style>"
    )
    content = "".join(body)
    if report.data.linear:
        content = in_metres(content)
    return f'<!doctype html><html lang="en"><head>{head}</head><body>{content}</body></html>\n'


def _e(text: object) -> str:
    return html.escape(str(text))


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _units(report: Report) -> Mapping[str, tuple[str, float]]:
    return LINEAR_UNITS if report.data.linear else UNITS


def _missing(why: str) -> str:
    return f'<span class="dim">not computed, because {_e(why)}</span>'


def _compared(report: Report) -> str:
    simulation = report.simulation
    of = f"{simulation.kind} simulation" + (f" of {simulation.file}" if simulation.file else "")
    anew = ", ".join(simulation.recalibrated) or "nothing"
    return f'<p class="dim">Compared: {_e(of)}. Calibrated anew on the recordings: {_e(anew)}.</p>'


def _channels(report: Report) -> str:
    if not report.outcomes:
        return ""
    names = [n for n in SCORES if any(_score(o, n) is not None for o in report.outcomes)]
    rows = "".join(_channel(outcome, names, report) for outcome in report.outcomes)
    head = "".join(f"<th>{SCORES[n]}" for n in names)
    missing = {
        SCORES[n]: reasons.of_score(o, n, report.simulation.kind)
        for n in SCORES
        if n not in names
        for o in report.outcomes
    }
    absent = "".join(f'<p class="dim">{_e(_capital(n))}: {_missing(why)}.</p>' for n, why in missing.items())
    return (
        '<h3>What is left on held-out recordings, root mean square per sample</h3><div class="wide"><table><tr>'
        f"<th>channel<th>noise{head}<th>unit<th>improved / noise<th>chance that noise looks so</tr>{rows}</table></div>"
        f"{absent}{_methods(report.outcomes)}"
    )


def _score(outcome: ChannelOutcome, name: str) -> float | None:
    held = finite(outcome.rmse.get(name))
    return finite(outcome.in_sample.get(name)) if held is None else held


def _channel(outcome: ChannelOutcome, names: Sequence[str], report: Report) -> str:
    unit, scale = _units(report)[outcome.channel]
    cells = [f"<td>{_e(_capital(in_words(outcome.channel)))}</td>", _cell(_with_std(outcome, scale))]
    for name in names:
        value = finite(outcome.rmse.get(name))
        why = reasons.of_score(outcome, name, report.simulation.kind)
        if value is None and (fitted := finite(outcome.in_sample.get(name))) is not None:
            cells.append(f'<td>{scale * fitted:.4g} <span class="dim">on what was fitted: {_e(why)}</span></td>')
        else:
            cells.append(f"<td>{_missing(why)}</td>" if value is None else _cell(f"{scale * value:.4g}"))
    cells.append(f"<td>{_e(unit)}</td>")
    after = finite(outcome.rmse.get("after"))
    ratio = None if after is None or outcome.floor <= 0.0 else after / outcome.floor
    cells.append(
        f"<td>{_missing(reasons.of_score(outcome, 'after', ''))}</td>" if ratio is None else _cell(f"{ratio:.2f}")
    )
    p = None if outcome.structure is None else finite(outcome.structure.p_value)
    cells.append(f"<td>{_missing(reasons.NO_STRUCTURE)}</td>" if p is None else _cell(_chance(p)))
    return f"<tr>{''.join(cells)}</tr>"


def _with_std(outcome: ChannelOutcome, scale: float) -> str:
    std = finite(outcome.floor_std)
    return f"{scale * outcome.floor:.4g}" + ("" if std is None else f" ± {scale * std:.2g}")


def _methods(outcomes: Sequence[ChannelOutcome]) -> str:
    methods = []
    for o in outcomes:
        tested = f"; what is left: {o.structure.method}" if o.structure is not None else ""
        methods.append(f"{_capital(in_words(o.channel))}: noise from {o.floor_method}{tested}")
    lines = "".join(f'<p class="dim">{_e(line)}.</p>' for line in methods)
    return f'<details><summary class="dim">How noise and what is left were judged</summary>{lines}</details>'


def _cell(text: str) -> str:
    return f'<td class="n">{_e(text)}</td>'


def _chance(p: float) -> str:
    return "below 1e-99" if p < LEAST_P else f"{p:.2g}"


def _finding(finding: Finding, report: Report) -> str:
    also = f", also in {_e(', '.join(map(in_words, finding.also_in)))}" if finding.also_in else ""
    sure = finite(finding.discovery.confidence)
    confidence = _missing(reasons.of_confidence(finding)) if sure is None else f"{sure:.2f}"
    words = finding.discovery.words
    more = f" That is: {_e(words)}." if words and words != finding.name else ""
    parts = [
        f'<div class="head"><h2>{_e(_capital(finding.name))}</h2>'
        f'<span class="tag {_e(finding.status)}">{_e(STATUS.get(finding.status, finding.status))}</span>'
        f'<span class="dim">confidence {confidence}</span></div>',
        f"<p>In the <b>{_e(in_words(finding.channel))}</b>{also}: {_e(finding.text)}.{more}</p>",
        _drawn(plot(finding, report.data), finding.name),
        f"<h3>Equation</h3>{equation(finding)}",
        parameters(finding, report.data.linear),
        _table(finding.discovery.table),
        f"<h3>Evidence</h3><p>{_evidence(finding, report)}{_where(finding)}</p>",
        _alternatives(finding, report),
        _next(finding.next_experiment),
    ]
    return f"<article>{''.join(parts)}</article>"


def _drawn(svg: str, name: str) -> str:
    """A plot with a link that saves it as it stands; in a file there is no page whose colour it could take."""
    if not svg:
        return ""
    alone = base64.b64encode(svg.replace("currentColor", "#1d2126").encode()).decode("ascii")
    link = f'<a class="dim" download="{_e(name)}.svg" href="data:image/svg+xml;base64,{alone}">Save the figure</a>'
    return f"<figure>{svg}<figcaption>{link}</figcaption></figure>"


def _evidence(finding: Finding, report: Report) -> str:
    unit, scale = _units(report)[finding.channel]
    of = "Held-out residual" if finding.held_out else "Residual of what was fitted (no recording could be held out)"
    sizes = []
    for value, words in ((finding.before, "without it"), (finding.after, "with it")):
        text = _missing(reasons.of_rmse(finding)) if value is None else f"{scale * value:.4g} {_e(unit)}"
        sizes.append(f"{text} {words}")
    share = finding.share_of_excess
    part = (
        f"share of the energy above the noise {_missing(reasons.of_share(finding))}"
        if share is None
        else f"{100.0 * share:.0f} % of the energy above the noise"
    )
    unsure = finding.against
    against = " They are predicted better without it, so its confidence is halved." if unsure else ""
    p = finite(finding.discovery.p_value)
    chance = _missing(reasons.NO_SURROGATES) if p is None else f"{_chance(p)} against surrogates of this folder"
    return f"{of}: {', '.join(sizes)}; {part}; p {chance}.{against}"


def _where(finding: Finding) -> str:
    names = finding.location.recordings
    if not names:
        return ""
    more = len(names) - MOST_NAMES
    listed = ", ".join(names[:MOST_NAMES]) + (f" and {more} more" if more > 0 else "")
    return f" Strongest in {_e(listed)}."


def _table(table: Sequence[Mapping[str, Any]]) -> str:
    """A finding's own table, such as that of the orders: a column a key."""
    if not table:
        return ""
    keys = list(dict.fromkeys(key for row in table for key in row))
    head = "".join(f"<th>{_e(key.replace('_', ' '))}" for key in keys)
    rows = "".join("<tr>" + "".join(_cell(_formatted(row.get(key))) for key in keys) + "</tr>" for row in table)
    return f'<h3>Table</h3><div class="wide tall"><table><tr>{head}</tr>{rows}</table></div>'


def _formatted(value: Any) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return f"{value:.4g}" if np.isfinite(value) else "–"
    if isinstance(value, list | tuple):
        return ", ".join(map(_formatted, value))
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {_formatted(entry)}" for key, entry in value.items())
    return str(value)


def _alternatives(finding: Finding, report: Report) -> str:
    if not finding.alternatives:
        return ""
    items = "".join(f"<li>{_alternative(a, finding, report)}</li>" for a in finding.alternatives)
    return f"<h3>Why not another</h3><ul>{items}</ul>"


def _alternative(alternative: Alternative, finding: Finding, report: Report) -> str:
    unit, scale = _units(report)[finding.channel]
    left = (
        _missing(reasons.NO_ROWS_COMPARED) if alternative.rmse is None else f"{scale * alternative.rmse:.4g} {_e(unit)}"
    )
    of = "held-out residual" if finding.held_out else "residual of what was fitted"
    return f"{_e(_capital(alternative.name))}: {_e(alternative.why_not)}; {of} {left}."


def _next(proposed: NextExperiment | None) -> str:
    if proposed is None:
        return ""
    text = f"{_e(_capital(proposed.why))}. <code>bench run {_e(proposed.file)}</code>"
    return f"<h3>Next experiment</h3><p>{text}</p>"


def _left_out(report: Report) -> str:
    if not report.left_out:
        return ""
    rows = []
    for row in report.left_out:
        sure = "" if row.confidence is None else f" ({row.confidence:.2f})"
        answer = f"{_e(row.outcome)}{sure}"
        rows.append(f"<tr><td>{_e(_capital(row.name))}</td><td>{answer}</td><td>{_e(said(row))}</td></tr>")
    return (
        '<article><h2>Would it have been found?</h2><p class="dim">Each nominal term switched off in turn.</p>'
        '<div class="wide"><table><tr><th>term left out<th>answer (confidence)<th>said</tr>'
        + "".join(rows)
        + "</table></div></article>"
    )


def _list(title: str, items: Sequence[str]) -> str:
    return f"<h3>{title}</h3><ul>{''.join(f'<li>{_e(i)}</li>' for i in items)}</ul>" if items else ""
