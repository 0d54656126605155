"""What else could stand in an effect's place: every rival refitted there, and how sure the name is.

The rivals of an effect are the other names, the free functions, and nothing at all; each is refined beside the other
effects of the model, as the effect itself was, and predicts the points left out. Weights are those of
:func:`bench.mismatch.regression.folds.weights`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.auxiliary import of_auxiliary
from bench.mismatch.regression.beside import free_function, idle, shaped, sound_beside, told_from_nothing
from bench.mismatch.regression.choosing import price_of_course
from bench.mismatch.regression.description import description, prior_of
from bench.mismatch.regression.folds import apart, weights
from bench.mismatch.regression.heredity import laws, orphaned, without
from bench.mismatch.regression.model import ChannelModel, Chosen
from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.refine import strained
from bench.mismatch.regression.refuted import borne_out
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named
from bench.mismatch.regression.scan import Scan
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.strength import active_size, trusted
from bench.simulation.frame import FloatArray
from bench.simulation.terms import LIBRARY

MOST_RIVALS = 5
"""names, and as many free functions, that are refitted in an effect's place"""
RIVAL_OWN = 1e-6
"""share of a rival's energy beside the other effects from which it is looked at: less than of an effect that is told,
for a
design that hardly shows a rival is the very one that cannot exclude it"""
EXACT = 1e-12
"""share of its energy that is left of a column drawn exactly by others: rounding"""
WORTH_A_LOOK = 0.2
"""of the best gain beside the other effects, that a rival's has to be before it is refined"""


@dataclass(frozen=True, slots=True)
class Contender:
    """A rival in an effect's place: log predictive density (folds,), what it loses in all, its standard error, weight,
    whether the recordings cannot tell it from the effect.
    """

    chosen: Chosen
    density: FloatArray
    loss: float
    error: float
    weight: float
    as_good: bool


@dataclass(frozen=True, slots=True)
class Slot:
    """An effect with its rivals, best first: gain of log predictive density over nothing, p-value, weight of its
    name; of the rivals the ``plainer`` name that says the same as far as transducers are trusted; whether it is
    ``needless``: without it nothing differs by more than that.
    """

    chosen: Chosen
    gain: float
    p_value: float
    weight: float
    rivals: tuple[Contender, ...]
    plainer: Contender | None = None
    needless: bool = False


def slots(search: Search) -> list[Slot]:
    """Every effect of the found model with its rivals."""
    model = search.model
    whole = search.density(model.chosen)
    return [_slot(search, chosen, whole, number) for number, chosen in enumerate(model.chosen)]


def settle(search: Search) -> list[Slot]:
    """Let a name take the place of a free function that is less probable than it, or of what says the same with more
    numbers, a free function that of a name or of another function which it leaves next to no probability, and nothing
    that of one less probable than nothing; the slots of the effects that are left and that recordings held out bear
    out.
    """
    found = slots(search)
    for _ in range(2 * len(search.model.chosen)):
        model = search.model
        chosen = next((own for slot in found if (own := _succession(model, slot)) is not None), None)
        if chosen is None:
            break
        search.model = replace(model, chosen=chosen, fit=model.refitted(chosen))
        found = slots(search)
    model = search.model
    chosen = borne_out(model)
    if len(chosen) < len(model.chosen):
        search.model = replace(model, chosen=chosen, fit=model.refitted(chosen))
        found = slots(search)
    return found


