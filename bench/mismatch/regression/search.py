"""Which effects a channel needs: step by step, each the one that predicts points left out best, until none gains its
price.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.problem import ChannelProblem
from bench.mismatch.regression.auxiliary import auxiliary_candidates, composed_candidates
from bench.mismatch.regression.bank import Bank, Fit
from bench.mismatch.regression.candidates import (
    exercised,
    free_candidates,
    named_candidates,
    overlapping,
    shape_of,
)
from bench.mismatch.regression.copies import copies, told
from bench.mismatch.regression.description import description, prior_of
from bench.mismatch.regression.folds import predictive, weights
from bench.mismatch.regression.heredity import laws, orphaned, without, without_laws
from bench.mismatch.regression.model import (
    Block,
    ChannelModel,
    Chosen,
    add_base,
    add_block,
    calibration,
    fit_blocks,
    left_by,
    plain_residual,
    prepare_bank,
    unrefined,
    weak_precision,
    with_shape,
)
from bench.mismatch.regression.prior import settled
from bench.mismatch.regression.refine import refined, strained
from bench.mismatch.regression.refuted import not_refuted
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, Regressor
from bench.mismatch.regression.scan import LEAST_OWN, Scan, Units, scan, units, whole
from bench.mismatch.regression.spells import SIGNS, in_levels, levels_of, price_of_cuts, spell_of, timed
from bench.mismatch.regression.strength import Strength, strength
from bench.simulation.composed import parts_of
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import AUXILIARY
from bench.simulation.terms import LIBRARY

MOST_EFFECTS = 12
MOST_UNKNOWN = 2
"""free functions without a name: what two do not follow depends on something else, and more only follow these
recordings
"""
MOST_AUXILIARY = 6
"""functions of quantities that are no channels of the bench: these were measured, and each may act in several ways"""
MOST_ALIKE = 4
"""parts that one effect may have: two orders, two plays"""
MOST_FORMS = 3
"""forms of one effect that are refined in a step"""
FEWEST_UNITS = 10
"""recordings whose signs, drawn at random, are alike less often than :data:`criteria.ERROR_RATE_OF_A_CHANNEL`"""
MOST_PASSED = 3
"""kinds of candidates that gain less than what is left might, and are passed over, before nothing more is looked for"""
MOST_ROUNDS = 4
"""times that the noise is read afresh from what the model leaves"""
QUIETER = 0.9
"""noise over that of the last round, below which another round may find more"""
MOST_TRIFLES = 2
"""functions too small to be told that are set beside a model when the noise of its residual is looked at"""
SHORT_LIST = 3
"""effects, and free functions, that are refined and compared on points left out in a step"""
BEYOND_BOUNDS = 2.0
"""standard deviations by which a coefficient may lie on the wrong side of a physical bound"""


@dataclass(slots=True)
class Search:
    """A channel's bank with all its candidates, and the model found so far."""

    model: ChannelModel
    blocks: list[Block]
    """candidates"""
    extra: FloatArray
    """parameters of each candidate beyond its columns"""
    units: Units
    seed: int
    scans: list[Scan]

    @property
    def bank(self) -> Bank:
        """The bank."""
        return self.model.bank

    def density(self, chosen: Sequence[Chosen]) -> FloatArray:
        """Log predictive density of each point left out, with some effects."""
        model = self.model
        blocks = model.blocks(chosen)
        variance = fit_blocks(model.bank, blocks, model.variances).variance
        return predictive(model.bank, blocks, model.folds, variance)

    def scan(self, chosen: Sequence[Chosen], fitted: Fit, shuffled: bool = False, least: float = LEAST_OWN) -> Scan:
        """Gains of all candidates beside some effects, and their price (``shuffled``: by the residual itself);
        ``least``: see :func:`bench.mismatch.regression.scan.scan`.
        """
        model = self.model
        blocks = model.blocks(chosen)
        index = [i for b in blocks for i in b.place]
        precision = np.concatenate([b.precision for b in blocks]) if blocks else np.zeros(0)
        residual = model.bank.residual(index, fitted.coefficients)
        places = [b.place for b in self.blocks]
        extra, cut, seed = self.extra, self.units, self.seed
        return scan(model.bank, index, precision, fitted.variance, residual, places, extra, cut, seed, shuffled, least)

    def close(self) -> None:
        """Let go of what only a search needs, when all is found: from now on effects of the model can be refitted, no
        more.
        """
        self.bank.close([i for b in self.model.blocks() for i in b.place])
        self.blocks, self.scans = [], []


