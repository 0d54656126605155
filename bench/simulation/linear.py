"""A linear axis in its own words: metres and newtons where a shaft has radians and newton metres.

Inside, both are numbers; a recording's header says which they are, a simulation file by its key ``axis``. Texts and
units are put into the axis' own on the way out, in one place.
"""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from typing import Any

from bench.simulation.model import Parameter, Simulation

AXIS, LINEAR = "axis", "linear"
"""key of a simulation file, and what it says of a linear axis"""


KEPT = frozenset(("file", "recordings", "effect", "channel", "said", "recalibrated"))
"""keys of a report whose values are names"""


def _word(name: str) -> str:
    """Pattern of a word that is no part of an id, a file's name or a quantity's."""
    return rf"(?<![\w./-])({name}|{name.capitalize()})(s?)\b(?![./-]\w)"


_UNITS: tuple[tuple[re.Pattern[str], str], ...] = (
    (re.compile(r"\bN[*·]m\b"), "N"),
    (re.compile(r"\bkg[*·]m(?:\^2|²)"), "kg"),
    (re.compile(r"\b(?<!_)rad\b"), "m"),
)
_PHRASES: tuple[tuple[re.Pattern[str], str], ...] = (
    (re.compile(r"\boutput angle\b"), "position"),
    (re.compile(r"\bper output revolution\b"), "per 2π m"),
    (re.compile(r"\b(at|of) the motor(?:'s)? shaft\b"), r"\1 the motor"),
    (re.compile(r"\bof the motor at its shaft\b"), "of the motor"),
)
_WORDS = {
    re.compile(_word("torque")): "force",
    re.compile(_word("angle")): "position",
    re.compile(_word("angle_about_zero")): "position_about_zero",
    re.compile(_word("inertia")): "mass",
}


def in_metres(text: str) -> str:
    """A text about a shaft as one about a linear axis."""
    for pattern, word in (*_UNITS, *_PHRASES):
        text = pattern.sub(word, text)
    for pattern, word in _WORDS.items():
        text = pattern.sub(partial(_instead, word), text)
    return text


def _instead(word: str, found: re.Match[str]) -> str:
    """``word`` with the capital and the plural of what was found."""
    return (word if found[1][0].islower() else word.capitalize()) + found[2]


def all_in_metres(value: Any, kept: frozenset[str] = KEPT) -> Any:
    """The same of every text in nested lists and mappings, but for the values of the keys ``kept``."""
    if isinstance(value, str):
        return in_metres(value)
    if isinstance(value, list):
        return [all_in_metres(entry, kept) for entry in value]
    if isinstance(value, dict):
        return {key: entry if key in kept else all_in_metres(entry, kept) for key, entry in value.items()}
    return value


def of_linear_axis(simulation: Simulation) -> Simulation:
    """A simulation that says it is one of a linear axis, with units that are such an axis' own."""
    terms = {
        name: replace(
            term,
            parameters={s: Parameter(p.value, in_metres(p.unit), p.std) for s, p in term.parameters.items()},
            extra=_units_in_metres(dict(term.extra)),
        )
        for name, term in simulation.terms.items()
    }
    return replace(simulation, terms=terms, extra={**simulation.extra, AXIS: LINEAR})


def is_of_linear_axis(simulation: Simulation) -> bool:
    """Whether a simulation says that it is one of a linear axis."""
    return simulation.extra.get(AXIS) == LINEAR


def _units_in_metres(value: Any) -> Any:
    """Nested lists and mappings with the texts of their keys ``unit`` and ``units`` in the axis' own."""
    if isinstance(value, list):
        return [_units_in_metres(entry) for entry in value]
    if isinstance(value, dict):
        return {
            key: all_in_metres(entry) if key in ("unit", "units") else _units_in_metres(entry)
            for key, entry in value.items()
        }
    return value