def _succession(model: ChannelModel, slot: Slot) -> list[Chosen] | None:
    """Effects with what takes a slot's place, or with nothing there; None where the slot's effect stays."""
    others = without(model.chosen, slot.chosen, model.problem.lacking)
    if slot.needless or _drawn_by_the_unknown(model, slot.chosen):
        return others
    if slot.plainer is not None:
        return [*others, slot.plainer.chosen]
    best = max((r for r in slot.rivals if r.chosen.effect != UNKNOWN), key=lambda r: r.weight, default=None)
    nameless = max((r for r in slot.rivals if r.chosen.effect == UNKNOWN), key=lambda r: r.weight, default=None)
    if nameless is not None and (_disowned(slot, nameless) or _part_of_the_unknown(model, slot, nameless)):
        return [*others, nameless.chosen]
    if nameless is not None and slot.chosen.effect == UNKNOWN and slot.weight < criteria.AS_GOOD * nameless.weight:
        return [*others, nameless.chosen]  # of two functions without a name the one that predicts better
    nothing = 1.0 - slot.weight - sum(r.weight for r in slot.rivals)
    # whichever function it is: what they say in common is that no name does
    unnamed = slot.weight + (0.0 if nameless is None else nameless.weight)
    if slot.chosen.effect != UNKNOWN or unnamed >= max(nothing, 0.0 if best is None else best.weight):
        return None
    others = [c for c in model.chosen if c is not slot.chosen]
    return [*others, best.chosen] if best is not None and best.weight > nothing else others


def without_empty_laws(search: Search, found: Sequence[Slot]) -> list[Slot]:
    """Slots without those of laws that may as well be nothing and that only their changes ask for: beside a change,
    which stays, points left out are predicted as well without them.
    """
    for slot in found:
        model, own = search.model, slot.chosen
        changed = any(own.effect in laws(c.main.regressor) for c in model.chosen if c is not own)
        if not isinstance(own.main.regressor, Named) or not changed or told_from_nothing(*model.fit.of(own.main.place)):
            continue
        others = [c for c in model.chosen if c is not own]
        loss = float((search.density(model.chosen) - search.density(others)).sum())
        if loss <= description(model, own) + model.price:
            search.model = replace(model, chosen=others, fit=model.refitted(others))
    return [slot for slot in found if slot.chosen in search.model.chosen]


def _disowned(slot: Slot, nameless: Contender | None) -> bool:
    """Whether a free function leaves a name too little probability to be told."""
    effect = slot.chosen.effect
    if nameless is None or effect == UNKNOWN or (effect in LIBRARY and LIBRARY[effect].nominal):
        return False
    named = slot.weight + sum(r.weight for r in slot.rivals if r.chosen.effect != UNKNOWN)
    return named < criteria.AS_GOOD * nameless.weight


def _drawn_by_the_unknown(model: ChannelModel, own: Chosen) -> bool:
    """Whether a name stands beside a function without one that draws whatever form it may have: the two are one
    function, which no name says.
    """
    regressor = own.main.regressor
    if not isinstance(regressor, Named) or regressor.term.nominal:
        return False
    forms = set(regressor.term.shape.get(model.channel, ()))
    free = (c.main.regressor for c in model.chosen if c.effect == UNKNOWN)
    drawn = [{(name, grid.times) for grid in f.grids for name in grid.over} for f in free if isinstance(f, Free)]
    return bool(forms) and any(forms <= functions for functions in drawn)


def _part_of_the_unknown(model: ChannelModel, slot: Slot, nameless: Contender) -> bool:
    """Whether a name beside a function without one says no more than a second such function: physics that no name has
    is met in part by a name that comes near. It has to be better by more than the points left out scatter.
    """
    effect = slot.chosen.effect
    if effect == UNKNOWN or (effect in LIBRARY and LIBRARY[effect].nominal):
        return False
    beside = any(c.effect == UNKNOWN and not of_auxiliary(c.main.regressor) for c in model.chosen)
    return beside and nameless.loss < criteria.BESIDE_UNKNOWN_ERRORS * nameless.error