def begun(problem: ChannelProblem, seed: int = 0, left: FloatArray | None = None) -> Search:
    """A search with the calibrated simulation alone; ``left`` (training rows,): the residual that tells the noise, if
    not the simulation's.
    """
    residual = plain_residual(problem) if left is None else left
    bank, samples, noise, folds = prepare_bank(problem, residual)
    base = settled(problem, bank, add_base(problem, bank))
    variances = (0.0,) if problem.cut and not problem.spec.integral else bank.variances()
    plain = fit_blocks(bank, base, variances)
    own_terms = calibration(problem, base, noise)
    model = ChannelModel(problem, bank, samples, noise, base, [], plain, variances, folds, own_terms)
    train = problem.train
    own = problem.rows.frame.take(train)
    regressors: list[Regressor] = [
        *named_candidates(problem.channel, problem.rows.frame, problem.switched_off, problem.banned, problem.free),
        *free_candidates(problem.channel, own, problem.free),
        *auxiliary_candidates(problem.channel, own),
        *composed_candidates(problem.channel, own, problem.turning),
    ]
    same = copies(problem)
    model.notes += told(same)
    regressors = [r for r in regressors if not _depends(r, same)]
    if noise.telling is not None:
        regressors = [without_laws(r, own) if isinstance(r, Free) else r for r in regressors]
    blocks = []
    for regressor in regressors:
        columns = regressor.columns(problem.rows.frame)[train]
        if np.isfinite(columns).all() and np.any(columns):
            place = bank.add(columns)
            blocks.append(Block(regressor, place, np.zeros(len(place))))
    extra = np.array(
        [len(b.regressor.point) if isinstance(b.regressor, Named) else 0 for b in blocks], dtype=np.float64
    )
    if noise.telling is not None:
        extra = np.array([description(model, Chosen(b)) for b in blocks])
    duration = max(criteria.BLOCK_S, 3.0 * noise.memory)
    if noise.telling is not None:
        duration = criteria.BLOCK_MEMORIES * float(np.sum(own.step)) / noise.telling
    return _settle(Search(model, blocks, extra, units(own.elapsed, bank.whitening.starts, duration), seed, []))


def _depends(regressor: Regressor, names: Collection[str]) -> bool:
    """Whether a regressor depends on one of some auxiliary quantities."""
    own = (name.removeprefix(AUXILIARY) for name in regressor.variables if name.startswith(AUXILIARY))
    return bool(names) and any(part in names for name in own for part in parts_of(name))


def _settle(search: Search) -> Search:
    """The search with the effects that are in force, but of unknown form, part of the simulation."""
    for effect in search.model.problem.unsettled:
        model = search.model
        seen = search.scan([], model.refitted([]))
        own = [k for k, b in enumerate(search.blocks) if b.regressor.effect == effect and np.isfinite(seen.gain[k])]
        best = max(own, key=lambda k: float(seen.gain[k]), default=None)
        chosen = None if best is None else shaped(search, [], search.blocks[best].regressor)
        if chosen is None:
            model.notes.append(f"{effect} is in force without numbers, and nothing in these recordings calibrates it")
            continue
        base = [*model.base, chosen.main]
        fit, own_terms = fit_blocks(model.bank, base, model.variances), calibration(model.problem, base, model.noise)
        search.model = replace(model, base=base, fit=fit, calibration=own_terms)
        keep = [k for k, b in enumerate(search.blocks) if b.regressor.effect != effect]
        search.blocks, search.extra = [search.blocks[k] for k in keep], search.extra[keep]
    return search


