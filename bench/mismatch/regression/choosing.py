"""Which candidate comes next: of those that gain their price, the one that predicts points left out best."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.auxiliary import of_auxiliary
from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.beside import admissible, free_function, handicap_of, shaped, sound_beside
from bench.mismatch.regression.candidates import overlapping
from bench.mismatch.regression.cycles import cycle_of, in_cycles, price_of_period
from bench.mismatch.regression.description import description
from bench.mismatch.regression.finer import finer_tables
from bench.mismatch.regression.heredity import orphaned
from bench.mismatch.regression.model import Block, ChannelModel, Chosen, unrefined
from bench.mismatch.regression.products import products, without_parts
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, Regressor, kinds
from bench.mismatch.regression.scan import Scan
from bench.mismatch.regression.spells import SIGNS, changing_of, in_levels, price_of_cuts, spell_of, timed
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.state_scales import scaled
from bench.mismatch.regression.strength import strength
from bench.simulation.terms import LIBRARY

MOST_UNKNOWN = 2
"""free functions without a name: what two do not follow depends on something else, and more only follow these
recordings
"""
MOST_AUXILIARY = 6
"""functions of quantities that are no channels of the bench: these were measured, and each may act in several ways"""
MOST_ALIKE = 4
"""parts that one effect may have: two orders, two plays"""
MOST_FORMS = 3
"""forms of one effect that are compared in a step"""
MOST_REFINED = 9
"""forms of one effect that are tried in a step until MOST_FORMS are possible: the sizes of several loops must have one
sign, and often those that gain most do not
"""
SHORT_LIST = 3
"""effects, and free functions, that are refined and compared on points left out in a step"""


def best_candidate(
    search: Search, seen: Scan, passed: Sequence[Chosen] = (), more_functions: bool = True
) -> Chosen | None:
    """The candidate that predicts points left out best beside the model, of those that gain their price; none of the
    kinds ``passed`` over, nor, but for ``more_functions``, one more function without a name.
    """
    over = {_kind(c.main.regressor) for c in passed}
    model = search.model
    effects = [c.effect for c in model.chosen]
    # laws that the simulation lacks and the recordings ask for come before their changes
    waiting = {
        b.regressor.effect
        for b, gain in zip(search.blocks, seen.gain, strict=True)
        if b.regressor.effect in model.problem.lacking and gain >= seen.price
    }
    taken = {e for e in effects if effects.count(e) >= MOST_ALIKE} - {UNKNOWN}
    free_ones = [c for c in model.chosen if c.effect == UNKNOWN]
    # an effect that is any function of a quantity has one
    whole = {(c.effect, c.main.regressor.variables) for c in model.chosen if isinstance(c.main.regressor, Free)}
    beside = sum(of_auxiliary(c.main.regressor) for c in free_ones)
    more = more_functions and len(free_ones) - beside < MOST_UNKNOWN
    # the columns of a function that the model has already differ from nothing by rounding alone
    had = {c.main.indices for c in model.chosen}
    order = np.argsort(-seen.gain)
    named: dict[str, dict[str, int]] = {}
    free: dict[tuple[str, ...], int] = {}
    other: dict[tuple[str, ...], dict[tuple[str, ...], int]] = {}
    for k in order:
        if seen.gain[k] < min(seen.price, 0.3 * seen.gain[order[0]]) or not np.isfinite(seen.gain[k]):
            break
        regressor = search.blocks[k].regressor
        if orphaned(regressor, effects, waiting) or _kind(regressor) in over or search.blocks[k].indices in had:
            continue
        if isinstance(regressor, Named):
            # a term of the nominal simulation that is switched off is always asked
            if regressor.effect not in taken and (len(named) < SHORT_LIST or regressor.term.nominal):
                forms = named.setdefault(regressor.effect, {})
                # which form is best is known when each has its own parameters: a knee lies between two grid points
                if len(forms) < MOST_REFINED:
                    forms.setdefault(regressor.form.name, int(k))
        elif of_auxiliary(regressor):
            may = more_functions and beside < MOST_AUXILIARY
            if may and (len(free) + len(other) < SHORT_LIST or regressor.variables in other):
                # whether it is drag or grows with speed is known when all else is fitted beside each
                ways = other.setdefault(regressor.variables, {})
                if len(ways) < MOST_FORMS:
                    ways.setdefault(regressor.times, int(k))
        elif len(free) + len(other) < SHORT_LIST and _may_be_added(regressor, taken, whole, more):
            sudden = ("",) if spell_of(regressor) else ()
            free.setdefault((*kinds(regressor), *sudden), int(k))
    eligible = [k for forms in named.values() for k in forms.values()]
    nameless = [*free.values(), *(k for ways in other.values() for k in ways.values())]
    cycles = _cycles(model)
    made = [*(products(search) if more_functions else ()), *finer_tables(search)]
    if not cycles and not made and max((seen.gain[k] for k in (*eligible, *nameless)), default=-np.inf) < seen.price:
        return None
    best: tuple[float, Chosen] | None = None
    nominal = any(LIBRARY[effect].nominal for effect in named)
    start = float(search.to_be_beaten(model.chosen).sum())
    for candidate in chain.from_iterable(possible_forms(search, forms.values()) for forms in named.values()):
        total = float(search.density([*model.chosen, candidate]).sum()) - handicap_of(search, candidate)
        total -= description(model, candidate)
        if not candidate.nominal:
            # a curve that only comes near a term that every such machine has is no discovery
            total -= criteria.SHAPE**2 * max(total - start, 0.0) * nominal
        if best is None or total > best[0]:
            best = (total, candidate)
    if best is not None and best[0] - start < seen.price:
        best = None
    first = best
    functions = [scaled(model, timed(model, search.blocks[k])) for k in nameless if seen.gain[k] >= seen.price]
    functions += [
        b
        for b in (*_levels(search), *cycles)
        if _may_be_added(b.regressor, taken, whole, more)
        and not orphaned(b.regressor, effects, waiting)
        and not search.out(b.regressor)
    ]
    for block in (*functions, *made):
        # a product and a finer table stand in place of the function that they were made of
        others = without_parts(model.chosen, block.regressor)
        candidate = free_function(search, others, _form_of_a_name(block, others))
        proposed = candidate.main.regressor
        if proposed is not block.regressor and (
            search.out(proposed) or not _may_be_added(proposed, taken, whole, more)
        ):
            continue
        total = float(search.density([*others, candidate]).sum()) - price_of_course(model, block.regressor)
        total -= description(model, candidate)
        if total - start < seen.price or not strength(replace(model, chosen=others), candidate).enough:
            continue
        joint = None if model.noise.independent_rows is None else model.refitted([*others, candidate])
        if joint is not None and not sound_beside(search, others, candidate.main, joint):
            continue
        # a name says more than a free function, and nature's form of it need not be the library's: the free
        # function has to predict better by more than that to take its place
        handicap = 0.0 if candidate.effect != UNKNOWN and not nominal else criteria.SHAPE**2 * (total - start)
        handicap += seen.price if candidate.effect == UNKNOWN else 0.0
        if best is None or total - handicap > best[0]:
            best = (total - handicap, candidate)
    if first is not None and best is not None and best[1].effect == UNKNOWN:
        pair = _with_another(search, first[1])
        if pair is not None and pair >= best[0]:
            # a name and something that depends on another quantity say what one function without a name says
            return first[1]
    return None if best is None else best[1]


def possible_forms(search: Search, blocks: Iterable[int]) -> Iterator[Chosen]:
    """Forms of one effect with their own parameters, the first that are possible and strong enough."""
    model = search.model
    shapes = (shaped(search, model.chosen, search.blocks[k].regressor) for k in blocks)
    return islice((c for c in shapes if c is not None and strength(model, c).enough), MOST_FORMS)


def price_of_course(model: ChannelModel, regressor: Regressor) -> float:
    """Log-likelihood that levels or a cycle have to gain for the moments or the period that were chosen."""
    return price_of_cuts(model, regressor) + price_of_period(regressor)


def _levels(search: Search) -> list[Block]:
    """Levels that change over the campaign, for each factor that has none yet and of which none were refuted. Where
    states are candidates there are none: what is slow is whatever follows it best, and levels follow everything.
    """
    model = search.model
    if model.problem.states or overlapping(model.problem.rows.frame.take(model.problem.train)):
        return []
    known = {changing.times for c in (*model.chosen, *search.refuted) if (changing := changing_of(c.main.regressor))}
    return in_levels(model, [times for times in SIGNS if times not in known])


def _cycles(model: ChannelModel) -> list[Block]:
    """Cycles over the campaign's time, for each factor that has none yet; a heat balance has a term of its own."""
    problem = model.problem
    if problem.spec.integral or problem.free or overlapping(problem.rows.frame.take(problem.train)):
        return []
    known = {cycle.times for c in model.chosen if (cycle := cycle_of(c.main.regressor)) is not None}
    return list(in_cycles(model, [times for times in SIGNS if times not in known]))


