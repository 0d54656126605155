"""Alternatives to an effect: each one refitted in its place, and how sure the name is.

The alternatives to an effect are the other names, the free functions, and nothing at all; each is refined beside the
other effects of the model, as the effect itself was, and predicts the points left out. Weights are those of
:func:`bench.mismatch.regression.folds.weights`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.beside import free_function, handicap_of, idle, in_its_form, shaped, sound_beside
from bench.mismatch.regression.choosing import MOST_FORMS, MOST_REFINED, price_of_course
from bench.mismatch.regression.description import description, prior_of
from bench.mismatch.regression.equivalent import (
    draws_wave,
    heirs_of,
    holds,
    numbers_of,
    predict_alike,
    says_most_of,
    untold,
    worse_by,
)
from bench.mismatch.regression.folds import apart, surely_more, weights
from bench.mismatch.regression.heredity import orphaned, without
from bench.mismatch.regression.model import ChannelModel, Chosen
from bench.mismatch.regression.refine import strained
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, kinds
from bench.mismatch.regression.same_course import same_courses
from bench.mismatch.regression.scan import Scan
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LIBRARY

MOST_ALTERNATIVES = 5
"""names, and as many free functions, that are refitted in an effect's place"""
LEAST_SHARE = 1e-6
"""share of an alternative's energy beside the other effects from which it is looked at: less than of an effect that is
named, for a design that hardly shows an alternative is the very one that cannot exclude it
"""
WORTH_A_LOOK = 0.2
"""of the best gain beside the other effects, that an alternative's has to be before it is refined"""


@dataclass(frozen=True, slots=True)
class Contender:
    """An alternative in an effect's place: log predictive density (folds,), what it loses in all, its standard error,
    weight, whether the recordings cannot tell it from the effect; whether it predicts points left out worse than the
    effect, or better, whichever were drawn (:func:`bench.mismatch.regression.folds.surely_more`).
    """

    chosen: Chosen
    density: FloatArray
    loss: float
    error: float
    weight: float
    as_good: bool
    surely_worse: bool = False
    surely_better: bool = False
    worse_by: float = float("nan")
    """squares with which it predicts points left out, over those of a name that it is a table in place of"""


@dataclass(frozen=True, slots=True)
class Slot:
    """An effect with its alternatives, best first: gain of log predictive density over nothing, p-value, weight of its
    name; of the alternatives the ``plainer`` name that says the same as far as transducers are trusted; whether it is
    ``needless``: without it nothing differs by more than that.
    """

    chosen: Chosen
    gain: float
    p_value: float
    weight: float
    alternatives: tuple[Contender, ...]
    plainer: Contender | None = None
    needless: bool = False


def slots(search: Search) -> list[Slot]:
    """Every effect of the found model with its alternatives."""
    model = search.model
    whole = search.density(model.chosen)
    return [_slot(search, chosen, whole, number) for number, chosen in enumerate(model.chosen)]