def _slot(search: Search, own: Chosen, whole: FloatArray, number: int) -> Slot:
    model = search.model
    others = without(model.chosen, own, model.problem.lacking)
    fitted = model.refitted(others)
    seen = search.scan(others, fitted, least=RIVAL_OWN)
    nothing = search.density(others)
    gain = float((whole - nothing).sum())
    found = [c for c in _rivals(search, own, others, seen) if c.effect != own.effect or own.effect == UNKNOWN]
    if model.problem.free:
        found = [c for c in found if sound_beside(search, others, c.main, model.refitted([*others, c]))]
    densities = [search.density([*others, c]) for c in found]
    table = np.array([whole, *densities, nothing])
    # before anything is measured a name is likelier than a free function
    prior = np.array([_prior(model, c) for c in (own, *found)] + [1.0])
    costs = np.array([description(model, c) for c in (own, *found)] + [0.0])
    # a loop that was hardly turned is no likelier than the functions of the torque which it is like
    unturned = idle(search, own)
    prior[0] *= np.exp(-criteria.RICHER * unturned)
    share = prior * weights(table, search.seed + number, costs)
    share = share / share.sum()
    heirs, needless = _heirs(model, others, (own, *found))
    for k in sorted(heirs, key=lambda k: -_numbers((own, *found)[k])):
        share[heirs[k]] += share[k]
        share[k] = 0.0

    def worth(probability: float, chosen: Chosen) -> float:
        # at the end of its range a term turns into another
        turned = strained(chosen.main.regressor, model.problem.rows.frame)
        return probability * (criteria.EITHER if turned else 1.0)

    rivals: list[Contender] = []
    for k, (chosen, density) in enumerate(zip(found, densities, strict=True)):
        loss, error = apart(whole, density)
        odds = worth(share[k + 1], chosen) / max(worth(share[0], own), 1e-300)
        near = unturned and _of_the_torque(chosen) and loss < gain - loss
        # what says with more numbers what the effect says is no other explanation
        if not near and heirs.get(k + 1) != 0:
            near = called_as_good(own, chosen, float(odds), loss)
            doubtful = chosen.effect != UNKNOWN and criteria.VERY_STRONG <= loss < 2.0 * criteria.VERY_STRONG
            near = near or (doubtful and _alike(model, others, own, chosen))
        rivals.append(Contender(chosen, density, loss, error, float(share[k + 1]), near))
    plainer = rivals[heirs[0] - 1] if 0 in heirs else None
    rivals.sort(key=lambda r: r.loss)
    last = search.scans[-1] if search.scans else seen
    return Slot(own, gain, last.p_value(gain), float(share[0]), tuple(rivals), plainer, needless)


def _numbers(chosen: Chosen) -> int:
    return sum(block.regressor.numbers for block in chosen.blocks)


def _heirs(model: ChannelModel, others: Sequence[Chosen], contenders: Sequence[Chosen]) -> tuple[dict[int, int], bool]:
    """Of contenders for a place, for which of them which name says the same with fewer numbers: their predictions
    differ by less than any transducer of the channel is trusted with. However sure the recordings are of so small a
    difference, it is the transducers' and disproves no name. And whether nothing in the place of the first does so.
    """
    problem = model.problem
    least = trusted(model)
    if least <= 0.0:
        return {}, False
    frame, train = problem.rows.frame, problem.train

    def predicted(own: Sequence[Chosen]) -> FloatArray:
        return np.asarray(model.predict(frame, own, model.refitted(own))[train])

    def same(one: FloatArray, other: FloatArray) -> bool:
        return active_size(one - other, problem.rows.number[train]) < least

    said = [predicted([*others, one]) for one in contenders]
    numbers = [_numbers(c) for c in contenders]
    names = sorted((k for k, c in enumerate(contenders) if c.effect != UNKNOWN), key=lambda k: numbers[k])
    out: dict[int, int] = {}
    for k, own in enumerate(said):
        plainer = (i for i in names if numbers[i] < numbers[k] and _holds(problem, contenders[k], contenders[i]))
        heir = next((i for i in plainer if same(own, said[i])), None)
        if heir is not None:
            out[k] = heir
    return out, same(said[0], predicted(others))


