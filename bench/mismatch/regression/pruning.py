"""What goes again: effects that the others have made unnecessary, that chance or the rest explains as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.description import description, prior_of
from bench.mismatch.regression.folds import weights
from bench.mismatch.regression.heredity import without
from bench.mismatch.regression.independent import KINDS, beyond_noise, independent, kinds_of
from bench.mismatch.regression.model import Chosen, unrefined
from bench.mismatch.regression.refine import at_longest
from bench.mismatch.regression.refuted import not_refuted
from bench.mismatch.regression.regressors import UNKNOWN, Free, kinds
from bench.mismatch.regression.scan import Scan
from bench.mismatch.regression.sign_blocks import whole
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.strength import Strength, added, strength
from bench.simulation.frame import FloatArray

FEWEST_UNITS = 10
"""recordings whose signs, drawn at random, are alike less often than :data:`criteria.ERROR_RATE_OF_A_CHANNEL`"""
MOST_TRIFLES = 2
"""functions too small to be reported that are set beside a model when the noise of its residual is looked at"""
UNSIGNED = {
    "torque": "load",
    "load_motor_torque": "load",
    "torque_path": "load",
    "motor_torque": "load",
    "velocity": "speed",
}
"""quantities that are another one with its sign: a form that is off in the one is off in the other"""

SINCE = "since_reversal"
SINCE_A_START_OR_REVERSAL = frozenset({SINCE, "distance_since_start"})
FORM_ERRORS = 2.0
"""standard deviations of a form (:data:`criteria.SHAPE`) that it may be off by at one place: one in forty by chance"""
COURSE = "course"
"""kind of the quantities that go together while a campaign, or a recording, takes its course"""


def concluded(search: Search) -> Search:
    """The search when nothing more is found: only the effects that pay the price of the residual itself, whose noise
    may be of another kind than the model has it, and that none of the tests of this file takes away.
    """
    model = search.model
    last = max(shuffled(search, [*model.chosen, *_trifles(search)]), key=lambda s: s.price)
    search.scans.append(last)
    price = max(last.price, model.price)
    chosen = _kept(search, list(model.chosen), price)
    search.model = replace(model, chosen=chosen, fit=model.refitted(chosen), price=price)
    return search


def shuffled(search: Search, beside: Sequence[Chosen]) -> list[Scan]:
    """What candidates gain beside some effects where the signs of the residual are drawn at random: block by block,
    and, where there are recordings enough, recording by recording, for structure that nothing follows and slow noise
    are alike for longer than a block.
    """
    problem, fitted = search.model.problem, search.model.refitted(beside)
    looks = [search.scan(beside, fitted, shuffled=True)]
    recordings = whole(search.units)
    # pieces of one recording share its zero, and the signs of a few recordings are often drawn alike
    if not problem.free or (not problem.cut and recordings.recording.size >= FEWEST_UNITS):
        looks.append(replace(search, units=recordings).scan(beside, fitted, shuffled=True))
    return looks


def _kept(search: Search, chosen: list[Chosen], price: float) -> list[Chosen]:
    """Effects that none of the tests takes away. A name that went because of a function without a name is asked again
    where that function goes itself.
    """
    while True:
        believed = _believed(search, pruned(search, chosen, price, keep=0))
        tested = _that_add(search, no_mere_form(search, _above_the_rest(search, believed)))
        kept = _tested_again(search, tested, not_refuted(search.model, tested), price)
        refuted = [c for c in tested if c.effect == UNKNOWN and not any(c is k for k in kept)]
        search.refuted += [c for c in refuted if not search.out(c.main.regressor)]
        gone = [c for c in believed if not any(c is k for k in kept)]
        functions = [c for c in gone if c.effect == UNKNOWN]
        if len(functions) in (0, len(gone)):
            return kept
        chosen = [c for c in believed if not any(c is f for f in functions)]


def _tested_again(search: Search, tested: Sequence[Chosen], kept: list[Chosen], price: float) -> list[Chosen]:
    """Effects that were not refuted, with the names that were refuted only because another stood beside them that was
    refuted as well.
    """
    gone = [c for c in tested if not any(c is k for k in kept)]
    if len(gone) < 2:
        return kept
    for effect in gone:
        with_it = [*kept, effect]
        if (
            effect.effect != UNKNOWN
            and effect in pruned(search, with_it, price)
            and not_refuted(search.model, with_it) == with_it
        ):
            kept = with_it
    return kept


def pruned(search: Search, chosen: Sequence[Chosen], price: float, keep: int = 1) -> list[Chosen]:
    """Effects without those that the others have made unnecessary; ``keep`` of them at least."""
    current = list(chosen)
    while len(current) > keep:
        whole = float(search.density(current).sum())
        left = [without(current, c, search.model.problem.lacking) for c in current]
        losses = [whole - float(search.to_be_beaten(rest).sum()) for rest in left]
        losses = [loss - description(search.model, c) for loss, c in zip(losses, current, strict=True)]
        least = int(np.argmin(losses))
        if losses[least] > price:
            break
        current = left[least]
    return current


def _trifles(search: Search) -> list[Chosen]:
    """What gains its price beside the model and is too small to be reported: a jerk at each corner of the speed must
    not set the price of what acts elsewhere.
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


