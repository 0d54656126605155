"""The report for people: one self-contained page, the verdict first, then each finding with a plot before and after."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

from bench.mismatch.findings import Finding
from bench.mismatch.plots import UNITS, plot
from bench.simulation.terms import LIBRARY

if TYPE_CHECKING:
    from bench.mismatch.evaluate import Scores
    from bench.mismatch.run import Report

_STYLE = """
:root{color-scheme:light dark;--ink:#1d2126;--dim:#5c6670;--paper:#fff;--line:#d8dde2;--box:#f4f6f8;--good:#1a7f45;
--bad:#b3420f;--open:#7a5a00}
@media(prefers-color-scheme:dark){:root{--ink:#e3e7eb;--dim:#9aa5af;--paper:#14171a;--line:#343b42;--box:#1e2327;
--good:#5fc98b;--bad:#f08a57;--open:#e0bb4e}}
*{box-sizing:border-box}body{font:16px/1.5 system-ui,sans-serif;max-width:58rem;margin:0 auto;padding:1.5rem 1rem 3rem;
color:var(--ink);background:var(--paper)}
h1{font-size:1.1rem;font-weight:600;color:var(--dim);margin:0 0 .6rem}h2{font-size:1.15rem;margin:0}
h3{font-size:.8rem;text-transform:uppercase;letter-spacing:.05em;color:var(--dim);margin:1.1rem 0 .3rem}
.verdict{font-size:1.3rem;line-height:1.4;border-left:.35rem solid var(--tone);padding:.2rem 0 .2rem 1rem;
margin:0 0 1.6rem}
.verdict b{color:var(--tone)}.match{--tone:var(--good)}.mismatch{--tone:var(--bad)}.undetermined{--tone:var(--open)}
article{border:1px solid var(--line);border-radius:.5rem;padding:1.1rem 1.3rem;margin:1.4rem 0}
.head{display:flex;flex-wrap:wrap;gap:.6rem;align-items:baseline}.tag{font-size:.8rem;border:1px solid currentColor;
border-radius:1rem;padding:0 .6rem;white-space:nowrap}.named{color:var(--good)}.ambiguous{color:var(--open)}
.unknown{color:var(--bad)}.dim{color:var(--dim)}p{margin:.4rem 0}table{border-collapse:collapse;font-size:.92rem}
td,th{border-bottom:1px solid var(--line);padding:.25rem .9rem .25rem 0;text-align:left;vertical-align:top}
th{font-weight:600;color:var(--dim)}td.n{font-variant-numeric:tabular-nums;text-align:right}
code{font:.95em ui-monospace,monospace;background:var(--box);padding:.15rem .45rem;border-radius:.25rem;
overflow-wrap:anywhere}svg{max-width:100%;height:auto;color:var(--ink);margin:.5rem 0}
ul{margin:.3rem 0;padding-left:1.2rem}
.wide{overflow-x:auto}
"""
_STATUS = {
    "named": "named",
    "ambiguous": "ambiguous: not told from an alternative",
    "unknown": "unknown: no term of the library explains it",
}


def sentence(report: Report) -> str:
    """The verdict in one sentence."""
    if report.verdict == "undetermined":
        return f"Undetermined: {report.why}."
    if report.verdict == "match":
        return "Match: on recordings held out, the calibrated simulation leaves no more than the noise."
    named = [f for f in report.findings if f.status == "named"]
    others = [f for f in report.findings if f.status != "named"]
    parts = [f"{f.name} ({f.channel.replace('_', ' ')}: {f.location.text})" for f in named]
    parts += [
        f"{f.name}, not told from {_in_words(f.alternatives[0]['effect'])}"
        if f.status == "ambiguous" and f.alternatives
        else f"{f.name} in {f.channel.replace('_', ' ')} ({f.location.text})"
        for f in others
    ]
    return "Mismatch: the simulation leaves out " + "; ".join(parts) + "."


def _in_words(effect: str) -> str:
    return LIBRARY[effect].name if effect in LIBRARY else effect


def page(report: Report) -> str:
    """The page as HTML, plots inside."""
    whole = sentence(report)
    verdict, _, rest = whole.partition(":")
    members = report.data.members
    held = sum(m.held_out for m in members)
    body = [
        "<h1>Simulation against recordings</h1>",
        f'<p class="verdict {report.verdict}"><b>{_e(verdict)}:</b>{_e(rest)}</p>',
        _channels(report),
        *(_finding(finding, report) for finding in report.findings),
        _left_out(report),
        _list("Not used", [f"{file}: {why}" for file, why in report.data.rejected]),
        _list("Notes", [*report.data.notes, *report.skipped]),
        f'<p class="dim">{len(members)} recordings or blocks, {held} of them held out: whole operating points, '
        "validation points always. Nothing that is scored here was fitted. Values of the improved simulation stand in "
        "<code>model.json</code>, everything on this page in <code>report.json</code>.</p>",
    ]
    head = (
        '<meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">'
        f"<title>{_e(verdict)}: simulation against recordings</title><style>{_STYLE}</style>"
    )
    return f'<!doctype html><html lang="en"><head>{head}</head><body>{"".join(body)}</body></html>\n'


def _e(text: object) -> str:
    return html.escape(str(text))


def _channels(report: Report) -> str:
    if not report.scores:
        return ""
    rows = []
    for channel, s in report.scores.items():
        unit, scale = UNITS[channel]
        values = "".join(f'<td class="n">{scale * v:.4g}</td>' for v in (s.floor, s.before, s.after))
        ratio = s.after / s.floor
        rows.append(
            f'<tr><td>{_e(channel.replace("_", " "))}</td>{values}<td>{unit}</td><td class="n">{ratio:.2f}</td></tr>'
        )
    return (
        '<h3>What is left on held-out recordings, root mean square per sample</h3><div class="wide"><table><tr>'
        "<th>channel<th>noise<th>given simulation<th>improved<th>unit<th>improved / noise</tr>"
        + "".join(rows)
        + "</table></div>"
    )


def _finding(finding: Finding, report: Report) -> str:
    also = f", also in {_e(', '.join(c.replace('_', ' ') for c in finding.also_in))}" if finding.also_in else ""
    score = report.scores.get(finding.channel)
    drawing = plot(finding, report.analysis, report.data, score) if report.analysis is not None else ""
    parts = [
        f'<div class="head"><h2>{_e(_capital(finding.name))}</h2>'
        f'<span class="tag {finding.status}">{_STATUS[finding.status]}</span>'
        f'<span class="dim">confidence {finding.confidence:.2f}</span></div>',
        f"<p>In the <b>{_e(finding.channel.replace('_', ' '))}</b>{also}: {_e(finding.location.text)}.</p>",
        drawing,
        f"<h3>Equation</h3><p><code>{_e(finding.equation)}</code></p>",
        _parameters(finding.parameters),
        f"<h3>Evidence</h3><p>{_evidence(finding, score)}{_where(finding)}</p>",
        _alternatives(finding.alternatives),
        _next(finding.next_experiment),
    ]
    return f"<article>{''.join(parts)}</article>"


def _evidence(finding: Finding, score: Scores | None) -> str:
    unit, scale = UNITS[finding.channel]
    if finding.source is None and score is not None:
        left, noise = scale * score.after, scale * score.floor
        return f"Held-out residual {left:.4g} {unit}, noise {noise:.4g} {unit}; nothing takes it off."
    p = "below 1e-99" if finding.p_value < 1e-99 else f"{finding.p_value:.1e}"
    before, after = scale * finding.rmse_before, scale * finding.rmse_after
    share = 100.0 * finding.location.share_of_excess
    return (
        f"Held-out residual {before:.4g} {unit} without it, {after:.4g} {unit} with it: {share:.0f} % of the energy "
        f"above the noise; p {p} after all looks."
    )


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _where(finding: Finding) -> str:
    names = finding.location.recordings[:3]
    return f" Strongest in {_e(', '.join(names))}." if names else ""


def _parameters(parameters: list[dict[str, Any]]) -> str:
    if not parameters:
        return ""
    rows = "".join(
        f"<tr><td>{_e(p['symbol'])}</td><td>{p['value']:.4g} ± {p['std']:.2g}</td><td>{_e(p['unit'])}</td></tr>"
        for p in parameters[:12]
    )
    more = f'<p class="dim">and {len(parameters) - 12} more in report.json</p>' if len(parameters) > 12 else ""
    return f'<div class="wide"><table><tr><th>symbol<th>value<th>unit</tr>{rows}</table></div>{more}'


def _alternatives(alternatives: list[dict[str, Any]]) -> str:
    if not alternatives:
        return ""
    items = "".join(f"<li>{_e(_capital(_in_words(a['effect'])))}: {_e(a['why_not'])}.</li>" for a in alternatives)
    return f"<h3>Why not another</h3><ul>{items}</ul>"


def _next(proposed: dict[str, Any] | None) -> str:
    if not proposed:
        return ""
    return (
        f"<h3>Next experiment</h3><p>{_e(_capital(proposed['why']))}. <code>bench run {_e(proposed['file'])}</code></p>"
    )


def _left_out(report: Report) -> str:
    if not report.left_out:
        return ""
    rows = []
    for row in report.left_out:
        said = row.parameters or row.why or ", ".join(row.said) or "–"
        sure = "" if row.confidence is None else f" ({row.confidence:.2f})"
        rows.append(f"<tr><td>{_e(_capital(row.name))}</td><td>{_e(row.outcome)}{sure}</td><td>{_e(said)}</td></tr>")
    return (
        '<article><h2>Would it have been found?</h2><p class="dim">Each nominal term switched off in turn.</p>'
        '<div class="wide"><table><tr><th>term left out<th>answer (confidence)<th>said</tr>'
        + "".join(rows)
        + "</table></div></article>"
    )


def _list(title: str, items: list[str]) -> str:
    return f"<h3>{title}</h3><ul>{''.join(f'<li>{_e(i)}</li>' for i in items)}</ul>" if items else ""