def searched(problem: ChannelProblem, seed: int = 0) -> Search:
    """Search a channel for what the simulation lacks.

    While effects are still to be found a gain is priced by noise as the model has it; when nothing more is found, by
    the residual itself, whose noise may be of another kind, and what does not pay that price goes again.
    """
    search = begun(problem, seed)
    _forward(search)
    if search.model.noise.telling is None:
        return _concluded(search)
    # only what a model leaves tells the noise: with a better model there is less of it, and more is found
    for _ in range(MOST_ROUNDS):
        again = begun(problem, seed, left_by(search.model))
        quieter = np.median(again.model.noise.sigma) <= QUIETER * np.median(search.model.noise.sigma)
        search = carried_over(search, again)
        if not quieter:
            break
        _forward(search)
    return _concluded(search)


def carried_over(search: Search, to: Search) -> Search:
    """Another bank's search with the effects of this one."""
    model, bank = to.model, to.bank
    problem = model.problem

    def moved(block: Block) -> Block:
        place = bank.add(block.regressor.columns(problem.rows.frame)[problem.train])
        return replace(block, place=place)

    chosen = [
        replace(c, main=moved(c.main), shape=None if c.shape is None else moved(c.shape)) for c in search.model.chosen
    ]
    to.model = replace(model, chosen=chosen, fit=model.refitted(chosen), price=search.model.price)
    to.scans = search.scans
    return to


def _forward(search: Search) -> None:
    model = search.model
    passed: list[Chosen] = []
    while len(model.chosen) < MOST_EFFECTS:
        seen = search.scan(model.chosen, model.fit)
        search.scans.append(seen)
        if len(search.scans) == 1:
            # beside a rich function noise gains more: that is the next effect's affair, not that of those found before
            model.price = seen.price
        found = _best(search, seen, passed)
        pair = _pair(search, seen) if found is None else []
        if pair:
            search.model = model = replace(model, chosen=[*model.chosen, *pair])
            model.fit = model.refitted(model.chosen)
            continue
        if found is None:
            break
        chosen = _pruned(search, [*model.chosen, found], model.price)
        if found not in chosen:
            break
        if not _beyond_the_rest(search, chosen, found):
            if len(passed) == MOST_PASSED:
                break
            passed.append(found)
            continue
        search.model = model = replace(model, chosen=chosen, fit=model.refitted(chosen))


def _beyond_the_rest(search: Search, chosen: Sequence[Chosen], found: Chosen) -> bool:
    """Whether an effect gains more than the residual beside it would give some candidate by chance, its signs drawn
    block by block. Asked where nothing but a residual tells the noise: it holds what is not found yet.
    """
    model = search.model
    if model.noise.telling is None:
        return True
    others = without(chosen, found, model.problem.lacking)
    gain = float(search.density(chosen).sum() - search.density(others).sum()) - description(model, found)
    return gain >= search.scan(chosen, model.refitted(chosen), shuffled=True).price


def _concluded(search: Search) -> Search:
    model = search.model
    # structure that nothing follows is alike for longer than a block: whole recordings are turned as well
    beside = [*model.chosen, *_trifles(search)]
    fitted = model.refitted(beside)
    looks = [search.scan(beside, fitted, shuffled=True)]
    recordings = whole(search.units)
    # pieces of one recording share its zero, and the signs of a few recordings are often drawn alike
    if not model.problem.free or (not model.problem.cut and recordings.recording.size >= FEWEST_UNITS):
        looks.append(replace(search, units=recordings).scan(beside, fitted, shuffled=True))
    last = max(looks, key=lambda s: s.price)
    search.scans.append(last)
    price = max(last.price, model.price)
    chosen = _believed(search, _pruned(search, model.chosen, price, keep=0))
    chosen = not_refuted(model, _no_mere_form(search, _above_the_rest(search, chosen)))
    search.model = replace(model, chosen=chosen, fit=model.refitted(chosen), price=price)
    return search