def _believed(search: Search, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without those that, had other points been run, would as soon not have been found."""
    current = list(chosen)
    while current:
        whole = search.density(current)
        others = [search.to_be_beaten(without(current, c, search.model.problem.lacking)) for c in current]
        costs = [np.array([description(search.model, c), 0.0]) for c in current]
        drawn = [weights(np.array([whole, w]), search.seed, c) for w, c in zip(others, costs, strict=True)]
        share = [_odds(weight, c) for weight, c in zip(drawn, current, strict=True)]
        worst = int(np.argmin(share))
        if share[worst] > 0.5:
            break
        current = without(current, current[worst], search.model.problem.lacking)
    return current


def _odds(share: FloatArray, chosen: Chosen) -> float:
    """Probability of an effect against nothing; before anything is measured a free function is less likely than a
    name.
    """
    prior = prior_of(chosen)
    return float(prior * share[0] / (prior * share[0] + share[1]))


def _above_the_rest(search: Search, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without the names that are no larger than a few times what is left without an explanation, where
    something without a name is there, or more is left than noise: such a name is as likely a part of that as itself,
    unless it is independent of that.
    """
    model = search.model
    fitted = model.refitted(chosen)
    rows = model.problem.rows.take(model.problem.train)
    beyond = beyond_noise(model, chosen, fitted)
    rest = float(np.sqrt(beyond * np.sum(model.noise.sigma**2 * rows.number) / rows.number.sum())) / model.floor
    # in an integral slow noise adds up to more than the noise of a sample
    little = rest < 1.0 or model.problem.spec.integral
    if little and all(c.effect != UNKNOWN for c in chosen):
        return list(chosen)
    least = criteria.OVER_THE_REST * rest
    return [
        c
        for c in chosen
        if c.effect == UNKNOWN or _strength_among(search, chosen, c).overall > least or independent(search, chosen, c)
    ]


def no_mere_form(search: Search, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without the functions that may be what a name's form leaves of nature's: those that are smaller than its
    form may be off, and depend on a quantity of the name. Tables with a name of their own are such functions as well
    where they depend on a quantity of the same kind: while a gearbox warms up, time says what its temperature does.
    So is a function of how the campaign or a motion went on, beside a name that depends on that, where it lies row by
    row within what the form may be off.
    """
    names = [c for c in chosen if c.effect != UNKNOWN]

    def like(one: Chosen) -> list[Chosen]:
        if one.effect == UNKNOWN:
            return [c for c in names if _quantities(c) & _quantities(one)]
        if isinstance(one.main.regressor, Free):
            of = kinds_of(one.main.regressor)
            return [c for c in names if c is not one and kinds_of(c.main.regressor) & of]
        return []

    def size(one: Chosen) -> float:
        return _strength_among(search, chosen, one).acts

    def is_form(one: Chosen) -> bool:
        largest = max((size(name) for name in like(one)), default=0.0)
        if largest > 0.0 and size(one) < criteria.SHAPE * largest:
            return True
        if one.effect != UNKNOWN or not KINDS[COURSE].issuperset(kinds(one.main.regressor)):
            return False
        return _within_forms(search, chosen, one, [c for c in names if COURSE in kinds_of(c.main.regressor)])

    return [c for c in chosen if not is_form(c)]


def _within_forms(search: Search, chosen: Sequence[Chosen], one: Chosen, names: Sequence[Chosen]) -> bool:
    """Whether most of what a function adds lies, row by row, within what the forms of ``names`` may be off there."""
    if not names:
        return False
    model = search.model
    rows, train = model.problem.rows, model.problem.train
    fitted = model.refitted(chosen)

    def energy_of(effect: Chosen) -> FloatArray:
        course = model.contribution(effect, rows.frame, fitted)[train]
        return np.asarray(model.calibration.beyond(course) ** 2 * rows.number[train])

    energy = energy_of(one)
    allowed = (FORM_ERRORS * criteria.SHAPE) ** 2 * sum(energy_of(name) for name in names)
    return float(np.maximum(energy - allowed, 0.0).sum()) < criteria.EITHER * float(energy.sum())


def no_name_at_its_end(search: Search, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without the names at the top of their range that stand beside a function without a name of the same
    quantities. There a term turns into another, and the function says which: what decays over a longer way than
    pre-sliding can is none.
    """
    frame = search.model.problem.rows.frame

    def is_part(one: Chosen) -> bool:
        if one.effect == UNKNOWN or one.nominal or not at_longest(one.main.regressor, frame):
            return False
        functions = [c for c in chosen if c.effect == UNKNOWN and _way(c) == _way(one)]
        without_it = [c for c in chosen if c is not one]
        without_them = [c for c in chosen if not any(c is f for f in functions)]
        # a name that says more by itself than the function does is no part of it
        return bool(functions) and float((search.density(without_it) - search.density(without_them)).sum()) >= 0.0

    return [c for c in chosen if not is_part(c)]


def _way(one: Chosen) -> frozenset[str]:
    """Quantities of an effect, the distance since a start and that since a reversal as one."""
    return frozenset(SINCE if name in SINCE_A_START_OR_REVERSAL else name for name in _quantities(one))


def _quantities(one: Chosen) -> set[str]:
    """What an effect depends on, loads and speeds without their signs."""
    return {UNSIGNED.get(name, name) for name in kinds(one.main.regressor)}


def _that_add(search: Search, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without the functions without a name that change nothing: without them the others, fitted again, say the
    same. A function of the load beside an error of the load may be its opposite.
    """
    current = list(chosen)
    while True:
        sizes = {
            k: added(replace(search.model, chosen=without(current, c, search.model.problem.lacking)), c).overall
            for k, c in enumerate(current)
            if c.effect == UNKNOWN
        }
        smallest = min(sizes, key=lambda k: sizes[k], default=None)
        if smallest is None or sizes[smallest] >= criteria.LEAST_OVERALL:
            return current
        current = without(current, current[smallest], search.model.problem.lacking)


def _strength_among(search: Search, chosen: Sequence[Chosen], one: Chosen) -> Strength:
    """How strong one of some effects is beside the others."""
    others = [c for c in chosen if c is not one]
    return strength(replace(search.model, chosen=others), one)