def _slot(search: Search, tested: Chosen, whole: FloatArray, number: int) -> Slot:
    model = search.model
    others = without(model.chosen, tested, model.problem.lacking)
    fitted = model.refitted(others)
    seen = search.scan(others, fitted, least=LEAST_SHARE)
    nothing = search.to_be_beaten(others)
    gain = float((whole - nothing).sum())
    found = [
        c for c in _alternatives(search, tested, others, seen) if c.effect != tested.effect or tested.effect == UNKNOWN
    ]

    def predicts(one: Chosen) -> float:
        return float(search.density([*others, one]).sum())

    # of a name that is the same as the effect in these recordings the function that predicts best; each once
    alike = same_courses(search, others, tested)
    same = [c.effect for c in alike]
    best = [max((c for c in (*found, *alike) if c.effect == effect), key=predicts) for effect in same]
    found = [*(c for c in found if c.effect not in same), *best]
    if model.problem.free:
        found = [c for c in found if sound_beside(search, others, c.main, model.refitted([*others, c]), tested)]
    # a name and its alternatives meet in the form in which each predicts best
    rated = tested
    if any(c.effect != UNKNOWN for c in found):
        rated, whole = in_its_form(search, others, tested, whole)
    formed = [in_its_form(search, others, c, search.density([*others, c])) for c in found]
    found, densities = [c for c, _ in formed], [density for _, density in formed]
    table = np.array([whole, *densities, nothing])
    # before anything is measured a name is likelier than a free function
    prior = np.array([_prior(model, c) for c in (tested, *found)] + [1.0])
    costs = np.array([description(model, c) for c in (tested, *found)] + [0.0])
    # a loop that was hardly turned is no likelier than the functions of the torque which it is like
    unturned = idle(search, tested)
    prior[0] *= np.exp(-criteria.RICHER * unturned)
    share = prior * weights(table, search.seed + number, costs)
    share = share / share.sum()
    heirs, needless = heirs_of(model, others, (tested, *found))
    worse = [worse_by(model, others, tested, c) for c in found]
    # a table in the place of a name that foresees what it does not is that name with more numbers
    heirs |= {k + 1: 0 for k, ratio in enumerate(worse) if ratio * criteria.EITHER > 1.0 and 0 not in heirs}
    for k in sorted(heirs, key=lambda k: -numbers_of((tested, *found)[k])):
        share[heirs[k]] += share[k]
        share[k] = 0.0

    def worth(probability: float, chosen: Chosen) -> float:
        # at the end of its range a term turns into another
        at_end = strained(chosen.main.regressor, model.problem.rows.frame)
        return probability * (criteria.EITHER if at_end else 1.0)

    at_its_end = strained(rated.main.regressor, model.problem.rows.frame)
    alternatives: list[Contender] = []
    for k, (chosen, density) in enumerate(zip(found, densities, strict=True)):
        loss, error = apart(whole, density)
        odds = worth(share[k + 1], chosen) / max(worth(share[0], tested), 1e-300)
        surely_worse = surely_more(whole, density)
        near = unturned and _of_the_torque(chosen) and loss < gain - loss
        # what says with more numbers what the effect says is no other explanation
        if not near and heirs.get(k + 1) != 0:
            near = called_as_good(tested, chosen, float(odds), loss, surely_worse, at_its_end)
            doubtful = chosen.effect != UNKNOWN and criteria.VERY_STRONG <= loss < 2.0 * criteria.VERY_STRONG
            near = near or (doubtful and predict_alike(model, others, rated, chosen))
            near = near or (
                not strained(chosen.main.regressor, model.problem.rows.frame) and untold(model, others, rated, chosen)
            )
            # what says little of the effect is another, which may be there as well
            near = near and (chosen.effect == UNKNOWN or says_most_of(model, others, rated, chosen))
            near = near or chosen.effect in same
        better = surely_more(density, whole)
        weight = float(share[k + 1])
        alternatives.append(
            Contender(chosen, density, loss, error, weight, near, surely_worse, better, worse_by=worse[k])
        )
    plainer = alternatives[heirs[0] - 1] if 0 in heirs else None
    alternatives.sort(key=lambda r: r.loss)
    last = search.scans[-1] if search.scans else seen
    return Slot(tested, gain, last.p_value(gain), float(share[0]), tuple(alternatives), plainer, needless)


def called_as_good(
    tested: Chosen, other: Chosen, odds: float, loss: float, surely: bool, at_its_end: bool = False
) -> bool:
    """Whether another explanation is not told apart from an effect: its ``odds`` against it, and its ``loss`` of log
    density at points left out, ``surely`` whichever of them were drawn.

    Between two names a small loss may be that of two forms, of which nature has neither; and one that a few points may
    have made by chance has to be twice as large. Of a name ``at_its_end``, the end of its range, where it turns into
    another, whatever a few points may have made by chance says nothing.
    """
    enough = (1.0 if surely else 2.0) * criteria.VERY_STRONG
    both_named = UNKNOWN not in (tested.effect, other.effect)
    return odds > criteria.AS_GOOD or (both_named and (loss < enough or (at_its_end and not surely)))


