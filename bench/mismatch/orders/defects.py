"""Local defects: pulses at fixed angles, against the plain orders that would draw them.

A gearbox full of orders draws any curve, so a pulse has to say more with three numbers than orders say with two each.
At every whole order the mean vector of the revolutions is noise about the pulse's vector, or, with the share of orders
that stand in this spectrum, an order of its own beside it; both densities are known from the spectrum, so the gain of
log-likelihood of a pulse is that of description length. How much the best pulse gains where there is none is measured
on the same spectrum with the phase of each order drawn at random; beside a pulse that was found, on what it leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.orders.periodic import Pulse
from bench.mismatch.orders.pulse_forms import (
    SEARCH_RANGE,
    Form,
    apart,
    apex,
    extent,
    fewest,
    form_of,
    price_of,
    size_of,
)
from bench.mismatch.orders.pulse_mean import Mean
from bench.mismatch.orders.revolutions import Complex
from bench.mismatch.orders.sight import Sight
from bench.mismatch.regression.maxima import tail, tail_rate
from bench.simulation.frame import FloatArray
from bench.simulation.waves import angle_from

SURROGATES = 24
STARTS = 4
MOST_GROUPS = 6
TURNS = 3
"""times that each of several places is fitted to what the others leave"""


@dataclass(frozen=True, slots=True)
class Defect:
    """One damaged place: the Gaussian it is most like, those that describe its form, gain of description length,
    p-value.
    """

    first: Pulse
    form: tuple[Pulse, ...]
    gain: float
    p_value: float

    @property
    def window(self) -> tuple[float, float]:
        """Output angles (rad) between which it acts."""
        return extent(self.form)


@dataclass(frozen=True, slots=True)
class _Found:
    """A pulse as it was found: its gain, p-value and the form it was given then."""

    gain: float
    p_value: float
    form: Form


def search(sight: Sight, seed: int) -> list[Defect]:
    """Damaged places that stand in the mean spectrum, strongest first."""
    line = Mean.of(sight, sight.mean)
    none = np.zeros(line.orders.size, dtype=np.complex128)
    before = none
    found: list[_Found] = []
    while len(found) < MOST_GROUPS:
        fresh = _next(sight, line, before, seed)
        if not fresh:
            break
        found += fresh
        before = before + sum(_drawn(line, one.form.pulses) for one in fresh)
    groups = _grouped(found)
    forms = _fitted_beside_each_other(line, [[one.form for one in group] for group in groups])
    return [
        Defect(form.first if len(form.pulses) == 1 else apex(form.pulses), form.pulses, group[0].gain, group[0].p_value)
        for form, group in zip(forms, groups, strict=True)
    ]


def _next(sight: Sight, line: Mean, before: Complex, seed: int) -> list[_Found]:
    """The pulse that gains most beside others that give ``before`` (k,) of a line, or the two that do so together;
    none where chance gains as much.
    """
    for number, starts in ((1, STARTS), (2, 1)):
        best = line.best(before, starts, number)
        # less than their numbers cost is nothing anyway
        if best is None or best[0] < price_of(line, number):
            continue
        gain, pulses = best
        nulls = _without_phase(sight, line, before, seed, number)
        if gain < tail(nulls, criteria.ERROR_RATE_OF_A_CHANNEL):
            continue
        others = [before + _drawn(line, [p for p in pulses if p is not one]) for one in pulses]
        forms = [form_of(line, beside, one) for beside, one in zip(others, pulses, strict=True)]
        return [_Found(gain / number, tail_rate(nulls, gain), form) for form in forms]
    return []


def _fitted_beside_each_other(line: Mean, groups: Sequence[Sequence[Form]]) -> list[Form]:
    """Forms of several places, each fitted to what the others leave, in turns: the first one was found, and fitted,
    while the others stood in the spectrum, of the same orders as itself.
    """
    pulses = [[p for form in group for p in form.pulses] for group in groups]
    firsts = [max((form.first for form in group), key=size_of) for group in groups]
    drawn = [_drawn(line, of_place) for of_place in pulses]
    forms: list[Form] = []
    for _ in range(TURNS if len(groups) > 1 else 1):
        forms = []
        for k, of_place in enumerate(pulses):
            others = sum(drawn[:k] + drawn[k + 1 :], np.zeros(line.orders.size, dtype=np.complex128))
            form = form_of(line, others, firsts[k])
            if len(of_place) > 1:
                form = min(form, fewest(line, others, of_place), key=lambda f: f.words)
            forms.append(form)
            pulses[k], drawn[k], firsts[k] = [*form.pulses], _drawn(line, form.pulses), form.first
    return forms


def _grouped(found: Sequence[_Found]) -> list[list[_Found]]:
    """Pulses grouped by angle, those of the first one found first: what lies within the range of one is of its form."""
    groups: list[list[_Found]] = []
    for one in found:
        near = [p for p in groups if any(_beside(one, other) for other in p)]
        joined = [other for p in near for other in p] + [one]
        at = groups.index(near[0]) if near else len(groups)
        groups = [p for p in groups if p not in near]
        groups.insert(at, joined)
    return groups


def _beside(one: _Found, other: _Found) -> bool:
    firsts = (one.form.first, other.form.first)
    if apart(firsts[0].angle, firsts[1].angle) < SEARCH_RANGE * max(p.width for p in firsts):
        return True
    # of a pull beside a push each takes a part of the other
    (a, b), (c, d) = extent(one.form.pulses), extent(other.form.pulses)
    return apart(0.5 * (a + b), 0.5 * (c + d)) < 0.5 * (b - a + d - c)


def _drawn(line: Mean, pulses: Sequence[Pulse]) -> Complex:
    return sum((p.vectors(line.orders) for p in pulses), np.zeros(line.orders.size, dtype=np.complex128))


def _without_phase(sight: Sight, line: Mean, before: Complex, seed: int, number: int) -> FloatArray:
    """What so many pulses gain at most beside others that give ``before`` (k,) of a line, where what they leave of each
    order has a phase of its own (SURROGATES,).
    """
    rng = np.random.default_rng([seed, 2])
    known = np.zeros(sight.mean.size, dtype=np.complex128)
    known[line.orders.astype(np.int64)] = before
    out = []
    for _ in range(SURROGATES):
        drawn = known + (sight.mean - known) * np.exp(2j * np.pi * rng.random(sight.mean.size))
        best = Mean.of(sight, drawn).best(before, 1, number)
        out.append(best[0] if best is not None else 0.0)
    return np.asarray(out)


def all_pulses(defects: Sequence[Defect]) -> tuple[Pulse, ...]:
    """Pulses of all places."""
    return tuple(p for d in defects for p in d.form)


def near_defects(defects: Sequence[Defect], theta: FloatArray, widths: float = 0.5) -> NDArray[np.bool_]:
    """Which output angles (n,), rad, are no farther than so many widths of a defect from its middle: by half a width
    those where it acts.
    """
    out = np.zeros(theta.size, dtype=bool)
    for begin, end in (d.window for d in defects):
        out |= np.abs(angle_from(theta, 0.5 * (begin + end))) <= widths * (end - begin)
    return out
