"""The report for people: one self-contained page, the verdict first, then each finding with a plot before and after."""

from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING

import numpy as np

from bench.mismatch.findings import Finding
from bench.simulation.terms import CHANNEL_UNITS

if TYPE_CHECKING:
    from bench.mismatch.run import Report

_STYLE = """
body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}
h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2.2rem}table{border-collapse:collapse;margin:.6rem 0}
td,th{border:1px solid #ccc;padding:.25rem .6rem;text-align:left}code{background:#f3f3f3;padding:.1rem .3rem}
img{max-width:100%}.verdict{font-size:1.25rem;padding:.8rem 1rem;border-left:.4rem solid #00519e;background:#eef4fa}
@media(prefers-color-scheme:dark){body{color:#ddd;background:#181818}code{background:#2a2a2a}.verdict{background:#1e2a36}}"""


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
        f"{f.name}, not told from {f.alternatives[0]['effect']}"
        if f.status == "ambiguous" and f.alternatives
        else f"{f.name} in {f.channel.replace('_', ' ')} ({f.location.text})"
        for f in others
    ]
    return "Mismatch: the simulation leaves out " + "; ".join(parts) + "."


def page(report: Report) -> str:
    """The page as HTML, plots inside."""
    rows = "".join(
        f"<tr><td>{c.replace('_', ' ')}</td><td>{CHANNEL_UNITS[c]}</td><td>{s.floor:.3g}</td><td>{s.before:.3g}</td>"
        f"<td>{s.after:.3g}</td><td>{s.after / s.floor:.3f}</td></tr>"
        for c, s in report.scores.items()
    )
    body = [
        f"<h1>Simulation and recordings: {html.escape(report.verdict)}</h1>",
        f"<p class=verdict>{html.escape(sentence(report))}</p>",
        "<h2>Channels, root mean square per sample on held-out recordings</h2>"
        f"<table><tr><th>channel<th>unit<th>noise floor<th>before<th>after<th>after / floor</tr>{rows}</table>",
    ]
    for finding in report.findings:
        body.append(_finding(finding, report))
    if report.data.rejected:
        items = "".join(f"<li>{html.escape(file)}: {html.escape(why)}" for file, why in report.data.rejected)
        body.append(f"<h2>Not used</h2><ul>{items}</ul>")
    notes = [*report.data.notes, *report.skipped]
    if notes:
        body.append("<h2>Notes</h2><ul>" + "".join(f"<li>{html.escape(n)}" for n in notes) + "</ul>")
    held = sum(m.held_out for m in report.data.members)
    body.append(
        f"<p>{len(report.data.members)} recordings, {held} held out (all validation points and whole operating points);"
        " nothing that is scored was fitted.</p>"
    )
    head = f"<meta charset=utf-8><title>Mismatch report</title><style>{_STYLE}</style>"
    return f"<!doctype html><html lang=en>{head}{''.join(body)}</html>\n"


def _finding(finding: Finding, report: Report) -> str:
    values = "".join(
        f"<tr><td>{html.escape(str(p['symbol']))}</td><td>{p['value']:.4g} ± {p['std']:.2g}</td>"
        f"<td>{html.escape(str(p['unit']))}</td></tr>"
        for p in finding.parameters[:12]
    )
    others = "".join(f"<li>{html.escape(a['effect'])}: {html.escape(a['why_not'])}" for a in finding.alternatives)
    more = ""
    if finding.next_experiment:
        why, file = finding.next_experiment["why"], finding.next_experiment["file"]
        more = f"<p>Next experiment: {html.escape(why)} (<code>{file}</code>)</p>"
    also = f", also in {', '.join(finding.also_in)}" if finding.also_in else ""
    return (
        f"<h2>{html.escape(finding.name)} <small>({finding.status}, confidence {finding.confidence:.2f})</small></h2>"
        f"<p>In {finding.channel.replace('_', ' ')}{also}; {html.escape(finding.location.text)}. Explains "
        f"{100 * finding.location.share_of_excess:.0f} % of the energy above the noise on held-out recordings, "
        f"p = {finding.p_value:.1e}.</p>"
        f"<p><code>{html.escape(finding.equation)}</code></p><table>{values}</table>{_plot(finding, report)}"
        f"{'<p>Alternatives:</p><ul>' + others + '</ul>' if others else ''}{more}"
    )


def _plot(finding: Finding, report: Report) -> str:
    """Residual before and after over the quantity the finding depends on."""
    from matplotlib.figure import Figure

    score = report.scores.get(finding.channel)
    if score is None or report.analysis is None:
        return ""
    if finding.channel == "transmission_error" and report.analysis.transmission is not None:
        frame = report.analysis.transmission.angle.frame
    else:
        frame = report.analysis.models[finding.channel].rows.frame
    rows = score.rows
    source = finding.source
    variables = getattr(getattr(source, "entry", None), "variables", ()) or getattr(source, "variables", ())
    x, label = np.mod(frame.theta, 2 * np.pi) * 180 / np.pi, "θ / deg"
    if "speed" in variables:
        x, label = np.degrees(np.abs(frame.velocity)), "speed / (deg/s)"
    elif "temperature" in variables:
        x, label = frame.temperature, "temperature / °C"
    elif {"torque", "torque_path"} & set(variables):
        x, label = frame.torque, "load torque / N·m"
    elif {"time", "transient"} & set(variables):
        x, label = frame.time / 3600.0, "time / h"
    elif "since_reversal" in variables:
        x, label = np.degrees(frame.reversal_travel), "distance since start or reversal / deg"
    figure = Figure(figsize=(8, 2.8), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    step = max(1, int(rows.sum() // 4000))
    chosen = np.flatnonzero(rows)[::step]
    for axis, residual, title in ((axes[0], score.residual_before, "before"), (axes[1], score.residual_after, "after")):
        axis.plot(x[chosen], residual[chosen], ".", ms=2, color="#00519e", alpha=0.5)
        axis.set_title(f"{title}, held-out recordings")
        axis.set_xlabel(label)
        axis.axhline(0.0, color="#888", lw=0.6)
    axes[0].set_ylabel(f"measured - simulated / {CHANNEL_UNITS[finding.channel]}")
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=90)
    coded = base64.b64encode(data.getvalue()).decode()
    return f'<img alt="residual before and after" src="data:image/png;base64,{coded}">'