def _of_the_torque(chosen: Chosen) -> bool:
    """Whether a name is a function of the torque: beside it a loop that was never turned is its form, not its path."""
    return chosen.effect != UNKNOWN and set(chosen.main.regressor.variables) <= {"torque", "load_motor_torque"}


def _prior(model: ChannelModel, chosen: Chosen) -> float:
    """Odds before anything is measured."""
    return prior_of(chosen) * float(np.exp(-price_of_course(model, chosen.main.regressor)))


def _alternatives(search: Search, tested: Chosen, others: Sequence[Chosen], seen: Scan) -> list[Chosen]:
    """Other explanations that come near, refined beside the other effects."""
    taken = {c.effect for c in others}
    named: dict[str, dict[str, int]] = {}
    free: dict[tuple[str, ...], int] = {}
    for k in np.argsort(-seen.gain):
        if seen.gain[k] < WORTH_A_LOOK * float(seen.gain.max()) or not np.isfinite(seen.gain[k]):
            break
        regressor = search.blocks[k].regressor
        if orphaned(regressor, taken, search.model.problem.lacking):
            continue
        # a law that says the effect, or one that is beside it, as well as its own is no other explanation
        if any(draws_wave(c, regressor) for c in others):
            continue
        if isinstance(regressor, Named) and {tested.effect, *taken} & set(regressor.form.says):
            continue
        if isinstance(regressor, Named):
            room = regressor.effect in named or len(named) < MOST_ALTERNATIVES
            if regressor.effect not in taken and regressor.effect != tested.effect and room:
                forms = named.setdefault(regressor.effect, {})
                # which form is best is known when each has its own parameters: one may end up at the end of its range
                if len(forms) < MOST_REFINED:
                    forms.setdefault(regressor.form.name, int(k))
        elif len(free) < 2 and (kinds(tested.main.regressor) != kinds(regressor) or tested.effect != UNKNOWN):
            free.setdefault(kinds(regressor), int(k))
    out = []
    for forms in named.values():
        shapes = (shaped(search, others, search.blocks[k].regressor) for k in forms.values())
        candidates = list(islice((c for c in shapes if c is not None), MOST_FORMS))
        if len(candidates) > 1:
            worth = np.array([float(search.density([*others, c]).sum()) - handicap_of(search, c) for c in candidates])
            candidates = [candidates[_meeting(search, tested, candidates, worth)]]
        out += candidates
    for k in free.values():
        block = search.blocks[k]
        if isinstance(block.regressor, Free) and _of_the_name(block.regressor, {tested.effect, *taken} - {UNKNOWN}):
            continue
        out.append(free_function(search, others, block))
    return out


def _meeting(search: Search, tested: Chosen, forms: Sequence[Chosen], worth: FloatArray) -> int:
    """In which of its forms, of a ``worth`` (n,) in log density each, a name meets an effect: the best, or one nearly
    as good that says something else. A form of which the effect is a case is no other explanation.
    """
    best = int(np.argmax(worth))
    others = [k for k, c in enumerate(forms) if not holds(search.model.problem, c, tested)]
    if best in others or not others:
        return best
    second = max(others, key=lambda k: worth[k])
    return second if worth[best] - worth[second] < criteria.VERY_STRONG else best


def _of_the_name(free: Free, effects: set[str]) -> bool:
    """Whether a free function is one of those by which nature's form of an effect may differ from the library's: it
    says nothing against the name.
    """
    shapes = {(name, grid.times) for grid in free.grids for name in grid.over}
    return any(
        effect == free.effect or shapes <= LIBRARY[effect].shapes(free.channel)
        for effect in effects
        if effect in LIBRARY
    )
