"""The page itself: tables and figures in one HTML file that needs nothing else."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from bench.identification.identify import Identification
from bench.identification.report import figures
from bench.identification.report.opening import MEANING, equations, opening
from bench.identification.report.stems import stems
from bench.identification.summary import SYMBOL_TERMS, doubtful, parameters, sensitivities
from bench.identification.validation import PAPER_TABLE, table
from bench.simulation import TERM_COUNT, basis
from bench.simulation.polynomial import TERM_NAMES
from bench.typeset import engineering, figure, symbol
from bench.whole import write_whole

STYLE = """
body{font:15px/1.5 system-ui,sans-serif;max-width:1080px;margin:2em auto;padding:0 1em;color:#1b1b1b}
table{border-collapse:collapse;margin:.6em 0}td,th{padding:.2em .7em;border-bottom:1px solid #ddd;text-align:right}
th{background:#f3f5f8}td:first-child,th:first-child{text-align:left}img{max-width:100%}
figure{margin:1em 0}figcaption{color:#555;font-size:90%}.verdict{font-size:115%;border-left:.35em solid #00519e;
padding-left:1em}.verdict p{margin:.3em 0}.verdict p:first-child{font-weight:600}.equation{font-size:110%}
math{font-size:110%}dt{float:left;clear:left;min-width:4em}dd{margin-left:5em}.wide{overflow-x:auto}
"""
MODELS = (("refined", "refined"), ("paper", "paper's method"), ("bound", "bound"))


def html_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of plain texts as HTML, with its own horizontal scrolling."""
    head = "".join(f"<th>{html.escape(h)}</th>" for h in headings)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(c)}</td>" for c in row) + "</tr>" for row in rows)
    return f"<div class=wide><table><tr>{head}</tr>{body}</table></div>"


def _figure(uri: str, caption: str) -> str:
    text = html.escape(caption)
    link = f'<a download="figure.png" href="{uri}">Save the figure</a>'
    return f'<figure><img src="{uri}" alt="{text}"><figcaption>{text} {link}</figcaption></figure>'


def _errors(found: Identification) -> str:
    rows = []
    for title, directions in table(found.scores).items():
        for direction, models in directions.items():
            for quantity, index in (("rmse", 0), ("mae", 1)):
                cells = [figure(1e6 * models[m][quantity], ".2f") for m, _ in MODELS]
                published = f"{1e6 * PAPER_TABLE[title][direction][index]:.1f}"
                rows.append(
                    [title, direction, quantity.upper(), str(int(models["bound"]["recordings"])), *cells, published]
                )
    headings = ["recordings", "direction", "µrad", "number", *(t for _, t in MODELS), "the paper, on its bench"]
    return html_table(headings, rows)


def _parameters(found: Identification) -> str:
    doubts, rows = doubtful(found), []
    for key, p in parameters(found).items():
        value, std, unit = engineering(p.value, p.std, p.unit)
        cells = [MEANING[key], value, std, unit, SYMBOL_TERMS[key], doubts.get(key, "")]
        rows.append(
            f"<tr><td>{symbol(key)}</td>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>"
        )
    if not rows:
        return "<p>No recording determines any of them.</p>"
    names = ("", "what it is", "value", "±", "unit", "term", "doubt")
    head = "".join(f"<th>{name}</th>" for name in names)
    return f"<div class=wide><table><tr>{head}</tr>{''.join(rows)}</table></div>"


def _proposals(found: Identification) -> str:
    rows = [
        [str(p.order), f"{1e6 * p.amplitude:.3f}", f"{100 * p.share:.0f} %", p.part, "yes" if p.used else "no"]
        for p in found.proposals
    ]
    if not rows:
        return "<p>No order stands out of the noise in many recordings.</p>"
    return html_table(["order", "median amplitude, µrad", "stands out in", "part", "in the model"], rows)


def _harmonics(found: Identification) -> str:
    rows = []
    for direction, result in found.refined.items():
        centre = result.design.inputs.mean(axis=0)
        x, fourier = basis(centre[0], centre[1], centre[2]), result.fourier
        for k, order in enumerate(fourier.orders):
            cells = [direction, f"{order:g}", f"{1e6 * (fourier.amplitude[k] @ x):.3f}", "–"]
            cells += [f"{fourier.phase[k] @ x:.4f}", "–"]
            if fourier.covariance is not None:
                joint = fourier.covariance[k]
                for column, block in ((3, joint[:TERM_COUNT, :TERM_COUNT]), (5, joint[TERM_COUNT:, TERM_COUNT:])):
                    spread = float(np.sqrt(max(x @ block @ x, 0.0)))
                    cells[column] = f"{1e6 * spread:.3f}" if column == 3 else f"{spread:.4f}"
            rows.append(cells)
    return html_table(["direction", "order", "amplitude, µrad", "±", "phase, rad", "±"], rows)


def _sensitivities(found: Identification) -> str:
    rows = []
    for direction, names in sensitivities(found).items():
        for name, unit in (("A", 1e6), ("phi", 1.0), ("a0", 1e6)):
            cells = [figure(unit * names[name][term], ".3g") for term in TERM_NAMES]
            rows.append([f"{direction} {name} ({'µrad' if unit > 1 else 'rad'})", *cells])
    return html_table(["change of the standardised parameter", *TERM_NAMES], rows) if rows else "<p>Not determined.</p>"


def _list(items: Iterable[str]) -> str:
    rows = "".join(f"<li>{html.escape(item)}</li>" for item in items)
    return f"<ul>{rows}</ul>" if rows else "<p>Nothing.</p>"


def write_report(found: Identification, folder: Path, since_last: Sequence[str] = ()) -> Path:
    """Write ``report.html`` into ``folder`` (made where it is missing) and return its path.

    ``since_last`` says in sentences what changed since the last campaign of the same gearbox.
    """
    folder.mkdir(parents=True, exist_ok=True)
    spectrum = stems(found)
    parts = [
        opening(found, since_last),
        "" if spectrum is None else _figure(*spectrum),
        "<h2>Equations</h2>",
        equations(),
        "<h2>Errors of the models</h2>",
        "<p>Mean over recordings, mean of the measurement removed, a₀ left out, ripple of the load motor notched. "
        "The bound is the Fourier series fitted to each recording itself.</p>",
        _errors(found),
    ]
    example = figures.validation_example(found)
    if example is not None:
        parts += ["<h2>Validation example</h2>", _figure(*example)]
    polar = figures.polar(found)
    if polar is not None:
        parts += ["<h2>Transmission error over one revolution</h2>", _figure(*polar)]
    for heading, uri, caption in figures.influences(found):
        parts += [f"<h2>{heading}</h2>", _figure(uri, caption)]
    leak = figures.leakage(found)
    if leak is not None:
        parts += ["<h2>Why a joint fit</h2>", _figure(*leak)]
    parts += [
        "<h2>Orders that stand out</h2>",
        _proposals(found),
        "<h2>Friction, heat balance, load side</h2>",
        _parameters(found),
        "<h2>Orders of the refined model at the mean of the inputs</h2>",
        _harmonics(found),
        "<h2>Sensitivities: change that doubles the error (mean over the orders)</h2>",
        _sensitivities(found),
        "<h2>Not determined by these recordings</h2>",
        _list(found.sentences),
        "<h2>Left out</h2>",
        _list(s.why for s in found.skipped),
    ]
    title = f"Identification of {html.escape(found.folder.name)}"
    page = (
        f"<!doctype html><html lang=en><meta charset=utf-8><title>{title}</title><style>{STYLE}</style>"
        f"<meta name=viewport content='width=device-width,initial-scale=1'><h1>{title}</h1>{''.join(parts)}</html>"
    )
    path = folder / "report.html"
    write_whole(path, page)
    return path