def _holds(problem: ChannelProblem, richer: Chosen, plain: Chosen) -> bool:
    """Whether a name is a case of another explanation: of a function without a name, of another form of the effect, of
    an effect whose columns draw its own exactly and more.

    Two effects that these recordings do not tell apart are no such case, however alike: they are ambiguous.
    """
    if richer.effect in (UNKNOWN, plain.effect):
        return True
    own, more = (c.main.regressor.columns(problem.rows.frame)[problem.train] for c in (plain, richer))
    if more.shape[1] <= own.shape[1]:
        return False
    left = own - more @ np.linalg.lstsq(more, own, rcond=None)[0]
    return bool(np.sum(left**2) <= EXACT * np.sum(own**2))


def _alike(model: ChannelModel, others: Sequence[Chosen], own: Chosen, other: Chosen) -> bool:
    """Whether two explanations predict what differs by next to nothing of what the first adds: evidence between them is
    that of their forms' corrections.
    """
    frame, train = model.problem.rows.frame, model.problem.train
    number = model.problem.rows.number[train]
    plain, one, two = (
        model.predict(frame, chosen, model.refitted(chosen))[train]
        for chosen in (others, [*others, own], [*others, other])
    )
    return bool(np.sum(number * (one - two) ** 2) < criteria.ALIKE**2 * np.sum(number * (one - plain) ** 2))


def called_as_good(own: Chosen, other: Chosen, odds: float, loss: float) -> bool:
    """Whether another explanation is not told apart from an effect: its ``odds`` against it, and its ``loss`` of log
    density at points left out.

    Between two names a small loss may be that of two forms, of which nature has neither.
    """
    both_named = UNKNOWN not in (own.effect, other.effect)
    return odds > criteria.AS_GOOD or (both_named and loss < criteria.VERY_STRONG)


def _of_the_torque(own: Chosen) -> bool:
    """Whether a name is a function of the torque: beside it a loop that was never turned is its form, not its path."""
    return own.effect != UNKNOWN and set(own.main.regressor.variables) <= {"torque", "load_motor_torque"}


def _prior(model: ChannelModel, chosen: Chosen) -> float:
    """Odds before anything is measured."""
    return prior_of(chosen) * float(np.exp(-price_of_course(model, chosen.main.regressor)))


def _rivals(search: Search, own: Chosen, others: Sequence[Chosen], seen: Scan) -> list[Chosen]:
    """Other explanations that come near, refined beside the other effects."""
    taken = {c.effect for c in others}
    named: dict[str, int] = {}
    free: dict[tuple[str, ...], int] = {}
    for k in np.argsort(-seen.gain):
        if seen.gain[k] < WORTH_A_LOOK * float(seen.gain.max()) or not np.isfinite(seen.gain[k]):
            break
        regressor = search.blocks[k].regressor
        if orphaned(regressor, taken, search.model.problem.lacking):
            continue
        if isinstance(regressor, Named):
            if regressor.effect not in taken and regressor.effect != own.effect and len(named) < MOST_RIVALS:
                named.setdefault(regressor.effect, int(k))
        elif len(free) < 2 and (own.main.regressor.variables != regressor.variables or own.effect != UNKNOWN):
            free.setdefault(regressor.variables, int(k))
    out = []
    for k in named.values():
        candidate = shaped(search, others, search.blocks[k].regressor)
        if candidate is not None:
            out.append(candidate)
    for k in free.values():
        block = search.blocks[k]
        if isinstance(block.regressor, Free) and _of_the_name(block.regressor, {own.effect, *taken} - {UNKNOWN}):
            continue
        out.append(free_function(search, others, block))
    return out


def _of_the_name(free: Free, effects: set[str]) -> bool:
    """Whether a free function is one of those by which nature's form of an effect may differ from the library's: it
    says nothing against the name.
    """
    own = {(name, grid.times) for grid in free.grids for name in grid.over}
    return any(
        effect == free.effect or own <= set(LIBRARY[effect].shape.get(free.channel, ()))
        for effect in effects
        if effect in LIBRARY
    )
