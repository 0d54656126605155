"""What takes an effect's place: a name that of a free function, a free function that of a name, or nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bench.mismatch import criteria
from bench.mismatch.regression.beside import chance_of, differs_from_zero, free_function, handicap_of, in_its_form
from bench.mismatch.regression.description import description
from bench.mismatch.regression.equivalent import draws_wave, explains_most, foresees, shapes_of
from bench.mismatch.regression.heredity import laws, without
from bench.mismatch.regression.model import Block, ChannelModel, Chosen, add_block, sum_of_blocks
from bench.mismatch.regression.one_law import one_or_two
from bench.mismatch.regression.one_way import named_by_course
from bench.mismatch.regression.pruning import no_mere_form, no_name_at_its_end
from bench.mismatch.regression.refine import strained
from bench.mismatch.regression.refuted import borne_out, forget, without_a_name
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, by_definition
from bench.mismatch.regression.search import next_best
from bench.mismatch.regression.slots import Contender, Slot, slots
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.strength import active_size
from bench.mismatch.regression.taken_over import without_taken_over


def settle(search: Search) -> list[Slot]:
    """Let a name take the place of a free function that is less probable than it, of another name that is far less
    probable, or of what says the same with more numbers; a free function that of a name or of another function which
    it leaves next to no probability; and nothing that of one less probable than nothing. The slots of the effects that
    are left and that recordings held out bear out. In place of a function that they refute the next best is asked, in
    the same way.
    """
    while True:
        found = _succeeded(search)
        model = search.model
        chosen = borne_out(model)
        gone = [c for c in model.chosen if not any(c is k for k in chosen)]
        if not gone:
            found = _plainest_first(search, found)
            forget(search.model)
            return found
        search.model = replace(model, chosen=chosen, fit=model.refitted(chosen))
        known = len(search.refuted)
        search.refuted += [c for c in gone if c.effect == UNKNOWN]
        next_best(search, known)


def _succeeded(search: Search) -> list[Slot]:
    """The slots of the effects when each has what takes its place."""
    without_taken_over(search)
    one_or_two(search)
    _name_by_course(search)
    _without_needless_corrections(search)
    found = slots(search)
    # two effects may take each other's place for ever; one that goes leaves a smaller model
    exchanges = 2 * len(search.model.chosen)
    while True:
        model = search.model
        successors = (successor for slot in found if (successor := _succession(model, slot)) is not None)
        chosen = next((s for s in successors if exchanges > 0 or len(s) < len(model.chosen)), None)
        if chosen is None:
            doubtful = _least_sure(model) or _less_than_its_correction(model)
            chosen = no_name_at_its_end(search, model.chosen) if doubtful is None else _in_its_place(search, doubtful)
            if doubtful is None and len(chosen) == len(model.chosen):
                return found
        exchanges -= 1
        chosen = no_mere_form(search, chosen)
        search.model = replace(model, chosen=chosen, fit=model.refitted(chosen))
        if exchanges > 0:
            one_or_two(search)
        _name_by_course(search)
        _without_needless_corrections(search)
        found = slots(search)


def _without_needless_corrections(search: Search) -> None:
    """Names of the model without the corrections of their forms where points left out are predicted as well without:
    a correction takes from what the term's own numbers say, and widens them.
    """
    for k, effect in enumerate(list(search.model.chosen)):
        model = search.model
        others = [c for i, c in enumerate(model.chosen) if i != k]
        plain, _ = in_its_form(search, others, effect, search.density(model.chosen))
        if plain is not effect:
            chosen = [*model.chosen[:k], plain, *model.chosen[k + 1 :]]
            search.model = replace(model, chosen=chosen, fit=model.refitted(chosen))


def _name_by_course(search: Search) -> None:
    """Tables of the model under the names that their courses have beside all else that was found."""
    model = search.model
    chosen = list(model.chosen)
    for k, effect in enumerate(model.chosen):
        chosen[k] = named_by_course(model, [c for c in chosen if c is not effect], effect, model.fit)
    search.model = replace(model, chosen=chosen)


def _plainest_first(search: Search, found: list[Slot]) -> list[Slot]:
    """The slots when each name that has an alternative with fewer numbers, as good as itself, has given it its place
    and is an alternative of it. It is the last thing that is done: no other rule is asked of who comes first of two.
    """
    chosen = list(search.model.chosen)
    for slot in found:
        simpler = _simpler(search, slot)
        if simpler is not None:
            chosen = [simpler.chosen if c is slot.chosen else c for c in chosen]
    if chosen == search.model.chosen:
        return found
    model = replace(search.model, chosen=chosen, fit=search.model.refitted(chosen))
    if len(borne_out(replace(model, notes=[]))) < len(chosen):
        return found
    search.model = model
    return slots(search)


def _simpler(search: Search, slot: Slot) -> Contender | None:
    """Of the names that are as good as a slot's and say its effect with fewer numbers the one that predicts best, if it
    does so within its standard error (the one-standard-error rule: :data:`criteria.ONE_ERROR`) and by more than chance.
    """
    own = slot.chosen.main.regressor
    if not isinstance(own, Named) or slot.chosen.nominal:
        return None
    least = search.scans[-1].p_value if search.scans else lambda _: slot.p_value
    fewer = [
        r
        for r in slot.alternatives
        if isinstance(r.chosen.main.regressor, Named)
        and r.as_good
        and r.chosen.main.regressor.numbers < own.numbers
        and r.loss <= criteria.ONE_ERROR * r.error
        and least(slot.gain - r.loss) <= criteria.ERROR_RATE
        and handicap_of(search, r.chosen) == 0.0
    ]
    return min(fewer, key=lambda r: r.loss, default=None)


def without_empty_laws(search: Search, found: Sequence[Slot]) -> list[Slot]:
    """Slots without those of laws that may as well be nothing and that only their changes ask for: beside a change,
    which stays, points left out are predicted as well without them.
    """
    for slot in found:
        model, effect = search.model, slot.chosen
        changed = any(effect.effect in laws(c.main.regressor) for c in model.chosen if c is not effect)
        if (
            not isinstance(effect.main.regressor, Named)
            or not changed
            or differs_from_zero(*model.fit.of(effect.main.indices))
        ):
            continue
        others = [c for c in model.chosen if c is not effect]
        loss = float((search.density(model.chosen) - search.density(others)).sum())
        if loss <= description(model, effect) + model.price:
            search.model = replace(model, chosen=others, fit=model.refitted(others))
    return [slot for slot in found if slot.chosen in search.model.chosen]


def _succession(model: ChannelModel, slot: Slot) -> list[Chosen] | None:
    """Effects with what takes a slot's place, or with nothing there; None where the slot's effect stays."""
    others = without(model.chosen, slot.chosen, model.problem.lacking)
    if slot.needless or _drawn_by_the_unknown(model, slot.chosen) or _by_chance(slot):
        return others
    if slot.plainer is not None:
        return [*others, slot.plainer.chosen]
    foreseeing = _foreseeing(model, slot, others)
    if foreseeing is not None:
        return [*others, foreseeing]
    alternatives = [r for r in slot.alternatives if not foresees(model, others, slot.chosen, r.chosen)]
    best = max((r for r in alternatives if r.chosen.effect != UNKNOWN), key=lambda r: r.weight, default=None)
    nameless = max((r for r in alternatives if r.chosen.effect == UNKNOWN), key=lambda r: r.weight, default=None)
    if nameless is not None and (_disowned(slot, nameless) or _part_of_the_unknown(model, slot, nameless)):
        return [*others, nameless.chosen]
    if nameless is not None and slot.chosen.effect == UNKNOWN and slot.weight < criteria.AS_GOOD * nameless.weight:
        return [*others, nameless.chosen]  # of two functions without a name the one that predicts better
    nothing = 1.0 - slot.weight - sum(r.weight for r in slot.alternatives)
    # whichever function it is: what they say in common is that no name does
    unnamed = slot.weight + (0.0 if nameless is None else nameless.weight)
    if slot.chosen.effect != UNKNOWN and not slot.chosen.nominal:
        likeliest = max((r.weight for r in slot.alternatives), default=0.0)
        if nothing > max(slot.weight, likeliest):
            return others
        # refined beside all else another name may predict far better than the one that was found first
        if best is None or strained(best.chosen.main.regressor, model.problem.rows.frame):
            return None
        return [*others, best.chosen] if slot.weight < criteria.AS_GOOD * best.weight else None
    if slot.chosen.effect != UNKNOWN or unnamed >= max(nothing, 0.0 if best is None else best.weight):
        return None
    others = [c for c in model.chosen if c is not slot.chosen]
    if best is None or best.weight <= nothing:
        return others
    # beside another function without a name that name would be a part of the unknown again
    beside = any(without_a_name(c) for c in others)
    return [*others, best.chosen] if best.surely_better or not beside or explains_most(model, best.chosen) else None


def _foreseeing(model: ChannelModel, slot: Slot, others: Sequence[Chosen]) -> Chosen | None:
    """The name that takes the place of a table that it foresees better than; None where there is none."""
    names = (r.chosen for r in slot.alternatives if foresees(model, others, r.chosen, slot.chosen))
    return next((c for c in names if not strained(c.main.regressor, model.problem.rows.frame)), None)


def _least_sure(model: ChannelModel) -> Chosen | None:
    """The effect that is least surely more than nothing, as recordings differ; None where all are sure. What rows of
    one recording share, a start or a zero of its own, makes rows as sure of an effect as if each said so. A name is
    asked by its own numbers: a correction of its form that is sure where they are not is another function.
    """
    model.compare_recordings()
    least: tuple[float, Chosen] | None = None
    for effect in model.chosen:
        regressor, indices = effect.main.regressor, effect.main.indices
        if effect.nominal or (isinstance(regressor, Named) and regressor.form.shares):
            continue  # of a term with the coefficient of another only the shape is its own
        coefficients, covariance = model.fit.of(indices)[0], model.covariance(indices)
        if not differs_from_zero(coefficients, covariance):
            chance = chance_of(coefficients, covariance)
            least = max((chance, effect), least or (-1.0, effect), key=lambda item: item[0])
    return None if least is None else least[1]


def _less_than_its_correction(model: ChannelModel) -> Chosen | None:
    """A name that says less than the correction of its form; None where there is none. A correction may be a fifth of
    the name (:data:`criteria.SHAPE`), but many rows say more than any prior.
    """

    shaped = ((c, c.shape) for c in model.chosen if c.shape is not None and not c.nominal)
    return next((c for c, shape in shaped if _size(model, shape) > _size(model, c.main)), None)


def _in_its_place(search: Search, doubtful: Chosen) -> list[Chosen]:
    """Effects of the model with what stands in the place of one whose own numbers may be nothing, or say less than the
    correction of its form: the function that this draws, if it is sure, under the name that such a function has by
    definition, or none.
    """
    model = search.model
    others = without(model.chosen, doubtful, model.problem.lacking)
    if doubtful.shape is None:
        return others
    shape, indices = doubtful.shape.regressor, doubtful.shape.indices
    assert isinstance(shape, Free)
    if not differs_from_zero(model.fit.of(indices)[0], model.covariance(indices)):
        return others
    over = {name for grid in shape.grids for name in grid.over}
    effect = by_definition(shape.channel, over.pop(), shape.times) if len(over) == 1 else UNKNOWN
    function = replace(shape, effect=effect)
    if search.out(function) or any(c.effect == effect != UNKNOWN for c in others):
        return others
    return [*others, free_function(search, others, add_block(model.problem, model.bank, function))]


def _by_chance(slot: Slot) -> bool:
    """Whether what an effect gains beside all others is no more than noise gains in a search: it was found before they
    were.
    """
    return not slot.chosen.nominal and slot.p_value > criteria.ERROR_RATE


def _disowned(slot: Slot, nameless: Contender | None) -> bool:
    """Whether a free function leaves a name too little probability to be told."""
    if nameless is None or slot.chosen.effect == UNKNOWN or slot.chosen.nominal:
        return False
    named = slot.weight + sum(r.weight for r in slot.alternatives if r.chosen.effect != UNKNOWN)
    return named < criteria.AS_GOOD * nameless.weight


def _drawn_by_the_unknown(model: ChannelModel, effect: Chosen) -> bool:
    """Whether a name stands beside a function without one that draws whatever form it may have: the two are one
    function, which no name says. A wave over the angle has one form: it is drawn by such a function that is at least
    half as large.
    """
    regressor = effect.main.regressor
    if not isinstance(regressor, Named) or regressor.term.nominal:
        return False
    forms = set(regressor.term.shape_of(model.channel, regressor.form))
    if forms:
        return any(forms <= shapes_of(c) for c in model.chosen if c.effect == UNKNOWN)
    drawing = [c for c in model.chosen if draws_wave(c, regressor)]
    return any(_size(model, *c.blocks) >= criteria.EITHER * _size(model, *effect.blocks) for c in drawing)


def _size(model: ChannelModel, *blocks: Block) -> float:
    """Size of fitted blocks beyond what the calibrated simulation can say of them, where they act."""
    rows, train = model.problem.rows, model.problem.train
    course = sum_of_blocks(blocks, model.fit, rows.frame)[train]
    return active_size(model.calibration.beyond(course), rows.number[train])


def _part_of_the_unknown(model: ChannelModel, slot: Slot, nameless: Contender) -> bool:
    """Whether a name beside a function without one says no more than a second such function: physics that no name has
    is met in part by a name that comes near. It has to be better by more than the points left out scatter.
    """
    if slot.chosen.effect == UNKNOWN or slot.chosen.nominal:
        return False
    beside = any(without_a_name(c) for c in model.chosen)
    return beside and not nameless.surely_worse
