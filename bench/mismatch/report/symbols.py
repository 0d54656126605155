"""The equation of a finding, typeset, each of its symbols explained, and its values in units people use."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator

from bench.mismatch.report import reasons
from bench.mismatch.report.figures import finite
from bench.mismatch.report.finding import Finding
from bench.simulation.quantities import label as quantity_label
from bench.simulation.quantities import state_of
from bench.simulation.terms import LIBRARY
from bench.typeset import engineering, figure, mathml, names_of, plain, symbol

_NUMBER = re.compile(r"_\d+$")
"""of a symbol that another part of the finding has as well"""
MOST_PARAMETERS = 12
"""values of a finding on the page; all are in report.json"""
QUANTITIES: dict[str, str] = {
    "TE": "transmission error",
    "theta": "motor angle divided by the ratio",
    "dtheta": "its speed",
    "phi": "motor angle",
    "q": "angle of the load side",
    "tau": "load torque",
    "tau_m": "torque of the motor",
    "load_torque": "reading of the torque sensor",
    "load_motor_torque": "torque of the load motor",
    "T": "temperature of the lubricant",
    "T_amb": "temperature of the room",
    "w_m": "speed of the motor",
    "u": "ratio of the gearbox",
    "d": "direction of motion, +1 or −1",
    "t": "time",
    "C": "heat capacity",
    "R": "heat resistance",
}
"""What the symbols of equations are, besides what was found."""


def equation(finding: Finding) -> str:
    """The equation as HTML, and what its symbols are."""
    text = finding.discovery.equation
    known = QUANTITIES | meanings(finding.effect)
    known |= {name: quantity_label(name) for name in names_of(text) if state_of(name) is not None}
    used = [(name, known[name]) for name in names_of(text) if name in known]
    rows = "".join(f"<dt>{symbol(name)}</dt><dd>{html.escape(what)}</dd>" for name, what in used)
    legend = f"<details><summary class='dim'>What the symbols are</summary><dl>{rows}</dl></details>" if rows else ""
    return f'<p class="equation">{mathml(text)}</p>{legend}'


def meanings(effect: str) -> dict[str, str]:
    """What each parameter of an effect of the library is, by symbol; empty where it is none of the library."""
    return {symbol: meaning for symbol, meaning in _known(effect) if meaning}


def _known(effect: str) -> Iterator[tuple[str, str]]:
    term = LIBRARY.get(effect)
    for forms in term.forms.values() if term is not None else ():
        for form in forms:
            for parameter in (*form.linear, *form.nonlinear):
                yield parameter.symbol, parameter.meaning


def parameters(finding: Finding, linear: bool) -> str:
    """The values with standard deviations; ``linear``: of an axis in metres, whose units stay SI."""
    found = finding.discovery.parameters
    if not found:
        return ""
    known = meanings(finding.effect)
    rows = []
    for p in found[:MOST_PARAMETERS]:
        value, std, si = finite(p["value"]), finite(p.get("std")), str(p["unit"])
        size, spread, unit = ("", "", "") if value is None else engineering(value, std, si)
        if linear and value is not None:
            size, spread, unit = figure(value), figure(std) if std is not None else "–", "" if si == "1" else plain(si)
        doubt = f" ± {spread}" if std is not None else f" (± {_missing(reasons.NO_STD)})"
        text = _missing(reasons.NO_VALUE) if value is None else f"{size}{doubt}"
        name = str(p["symbol"])
        what = html.escape(known.get(name) or known.get(_NUMBER.sub("", name), ""))
        rows.append(f"<tr><td>{html.escape(name)}</td><td>{text}</td><td>{html.escape(unit)}</td><td>{what}</td></tr>")
    hidden = len(found) - MOST_PARAMETERS
    more = f'<p class="dim">and {hidden} more in report.json</p>' if hidden > 0 else ""
    head = "<th>symbol<th>value<th>unit<th>what it is"
    return f'<div class="wide"><table><tr>{head}</tr>{"".join(rows)}</table></div>{more}'


def _missing(why: str) -> str:
    return f'<span class="dim">not computed, because {html.escape(why)}</span>'
