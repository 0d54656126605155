"""How sure the numbers of a name are where nature may have another of its forms.

Viscosity after Arrhenius and after Vogel, a Stribeck curve that is Gaussian or exponential: two forms of one name have
the same numbers by name, and predict points left out about as well. The best of them is reported. What its numbers
would be in the others, each weighted by how likely it predicts best, is part of how uncertain they are (model
averaging: Hoeting et al., Statistical Science 14 (1999) 382).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch.regression.beside import shaped
from bench.mismatch.regression.folds import weights
from bench.mismatch.regression.model import Chosen
from bench.mismatch.regression.refine import bounds, strained
from bench.mismatch.regression.regressors import Named
from bench.mismatch.regression.slots import Slot
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray
from bench.simulation.terms import Form


def with_open_forms(search: Search, slots: Sequence[Slot]) -> list[Slot]:
    """Slots, and the model of a search with them, whose names know how much their numbers depend on the form."""
    out = []
    for slot in slots:
        effect = slot.chosen
        others = [c for c in search.model.chosen if c is not effect]
        wide = _widened(search, others, effect)
        if wide is not None:
            new = replace(effect, main=replace(effect.main, regressor=wide))
            search.model = replace(search.model, chosen=[new if c is effect else c for c in search.model.chosen])
            slot = replace(slot, chosen=new)
        out.append(slot)
    return out


def _widened(search: Search, others: Sequence[Chosen], effect: Chosen) -> Named | None:
    """A name with the standard deviations that its forms together give; None where it has but one with its numbers."""
    regressor = effect.main.regressor
    if not isinstance(regressor, Named) or not regressor.point or effect.nominal:
        return None
    met = [c for form in _alike(regressor) if (c := _in(search, others, regressor, form)) is not None]
    if not met:
        return None
    densities = np.array([search.density([*others, c]) for c in (effect, *met)])
    share = weights(densities, search.seed)[1:]
    coefficients, point = _numbers(search, [*others, effect], effect)
    moved = [_numbers(search, [*others, c], c) for c in met]
    linear = np.sqrt(
        sum((s * (values - coefficients) ** 2 for s, (values, _) in zip(share, moved, strict=True)), 0.0 * coefficients)
    )
    shape = np.sqrt(sum((s * (values - point) ** 2 for s, (_, values) in zip(share, moved, strict=True)), 0.0 * point))
    known = regressor.deviation or (None,) * point.size
    return replace(
        regressor,
        carried=tuple(float(v) for v in np.hypot(regressor.carried or 0.0, linear)),
        deviation=tuple(None if d is None else float(np.hypot(d, more)) for d, more in zip(known, shape, strict=True)),
    )


def _alike(named: Named) -> list[Form]:
    """Other forms of a name whose numbers have the same names, and that begin each recording in the same way."""

    def symbols(form: Form) -> tuple[str, ...]:
        return tuple(s.symbol for s in (*form.linear, *form.nonlinear))

    form_now = named.form
    return [
        form
        for form in named.term.forms[named.channel]
        if form is not form_now and symbols(form) == symbols(form_now) and form.remembers == form_now.remembers
    ]


def _in(search: Search, others: Sequence[Chosen], named: Named, form: Form) -> Chosen | None:
    """A name refined in another form, from its own point on; None where that is impossible or ends in a third."""
    low, high = bounds(form, search.model.problem.rows.frame)
    if not np.isfinite([low, high]).all():
        return None  # these recordings have no point of it
    point = tuple(float(v) for v in np.clip(named.point, low, high))
    found = shaped(search, others, Named(named.term, named.channel, form, point))
    return None if found is None or strained(found.main.regressor, search.model.problem.rows.frame) else found


def _numbers(search: Search, chosen: Sequence[Chosen], effect: Chosen) -> tuple[FloatArray, FloatArray]:
    """Coefficients and nonlinear parameters of a name beside others."""
    regressor = effect.main.regressor
    assert isinstance(regressor, Named)
    return search.model.refitted(chosen).of(effect.main.indices)[0], np.asarray(regressor.point)
