"""Which effects a channel needs: step by step, each the one that predicts points left out best, until none gains its
price.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.auxiliary import auxiliary_candidates, composed_candidates
from bench.mismatch.regression.bank import Bank
from bench.mismatch.regression.beside import chance_of, shaped
from bench.mismatch.regression.candidates import free_candidates, named_candidates, swing_candidates
from bench.mismatch.regression.choosing import best_candidate, hidden_pair
from bench.mismatch.regression.copies import copies, notes_of
from bench.mismatch.regression.description import description
from bench.mismatch.regression.heredity import without, without_laws
from bench.mismatch.regression.model import (
    Block,
    ChannelModel,
    Chosen,
    add_base,
    calibration,
    fit_blocks,
    kept_small,
    left_by,
    plain_residual,
    prepare_bank,
    widened,
)
from bench.mismatch.regression.prior import settled, zeros_settled
from bench.mismatch.regression.problem import NUISANCE, ChannelProblem
from bench.mismatch.regression.products import without_parts
from bench.mismatch.regression.pruning import concluded, pruned
from bench.mismatch.regression.regressors import Free, Named, Regressor
from bench.mismatch.regression.sign_blocks import units
from bench.mismatch.regression.state import Search
from bench.simulation.composed import parts_of
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import AUXILIARY

MOST_EFFECTS = 12
MOST_PASSED = 3
"""kinds of candidates that gain less than what is left might, and are passed over, before nothing more is looked for"""
MOST_REFUTED = 4
"""functions without a name that are refuted before no other is asked in their place any more"""
MOST_ASKED_AGAIN = 2 * MOST_REFUTED
"""the same of names: a function that was an alternative of a name may take its place, and be refuted, once more"""
MOST_ROUNDS = 4
"""times that the noise is read afresh from what the model leaves"""
QUIETER = 0.9
"""noise over that of the last round, or how wide it is taken, below which another round may find more"""
FAR_QUIETER = 0.5
"""noise over that which the model leaves, below which the simulation is calibrated anew beside what was found"""


def begun(problem: ChannelProblem, seed: int = 0, left: FloatArray | None = None, wider: float = 1.0) -> Search:
    """A search with the calibrated simulation alone; ``left`` (training rows,): the residual that tells the noise, if
    not the simulation's; the rows' noise is taken so many times ``wider``.
    """
    residual = plain_residual(problem) if left is None else left
    bank, samples, noise, folds = prepare_bank(problem, residual, wider)
    base = settled(problem, bank, add_base(problem, bank))
    variances = _variances(problem, bank)
    plain = fit_blocks(bank, base, variances)
    calibrated = calibration(problem, base, noise)
    model = ChannelModel(problem, bank, samples, noise, base, [], plain, variances, folds, calibrated)
    train = problem.train
    frame = problem.rows.frame.take(train)
    regressors: list[Regressor] = [
        *named_candidates(
            problem.channel, problem.rows.frame, problem.switched_off, problem.banned, problem.free, problem.cut
        ),
        *free_candidates(problem.channel, frame, problem.free, problem.states),
        *(swing_candidates(problem.channel, frame) if problem.swings else ()),
        *auxiliary_candidates(problem.channel, frame),
        *composed_candidates(problem.channel, frame, problem.angles),
    ]
    same = copies(problem)
    model.notes += notes_of(same)
    regressors = [r for r in regressors if not _depends(r, same)]
    if noise.independent_rows is not None:
        regressors = [without_laws(r, frame) if isinstance(r, Free) else r for r in regressors]
    blocks = []
    for regressor in regressors:
        columns = regressor.columns(problem.rows.frame)[train]
        if np.isfinite(columns).all() and np.any(columns):
            added = bank.add(columns)
            blocks.append(Block(regressor, added, np.zeros(len(added))))
    extra = np.array(
        [len(b.regressor.point) if isinstance(b.regressor, Named) else 0 for b in blocks], dtype=np.float64
    )
    if noise.independent_rows is not None:
        extra = np.array([description(model, Chosen(b)) for b in blocks])
    duration = max(criteria.BLOCK_S, 3.0 * noise.memory)
    if noise.independent_rows is not None:
        duration = criteria.BLOCK_MEMORIES * float(np.sum(frame.step)) / noise.independent_rows
    return _settle(Search(model, blocks, extra, units(frame.elapsed, bank.whitening.starts, duration), seed, []))


def _variances(problem: ChannelProblem, bank: Bank) -> tuple[float, ...]:
    """Variances of the recordings' offsets that are tried: pieces of one recording have none."""
    return (0.0,) if problem.cut and not problem.spec.integral else bank.variances()