def _with_another(search: Search, first: Chosen) -> float | None:
    """Log density that a name reaches with the best other effect beside it that depends on something else, a function
    without a name at its price; None where there is none.
    """
    model = search.model
    chosen = [*model.chosen, first]
    at = replace(search, model=replace(model, chosen=chosen, fit=model.refitted(chosen)))
    seen = at.scan(chosen, at.model.fit)
    known = {c.effect for c in chosen}
    tried: dict[tuple[str, ...], float] = {}
    for k in np.argsort(-seen.gain):
        if not np.isfinite(seen.gain[k]) or seen.gain[k] < seen.price or len(tried) == SHORT_LIST:
            break
        regressor = search.blocks[k].regressor
        key = _kind(regressor)
        if regressor.effect in known - {UNKNOWN} or key in tried:
            continue
        if orphaned(regressor, known, model.problem.lacking):
            continue
        if set(kinds(regressor)) & set(kinds(first.main.regressor)):
            continue
        if isinstance(regressor, Named):
            second = shaped(at, chosen, regressor)
            less = 0.0 if second is None else handicap_of(at, second)
        else:
            second = free_function(at, chosen, search.blocks[k])
            less = seen.price if second.effect == UNKNOWN else 0.0
        if second is not None:
            less += description(at.model, second) + description(model, first)
            tried[key] = float(search.density([*chosen, second]).sum()) - less
    return max(tried.values(), default=None)


