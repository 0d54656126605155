"""What the page begins with: a verdict in three lines, and one picture of every channel against its noise."""

from __future__ import annotations

import html
import math

from bench.mismatch.discovery import AMBIGUOUS, UNKNOWN, ChannelOutcome
from bench.mismatch.report.figures import finite
from bench.mismatch.report.report import Report
from bench.mismatch.report.verdict import in_words

BEFORE, AFTER = "#e0702d", "#2f7ed8"
_WIDTH, _ROW, _LEFT, _TOP = 720, 46, 170, 26


def opening(report: Report) -> str:
    """Three lines and the picture, as HTML."""
    verdict, _, rest = report.sentence.partition(":")
    lines = (_left(report), _sure(report))
    more = "".join(f"<p>{html.escape(line)}</p>" for line in lines if line)
    head = f"<p><b>{html.escape(verdict)}:</b>{html.escape(rest)}</p>"
    return f'<div class="verdict {report.verdict}">{head}{more}</div>{picture(report)}'


def _ratio(outcome: ChannelOutcome, score: str) -> float | None:
    """Root mean square on held-out recordings over the noise; None where one of them is not known."""
    value = finite(outcome.rmse.get(score))
    return None if value is None or not outcome.floor > 0.0 else value / outcome.floor


def _left(report: Report) -> str:
    """What is left on held-out recordings, in multiples of the noise, without and with what was found."""
    parts = []
    for outcome in report.outcomes:
        before, after = _ratio(outcome, "before"), _ratio(outcome, "after")
        if after is None:
            continue
        text = f"{after:.2f} times the noise"
        if before is not None and f"{before:.2f}" != f"{after:.2f}":
            text = f"{before:.2f} → {text}"
        parts.append(f"{in_words(outcome.channel)} {text}")
    return f"Left on recordings held out: {'; '.join(parts)}." if parts else ""


def _sure(report: Report) -> str:
    """How many findings are sure, and what would tell more."""
    if not report.findings:
        return ""
    unsure = sum(f.status == AMBIGUOUS for f in report.findings)
    unknown = sum(f.status == UNKNOWN for f in report.findings)
    named = len(report.findings) - unsure - unknown
    counts = ((named, "named"), (unsure, "ambiguous"), (unknown, "unknown"))
    counted = [f"{count} {word}" for count, word in counts if count]
    experiment = next((f.next_experiment for f in report.findings if f.next_experiment is not None), None)
    more = "" if experiment is None else f" Next: bench run {experiment.file}."
    return f"Findings: {', '.join(counted)}.{more}"


def picture(report: Report) -> str:
    """A bar a channel, without and with what was found, over its noise; SVG. Empty where nothing was held out."""
    rows = [(o, _ratio(o, "before"), _ratio(o, "after")) for o in report.outcomes]
    known = [value for _, *values in rows for value in values if value is not None]
    if not known:
        return ""
    shown = [row for row in rows if row[1] is not None or row[2] is not None]
    low, high = math.log(min(0.8, *known)), math.log(1.25 * max(1.0, *known))

    def x(value: float) -> float:
        return _LEFT + (math.log(value) - low) / (high - low) * (_WIDTH - _LEFT - 60)

    out = []
    for number, (outcome, *values) in enumerate(shown):
        top = _TOP + number * _ROW
        out.append(_text(_LEFT - 8, top + 20, in_words(outcome.channel), "end"))
        for part, (value, colour) in enumerate(zip(values, (BEFORE, AFTER), strict=True)):
            if value is not None:
                y = top + 17 * part
                bar = f'<rect x="{x(math.exp(low)):.1f}" y="{y}" width="{x(value) - x(math.exp(low)):.1f}" height="14"'
                out += [f'{bar} fill="{colour}"/>', _text(x(value) + 5, y + 12, f"{value:.3g}", "start")]
    bottom = _TOP + len(shown) * _ROW
    line = f'<line x1="{x(1.0):.1f}" x2="{x(1.0):.1f}" y1="{_TOP - 6}" y2="{bottom}" stroke="currentColor"'
    out += [f'{line} stroke-dasharray="5 4"/>', _text(x(1.0), _TOP - 10, "noise", "middle")]
    label = "Root mean square on recordings held out, in multiples of the noise, logarithmic"
    box = f'viewBox="0 0 {_WIDTH} {bottom + 24}" role="img" aria-label="{label}" style="font:13px sans-serif"'
    key = f"{label}: orange recalibrated, blue with what was found."
    return f'<figure><svg {box}>{"".join(out)}</svg><figcaption class="dim">{key}</figcaption></figure>'


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="currentColor">{html.escape(text)}</text>'