def _depends(regressor: Regressor, names: Collection[str]) -> bool:
    """Whether a regressor depends on one of some auxiliary quantities."""
    names_of_quantities = (name.removeprefix(AUXILIARY) for name in regressor.variables if name.startswith(AUXILIARY))
    return bool(names) and any(part in names for name in names_of_quantities for part in parts_of(name))


def _settle(search: Search) -> Search:
    """The search with the effects that are in force, but of unknown form, part of the simulation."""
    for effect in search.model.problem.unsettled:
        model = search.model
        seen = search.scan([], model.refitted([]))
        forms = [k for k, b in enumerate(search.blocks) if b.regressor.effect == effect and np.isfinite(seen.gain[k])]
        best = max(forms, key=lambda k: float(seen.gain[k]), default=None)
        chosen = None if best is None else shaped(search, [], search.blocks[best].regressor)
        if chosen is None:
            model.notes.append(f"{effect} is in force without numbers, and nothing in these recordings calibrates it")
            continue
        base = [*model.base, chosen.main]
        fit, calibrated = fit_blocks(model.bank, base, model.variances), calibration(model.problem, base, model.noise)
        search.model = replace(model, base=base, fit=fit, calibration=calibrated)
        keep = [k for k, b in enumerate(search.blocks) if b.regressor.effect != effect]
        search.blocks, search.extra = [search.blocks[k] for k in keep], search.extra[keep]
    return search


def searched(problem: ChannelProblem, seed: int = 0) -> Search:
    """Search a channel for what the simulation lacks.

    While effects are still to be found a gain is priced by noise as the model has it; when nothing more is found, by
    the residual itself, whose noise may be of another kind, and what does not pay that price goes again.
    """
    search = begun(problem, seed)
    if search.model.noise.independent_rows is None:
        return _without_idle_nuisance(_resettled(next_best(concluded(_sought(search)), 0)))
    _forward(search)
    # only what a model leaves tells the noise: with a better model there is less of it, and more is found
    for _ in range(MOST_ROUNDS):
        again = begun(problem, seed, left_by(search.model))
        quieter = np.median(again.model.noise.sigma) <= QUIETER * np.median(search.model.noise.sigma)
        search = carried_over(search, again)
        if not quieter:
            break
        _forward(search)
    return as_noisy_as_left(next_best(concluded(search), 0))


def _without_idle_nuisance(search: Search) -> Search:
    """The search without what another channel has without a name, where that may as well be nothing here. It stands in
    no file: where it is like one of the simulation's terms, that would be calibrated beside it and used without it.
    """
    model = search.model
    if model.problem.spec.integral:
        return search
    free = [b for b in model.base if b.regressor.effect == NUISANCE and not kept_small(b)]
    # a column of nothing has no number
    indices = [i for b in free for i in b.indices if np.any(model.bank.columns.column(i))]
    if not free or (indices and chance_of(*model.fit.of(indices)) <= criteria.ERROR_RATE):
        return search
    base = [b for b in model.base if not any(b is one for one in free)]
    search.model = model = replace(model, base=base)
    model.fit = model.refitted(model.chosen)
    return search


def as_noisy_as_left(search: Search) -> Search:
    """The search with the noise that its model leaves, where that is far more than it was taken for: effects that went
    again had made it less, and what is left of them would calibrate the simulation.
    """
    again = begun(search.model.problem, search.seed, left_by(search.model))
    if np.median(search.model.noise.sigma) > FAR_QUIETER * np.median(again.model.noise.sigma):
        return search
    notes = [*search.model.notes, *(note for note in again.model.notes if note not in search.model.notes)]
    again = carried_over(search, again)
    again.model.notes, again.refuted = notes, search.refuted
    again.without_refuted()
    return concluded(again)


def _sought(search: Search) -> Search:
    """The search with its effects, where points left out tell what a number is worth.

    Where the recordings' means contradict the calibrated simulation, something acts inside the recordings that it
    cannot say, and would be calibrated by it. Effects are looked for with the rows' noise as wide as that. With what
    was found less is contradicted: as long as the means do not contradict narrower noise, names, and finer tables of
    what was found, are looked for again. (More functions without a name would follow what is left of the first.) Then
    the rows count in full, unless the means contradict what was found as well. Where nothing was found, rows in full
    are asked once: if they find what the means do not contradict, it is that which acts.
    """
    wider = _contradicted(search)
    if wider <= 1.0:
        _forward(search)
        return search
    wide = begun(search.model.problem, search.seed, None, wider)
    _forward(wide)
    if wide.model.chosen:
        wide, wider = _less_wide(wide, wider, search)
        search = carried_over(wide, search)
    else:
        _forward(search)
    if search.model.chosen and _contradicted(search) <= 1.0:
        if wide.model.chosen:
            search.scans = []
            _forward(search)
        return search
    wide.model.notes.append(
        "what is left inside the recordings contradicts their means: the noise of their rows is taken to be"
        f" {wider:.2g} times as large"
    )
    return wide