def hidden_pair(search: Search, seen: Scan, more_functions: bool = True) -> list[Chosen]:
    """A law that the simulation lacks and what hides it: neither gains anything without the other. A pendulum's gravity
    is against its inertia all the time. Nothing where no pair gains its price; nothing where points left out tell what
    a number is worth, for there the motion does not repeat.
    """
    model = search.model
    if model.noise.independent_rows is None:
        return []
    beside = {c.effect for c in model.chosen}
    start = float(search.to_be_beaten(model.chosen).sum())
    best: tuple[float, list[Chosen]] = (start + seen.price, [])
    for block in search.blocks:
        if block.regressor.effect not in model.problem.lacking or block.regressor.effect in beside:
            continue
        first = unrefined(search.bank, block)
        with_it = [*model.chosen, first]
        at = replace(search, model=replace(model, chosen=with_it, fit=model.refitted(with_it)))
        second = best_candidate(at, at.scan(with_it, at.model.fit), (), more_functions)
        if second is None:
            continue
        both = [*with_it, second]
        fitted = model.refitted(both)
        if all(_possible(c.main, fitted) for c in (first, second)):
            total = float(search.density(both).sum()) - description(model, first) - description(model, second)
            best = max(best, (total, [first, second]), key=lambda entry: entry[0])
    return best[1]


def _possible(block: Block, fitted: Fit) -> bool:
    """Whether a block's coefficients are physically possible."""
    return not isinstance(block.regressor, Named) or admissible(block.regressor, *fitted.of(block.indices))


def _kind(regressor: Regressor) -> tuple[str, ...]:
    """What a regressor is of: its effect, or the quantities of a function without a name."""
    return (regressor.effect,) if regressor.effect != UNKNOWN else kinds(regressor)


def _form_of_a_name(block: Block, chosen: Sequence[Chosen]) -> Block:
    """A free function as part of a name found before, where nature's form of that may differ from the library's by just
    such a function, or such a function follows from it: what they add up to says nothing of a second effect.
    """
    free = block.regressor
    if not isinstance(free, Free) or free.mixing:
        return block
    factors = {(name, grid.times) for grid in free.grids for name in grid.over}
    for one in chosen:
        term = LIBRARY.get(one.effect)
        named = isinstance(one.main.regressor, Named)
        if not factors or not named or term is None:
            continue
        if factors <= term.shapes(free.channel) | {*term.passing.get(free.channel, ())}:
            return replace(block, regressor=replace(free, effect=one.effect))
    return block


def _may_be_added(regressor: Regressor, taken: set[str], whole: set[tuple[str, tuple[str, ...]]], more: bool) -> bool:
    """Whether one more function of an effect, or (``more``) without a name, may be added."""
    if regressor.effect == UNKNOWN:
        return more
    return regressor.effect not in taken and (regressor.effect, regressor.variables) not in whole