def _trifles(search: Search) -> list[Chosen]:
    """What gains its price beside the model and is too small to be told: a jerk at each corner of the speed must not
    set the price of what acts elsewhere.
    """
    model = search.model
    small: list[Chosen] = []
    while len(small) < MOST_TRIFLES:
        beside = [*model.chosen, *small]
        seen = search.scan(beside, model.refitted(beside))
        best = int(np.argmax(seen.gain)) if seen.gain.size else 0
        if not seen.gain.size or not seen.gain[best] > seen.price:
            break
        candidate = unrefined(search.bank, search.blocks[best])
        if strength(model, candidate).enough:
            break
        small.append(candidate)
    return small


def _nominal(candidate: Chosen) -> bool:
    """Whether an effect is a term of the nominal simulation."""
    return candidate.effect in LIBRARY and LIBRARY[candidate.effect].nominal


def _believed(search: Search, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without those that, had other points been run, would as soon not have been found."""
    current = list(chosen)
    while current:
        whole = search.density(current)
        others = [search.density(without(current, c, search.model.problem.lacking)) for c in current]
        costs = [np.array([description(search.model, c), 0.0]) for c in current]
        drawn = [weights(np.array([whole, w]), search.seed, c) for w, c in zip(others, costs, strict=True)]
        share = [_odds(own, c) for own, c in zip(drawn, current, strict=True)]
        worst = int(np.argmin(share))
        if share[worst] > 0.5:
            break
        current = without(current, current[worst], search.model.problem.lacking)
    return current


def _above_the_rest(search: Search, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without the names that are no larger than a few times what is left without an explanation, where
    something without a name is there: such a name is as likely a part of that as itself.
    """
    model = search.model
    if all(c.effect != UNKNOWN for c in chosen):
        return list(chosen)
    fitted = model.refitted(chosen)
    own = model.problem.rows.take(model.problem.train)
    index = [i for b in model.blocks(chosen) for i in b.place]
    left = model.bank.residual(index, fitted.coefficients)
    beyond = max(float(np.mean(left**2)) - 1.0, 0.0)  # whitened: noise alone has 1
    rest = float(np.sqrt(beyond * np.sum(model.noise.sigma**2 * own.number) / own.number.sum())) / model.floor
    least = criteria.OVER_THE_REST * rest
    return [c for c in chosen if c.effect == UNKNOWN or _strength_among(search, chosen, c).overall > least]


def _no_mere_form(search: Search, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without the functions that may be what a name's form leaves of nature's: those without a name that depend
    on a quantity of a name, and are smaller than its form may be off.
    """
    if all(c.effect != UNKNOWN for c in chosen):
        return list(chosen)

    def size(one: Chosen) -> float:
        return _strength_among(search, chosen, one).acts

    named = [(set(c.main.regressor.variables), size(c)) for c in chosen if c.effect != UNKNOWN]
    out = []
    for one in chosen:
        own = set(one.main.regressor.variables)
        largest = max((s for variables, s in named if variables & own), default=0.0)
        if one.effect != UNKNOWN or largest == 0.0 or size(one) >= criteria.SHAPE * largest:
            out.append(one)
    return out


def told_from_nothing(coefficients: FloatArray, covariance: FloatArray) -> bool:
    """Whether one of some fitted coefficients is more than what chance makes it."""
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return bool(np.any(np.abs(coefficients) > criteria.TOLD * std))


def _strength_among(search: Search, chosen: Sequence[Chosen], one: Chosen) -> Strength:
    """How strong one of some effects is beside the others."""
    others = [c for c in chosen if c is not one]
    return strength(replace(search.model, chosen=others), one)


def _odds(share: FloatArray, chosen: Chosen) -> float:
    """Probability of an effect against nothing; before anything is measured a free function is less likely than a
    name.
    """
    prior = prior_of(chosen)
    return float(prior * share[0] / (prior * share[0] + share[1]))


def _best(search: Search, seen: Scan, passed: Sequence[Chosen] = ()) -> Chosen | None:
    """The candidate that predicts points left out best beside the model, of those that gain their price; none of the
    kinds ``passed`` over.
    """
    over = {_kind(c.main.regressor) for c in passed}
    model = search.model
    effects = [c.effect for c in model.chosen]
    # laws that the simulation lacks and the recordings ask for come before their changes
    asked_first = {
        b.regressor.effect
        for b, gain in zip(search.blocks, seen.gain, strict=True)
        if b.regressor.effect in model.problem.lacking and gain >= seen.price
    }
    taken = {e for e in effects if effects.count(e) >= MOST_ALIKE} - {UNKNOWN}
    free_ones = [c for c in model.chosen if c.effect == UNKNOWN]
    # an effect that is any function of a quantity has one
    whole = {(c.effect, c.main.regressor.variables) for c in model.chosen if isinstance(c.main.regressor, Free)}
    beside = sum(_auxiliary(c.main.regressor) for c in free_ones)
    more = len(free_ones) - beside < MOST_UNKNOWN
    order = np.argsort(-seen.gain)
    named: dict[str, dict[str, int]] = {}
    free: dict[tuple[str, ...], int] = {}
    other: dict[tuple[str, ...], dict[tuple[str, ...], int]] = {}
    for k in order:
        if seen.gain[k] < min(seen.price, 0.3 * seen.gain[order[0]]) or not np.isfinite(seen.gain[k]):
            break
        regressor = search.blocks[k].regressor
        if orphaned(regressor, effects, asked_first) or _kind(regressor) in over:
            continue
        if isinstance(regressor, Named):
            # a term of the nominal simulation that is switched off is always asked
            if regressor.effect not in taken and (len(named) < SHORT_LIST or regressor.term.nominal):
                forms = named.setdefault(regressor.effect, {})
                # which form is best is known when each has its own parameters: a knee lies between two grid points
                if len(forms) < MOST_FORMS:
                    forms.setdefault(regressor.form.name, int(k))
        elif _auxiliary(regressor):
            if beside < MOST_AUXILIARY and (len(free) + len(other) < SHORT_LIST or regressor.variables in other):
                # whether it is drag or grows with speed is known when all else is fitted beside each
                ways = other.setdefault(regressor.variables, {})
                if len(ways) < MOST_FORMS:
                    ways.setdefault(tuple(grid.times for grid in regressor.grids), int(k))
        elif len(free) + len(other) < SHORT_LIST and _still_open(regressor, taken, whole, more):
            sudden = ("",) if spell_of(regressor) else ()
            free.setdefault((*regressor.variables, *sudden), int(k))
    asked = [k for forms in named.values() for k in forms.values()]
    nameless = [*free.values(), *(k for ways in other.values() for k in ways.values())]
    if max((seen.gain[k] for k in (*asked, *nameless)), default=-np.inf) < seen.price:
        return None
    best: tuple[float, Chosen] | None = None
    nominal = any(LIBRARY[effect].nominal for effect in named)
    start = float(search.density(model.chosen).sum())
    for k in asked:
        candidate = shaped(search, model.chosen, search.blocks[k].regressor)
        if candidate is None or not strength(search.model, candidate).enough:
            continue
        total = float(search.density([*model.chosen, candidate]).sum()) - handicap_of(search, candidate)
        total -= description(model, candidate)
        if not _nominal(candidate):
            # a curve that only comes near a term that every such machine has is no discovery
            total -= criteria.SHAPE**2 * max(total - start, 0.0) * nominal
        if best is None or total > best[0]:
            best = (total, candidate)
    if best is not None and best[0] - start < seen.price:
        best = None
    first = best
    functions = [timed(model, search.blocks[k]) for k in nameless if seen.gain[k] >= seen.price]
    functions += [
        b
        for b in _levels(model)
        if _still_open(b.regressor, taken, whole, more) and not orphaned(b.regressor, effects, asked_first)
    ]
    for block in functions:
        candidate = free_function(search, model.chosen, _form_of_a_name(block, model.chosen))
        total = float(search.density([*model.chosen, candidate]).sum()) - price_of_cuts(model, block.regressor)
        total -= description(model, candidate)
        if total - start < seen.price or not strength(search.model, candidate).enough:
            continue
        if model.noise.telling is not None:
            joint = model.refitted([*model.chosen, candidate])
            if not sound_beside(search, model.chosen, candidate.main, joint):
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


def _levels(model: ChannelModel) -> list[Block]:
    """Levels that change over the campaign, for each factor that has none yet."""
    if overlapping(model.problem.rows.frame.take(model.problem.train)):
        return []
    known = {own.times for c in model.chosen if (own := levels_of(c.main.regressor)) is not None}
    return in_levels(model, [times for times in SIGNS if times not in known])


def _pair(search: Search, seen: Scan) -> list[Chosen]:
    """A law that the simulation lacks and what hides it: neither gains anything without the other. A pendulum's gravity
    is against its inertia all the time. Nothing where no pair gains its price; nothing where points left out tell what
    a number is worth, for there the motion does not repeat.
    """
    model = search.model
    if model.noise.telling is None:
        return []
    beside = {c.effect for c in model.chosen}
    start = float(search.density(model.chosen).sum())
    best: tuple[float, list[Chosen]] = (start + seen.price, [])
    for block in search.blocks:
        if block.regressor.effect not in model.problem.lacking or block.regressor.effect in beside:
            continue
        first = unrefined(search.bank, block)
        with_it = [*model.chosen, first]
        at = replace(search, model=replace(model, chosen=with_it, fit=model.refitted(with_it)))
        second = _best(at, at.scan(with_it, at.model.fit))
        if second is None:
            continue
        both = [*with_it, second]
        fitted = model.refitted(both)
        if all(_possible(c.main, fitted) for c in (first, second)):
            total = float(search.density(both).sum()) - description(model, first) - description(model, second)
            best = max(best, (total, [first, second]), key=lambda own: own[0])
    return best[1]


def _possible(block: Block, fitted: Fit) -> bool:
    """Whether a block's coefficients are physically possible."""
    return not isinstance(block.regressor, Named) or admissible(block.regressor, *fitted.of(block.place))


def _kind(regressor: Regressor) -> tuple[str, ...]:
    """What a regressor is of: its effect, or the quantities of a function without a name."""
    return (regressor.effect,) if regressor.effect != UNKNOWN else regressor.variables


def _form_of_a_name(block: Block, chosen: Sequence[Chosen]) -> Block:
    """A free function as part of a name found before, where nature's form of that may differ from the library's by just
    such a function, or such a function follows from it: what they add up to says nothing of a second effect.
    """
    free = block.regressor
    if not isinstance(free, Free) or free.mixing:
        return block
    own = {(name, grid.times) for grid in free.grids for name in grid.over}
    for one in chosen:
        term = LIBRARY.get(one.effect)
        named = isinstance(one.main.regressor, Named)
        if not own or not named or term is None:
            continue
        if own <= {*term.shape.get(free.channel, ()), *term.passing.get(free.channel, ())}:
            return replace(block, regressor=replace(free, effect=one.effect))
    return block


def _still_open(regressor: Regressor, taken: set[str], whole: set[tuple[str, tuple[str, ...]]], more: bool) -> bool:
    """Whether one more function of an effect, or (``more``) without a name, may be asked for."""
    if regressor.effect == UNKNOWN:
        return more
    return regressor.effect not in taken and (regressor.effect, regressor.variables) not in whole


def _with_another(search: Search, first: Chosen) -> float | None:
    """Log density that a name reaches with the best other effect beside it that depends on something else, a function
    without a name at its price; None where there is none.
    """
    model = search.model
    chosen = [*model.chosen, first]
    at = replace(search, model=replace(model, chosen=chosen, fit=model.refitted(chosen)))
    seen = at.scan(chosen, at.model.fit)
    known = {c.effect for c in chosen}
    tried: dict[object, float] = {}
    for k in np.argsort(-seen.gain):
        if not np.isfinite(seen.gain[k]) or seen.gain[k] < seen.price or len(tried) == SHORT_LIST:
            break
        regressor = search.blocks[k].regressor
        key = regressor.effect if regressor.effect != UNKNOWN else regressor.variables
        if regressor.effect in known - {UNKNOWN} or key in tried:
            continue
        if orphaned(regressor, known, model.problem.lacking):
            continue
        if set(regressor.variables) & set(first.main.regressor.variables):
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


def _auxiliary(regressor: Regressor) -> bool:
    """Whether a regressor depends on a quantity that is no channel of the bench."""
    return any(name.startswith(AUXILIARY) for name in regressor.variables)


def free_function(search: Search, others: Sequence[Chosen], block: Block) -> Chosen:
    """A free function beside other effects; where no recording has been, its values are as large as elsewhere at
    most.
    """
    model = search.model
    weak = np.full(len(block.place), weak_precision(model.bank, block.place))
    fitted = fit_blocks(model.bank, [*model.blocks(others), replace(block, precision=weak)], model.variances)
    values = block.regressor.columns(model.problem.rows.frame)[model.problem.train] @ fitted.of(block.place)[0]
    size = _own_size(values)
    if model.problem.spec.integral:  # its values are rates
        size = float(np.sqrt(np.mean(fitted.of(block.place)[0] ** 2)))
    precision = np.maximum(weak, 1.0 / max(size, 1e-300) ** 2)
    return Chosen(replace(block, precision=precision))


def _own_size(values: FloatArray) -> float:
    """Size of an effect where it acts: its mean square weighted by itself."""
    square = values**2
    return float(np.sqrt(np.sum(square**2) / max(float(square.sum()), 1e-300)))


def handicap_of(search: Search, candidate: Chosen) -> float:
    """Log density by which a term has to be better than others to be told: one at the end of its range, or a loop that
    the recordings hardly turned, is another term in disguise.
    """
    frame = search.model.problem.rows.frame
    return criteria.RICHER * (int(strained(candidate.main.regressor, frame)) + int(idle(search, candidate)))


def idle(search: Search, candidate: Chosen) -> bool:
    """Whether a term is a loop that the recordings hardly turned: they cannot tell it from a function of the torque."""
    problem = search.model.problem
    regressor, frame = candidate.main.regressor, problem.rows.frame
    return not exercised(regressor, regressor.columns(frame)[problem.train], frame.take(problem.train))


def shaped(search: Search, others: Sequence[Chosen], start: Regressor) -> Chosen | None:
    """A term refined beside other effects, with the correction of its shape; None where it is physically impossible."""
    model = search.model
    assert isinstance(start, Named)
    problem, bank = model.problem, model.bank
    beside = model.blocks(others)
    variance = fit_blocks(bank, beside, model.variances).variance
    better = refined(problem, bank, beside, start, variance)
    main = add_block(problem, bank, better)
    fitted = fit_blocks(bank, [*beside, main], model.variances)
    if not admissible(better, *fitted.of(main.place)):
        return None
    if problem.free and not (sound_beside(search, others, main, fitted) and not _taking(search, main, others, fitted)):
        return None
    for other in others:
        # two of one kind with opposite signs are another curve in disguise
        own = other.main.regressor
        if isinstance(own, Named) and not admissible(own, *fitted.of(other.main.place)):
            return None
    train = problem.train
    effect = better.columns(problem.rows.frame)[train] @ fitted.of(main.place)[0]
    size = _own_size(effect)
    shape = None
    if model.noise.telling is None and all(c.effect != better.effect for c in others):
        shape = shape_of(problem.channel, better.effect, problem.rows.frame.take(train))
    return with_shape(problem, bank, main, shape, criteria.SHAPE * size)


def sound_beside(search: Search, others: Sequence[Chosen], by: Block, fitted: Fit) -> bool:
    """Whether an effect leaves terms physically possible that are so without it: friction that it makes negative is no
    friction, but what it takes from it. An inertia that comes out negative beside drag is another matter: of a term
    that it shares next to nothing with it takes nothing.
    """
    model = search.model
    plain = model.refitted(others)
    for block in [*model.base, *(c.main for c in others)]:
        own = block.regressor
        if not isinstance(own, Named) or not admissible(own, *plain.of(block.place)):
            continue
        if not admissible(own, *fitted.of(block.place)) and _shared(model.bank, block, by, fitted) > criteria.SHAPE**2:
            return False
    return True


def _shared(bank: Bank, first: Block, second: Block, fitted: Fit) -> float:
    """Share of the energy of a fitted block's course that the course of another follows."""
    gram = bank.gram([*first.place, *second.place])
    size = len(first.place)
    a, b = fitted.of(first.place)[0], fitted.of(second.place)[0]
    across = float(a @ gram[:size, size:] @ b)
    return across**2 / max(float(a @ gram[:size, :size] @ a) * float(b @ gram[size:, size:] @ b), 1e-300)


def _taking(search: Search, main: Block, others: Sequence[Chosen], fitted: Fit) -> bool:
    """Whether an effect takes the place of a law that it is a change of, or of another of its name: beside it the law
    is told no longer, or they come to less than either, as each takes back what the other says.
    """
    model = search.model
    own_laws = laws(main.regressor)
    frame = model.problem.rows.frame
    plain = model.refitted(others)

    def course(block: Block) -> FloatArray:
        return np.asarray(block.regressor.columns(frame)[model.problem.train] @ fitted.of(block.place)[0])

    def significant(block: Block, by: Fit) -> bool:
        return told_from_nothing(*by.of(block.place))

    own = course(main)
    for block in [*model.base, *(c.main for c in others)]:
        effect = block.regressor.effect
        if effect not in (main.regressor.effect, *own_laws):
            continue
        if effect in own_laws and significant(block, plain) and not significant(block, fitted):
            return True
        other = course(block)
        if float(np.sum((own + other) ** 2)) < min(float(np.sum(own**2)), float(np.sum(other**2))):
            return True
    return False


def admissible(named: Named, coefficients: FloatArray, covariance: FloatArray) -> bool:
    """Whether a term's coefficients are physically possible: a lag that leads is no lag."""
    doubt = BEYOND_BOUNDS * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    low = np.array([s.lower for s in named.form.linear])
    high = np.array([s.upper for s in named.form.linear])
    if np.any(coefficients + doubt < low) or np.any(coefficients - doubt > high):
        return False
    return not (named.form.one_sign and np.any(coefficients > doubt) and np.any(coefficients < -doubt))


def _pruned(search: Search, chosen: Sequence[Chosen], price: float, keep: int = 1) -> list[Chosen]:
    """Effects without those that the others have made unnecessary; ``keep`` of them at least."""
    current = list(chosen)
    while len(current) > keep:
        whole = float(search.density(current).sum())
        left = [without(current, c, search.model.problem.lacking) for c in current]
        losses = [whole - float(search.density(own).sum()) for own in left]
        losses = [loss - description(search.model, c) for loss, c in zip(losses, current, strict=True)]
        place = int(np.argmin(losses))
        if losses[place] > price:
            break
        current = left[place]
    return current