def _less_wide(wide: Search, wider: float, full: Search) -> tuple[Search, float]:
    """A search whose rows' noise is ``wider``, and that width, as narrow as the means allow beside what is found.
    ``full``: the search with the rows' noise as it is, into which effects are carried to see what the means contradict.
    """
    for _ in range(MOST_ROUNDS - 1):
        narrower = _contradicted(carried_over(wide, full))
        if not 1.0 < narrower <= QUIETER * wider:
            break
        again = carried_over(wide, begun(full.model.problem, full.seed, None, narrower))
        if _contradicted(again) > 1.0:
            break
        _forward(again, more_functions=False)
        wide, wider = again, narrower
    return wide, wider


def _contradicted(search: Search) -> float:
    """By how much the rows' noise has to be wider for the model that was found; 1 where it need not be."""
    model = search.model
    return 1.0 if model.problem.spec.integral else widened(model.bank, model.blocks(), model.fit)


def _resettled(search: Search) -> Search:
    """The search with sensors' zeros, and the prior of the offset's coefficients, as they are likely to be beside what
    was found, and its numbers refined anew. Effects are looked for beside zeros as large as data sheets allow: what may
    be one is no discovery.
    """
    model = search.model
    problem, bank, beside = model.problem, model.bank, [b for c in model.chosen for b in c.blocks]
    base = zeros_settled(problem, bank, model.base, beside)
    if beside:
        base = settled(problem, bank, base, beside)
    if all(np.array_equal(a.precision, b.precision) for a, b in zip(base, model.base, strict=True)):
        return search
    calibrated = calibration(problem, base, model.noise)
    search.model = model = replace(model, base=base, calibration=calibrated, variances=_variances(problem, bank))
    for k, effect in enumerate(list(model.chosen)):
        others = [c for i, c in enumerate(model.chosen) if i != k]
        again = shaped(search, others, effect.main.regressor) if isinstance(effect.main.regressor, Named) else None
        if again is not None:
            model.chosen[k] = again
    model.fit = model.refitted(model.chosen)
    return search


def next_best(search: Search, known: int) -> Search:
    """The search with what comes next where functions without a name were refuted, those after the first ``known``:
    what they stood before is asked like them; names alone, when many functions were refuted.
    """
    while known < len(search.refuted) < MOST_ASKED_AGAIN:
        more_functions = len(search.refuted) < MOST_REFUTED
        known = len(search.refuted)
        search.without_refuted()
        _forward(search, more_functions)
        search = concluded(search)
    return search


def carried_over(search: Search, to: Search) -> Search:
    """Another bank's search with the effects of this one."""
    model, bank = to.model, to.bank
    problem = model.problem

    def moved(block: Block) -> Block:
        indices = bank.add(block.regressor.columns(problem.rows.frame)[problem.train])
        return replace(block, indices=indices)

    chosen = [
        replace(c, main=moved(c.main), shape=None if c.shape is None else moved(c.shape)) for c in search.model.chosen
    ]
    to.model = replace(model, chosen=chosen, fit=model.refitted(chosen), price=search.model.price)
    to.scans = search.scans
    return to


def _forward(search: Search, more_functions: bool = True) -> None:
    model = search.model
    passed: list[Chosen] = []
    while len(model.chosen) < MOST_EFFECTS:
        seen = search.scan(model.chosen, model.fit)
        search.scans.append(seen)
        if len(search.scans) == 1:
            # beside a rich function noise gains more: that is the next effect's affair, not that of those found before
            model.price = seen.price
        found = best_candidate(search, seen, passed, more_functions)
        pair = hidden_pair(search, seen, more_functions) if found is None else []
        if pair:
            search.model = model = replace(model, chosen=[*model.chosen, *pair])
            model.fit = model.refitted(model.chosen)
            continue
        if found is None:
            break
        chosen = pruned(search, [*without_parts(model.chosen, found.main.regressor), found], model.price)
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
    if model.noise.independent_rows is None:
        return True
    others = without(chosen, found, model.problem.lacking)
    gain = float(search.density(chosen).sum() - search.to_be_beaten(others).sum()) - description(model, found)
    return gain >= search.scan(chosen, model.refitted(chosen), shuffled=True).price
