"""Whether two explanations of an effect say the same: with fewer numbers, as a case of the other, or but for a form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.folds import squares
from bench.mismatch.regression.model import ChannelModel, Chosen
from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, Regressor
from bench.mismatch.regression.strength import active_size, size_of, trusted
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import ANGLE, kind_of

EXACT = 1e-12
"""share of its energy that is left of a column drawn exactly by others: rounding"""


def heirs_of(
    model: ChannelModel, others: Sequence[Chosen], contenders: Sequence[Chosen]
) -> tuple[dict[int, int], bool]:
    """Of contenders for a place, for which of them which name says the same with fewer numbers: their predictions
    differ by less than any transducer of the channel is trusted with. However sure the recordings are of so small a
    difference, it is the transducers' and disproves no name. Nor does a function without a name that differs by no more
    than nature's form of the name may, and, where names have corrections of their forms, by what is too small to be
    told for itself. And whether nothing in the place of the first differs by less than transducers are trusted with.
    """
    problem = model.problem
    least = trusted(model)
    # no name has a correction of its form there, which would say by how much nature's differs
    uncorrected = model.noise.independent_rows is not None
    number = problem.rows.number[problem.train]

    def same(one: FloatArray, other: FloatArray) -> bool:
        return apart(one, other) < least

    nothing = _predicted(model, others)

    def apart(one: FloatArray, name: FloatArray) -> float:
        return active_size(one - name, number)

    def but_for_a_form(one: FloatArray, name: FloatArray) -> bool:
        alike = apart(one, name) < criteria.SHAPE * active_size(name - nothing, number)
        return alike and (uncorrected or not size_of(model, one - name).enough)

    predictions = [_predicted(model, [*others, one]) for one in contenders]
    numbers = [numbers_of(c) for c in contenders]
    names = sorted((k for k, c in enumerate(contenders) if c.effect != UNKNOWN), key=lambda k: numbers[k])
    out: dict[int, int] = {}
    for k, prediction in enumerate(predictions):
        plainer = [i for i in names if numbers[i] < numbers[k] and holds(problem, contenders[k], contenders[i])]
        heir = next((i for i in plainer if same(prediction, predictions[i])), None)
        if heir is None and contenders[k].effect == UNKNOWN:
            near = [i for i in plainer if but_for_a_form(prediction, predictions[i])]
            heir = min(near, key=lambda i: apart(prediction, predictions[i]), default=None)
        if heir is not None:
            out[k] = heir
    return out, same(predictions[0], nothing)


def holds(problem: ChannelProblem, richer: Chosen, plain: Chosen) -> bool:
    """Whether a name is a case of another explanation: of a function without a name, of another form of the effect, of
    an effect whose columns draw its own exactly and more.

    Two effects that these recordings do not tell apart are no such case, however alike: they are ambiguous.
    """
    if richer.effect in (UNKNOWN, plain.effect):
        return True
    fewer, more = (c.main.regressor.columns(problem.rows.frame)[problem.train] for c in (plain, richer))
    if more.shape[1] <= fewer.shape[1]:
        return False
    left = fewer - more @ np.linalg.lstsq(more, fewer, rcond=None)[0]
    return bool(np.sum(left**2) <= EXACT * np.sum(fewer**2))


def explains_most(model: ChannelModel, name: Chosen) -> bool:
    """Whether a name in the place of all functions without one leaves no more of what these say than nature's form of
    the name may differ from the library's.
    """
    number = model.problem.rows.number[model.problem.train]
    named = [c for c in model.chosen if c.effect != UNKNOWN]
    whole, one, nothing = (_predicted(model, chosen) for chosen in (model.chosen, [*named, name], named))
    return active_size(whole - one, number) < criteria.SHAPE * active_size(whole - nothing, number)


def shapes_of(chosen: Chosen) -> set[tuple[str, str]]:
    """Kinds of quantities and factors of the tables that a free function is made of; none of a term."""
    free = chosen.main.regressor
    return (
        {(kind_of(name), grid.times) for grid in free.grids for name in grid.over} if isinstance(free, Free) else set()
    )


def draws_wave(function: Chosen, wave: Regressor) -> bool:
    """Whether a function without a name draws a term that is a wave over the output angle, such as gravity."""
    is_wave = isinstance(wave, Named) and wave.variables == (ANGLE,) and not wave.point
    return is_wave and function.effect == UNKNOWN and (ANGLE, "1") in shapes_of(function)


def foresees(model: ChannelModel, others: Sequence[Chosen], name: Chosen, table: Chosen) -> bool:
    """Whether a name predicts points left out with less than half of the squares of a table (:func:`worse_by`)."""
    return worse_by(model, others, name, table) * criteria.EITHER > 1.0


def worse_by(model: ChannelModel, others: Sequence[Chosen], name: Chosen, table: Chosen) -> float:
    """Squares with which a table beside some others predicts points left out, over those of a name, in motion of no set
    points; nan elsewhere. There a point left out is often the only one that has been at its places: a table says
    nothing of them, and its density forgives it for knowing that (:func:`bench.mismatch.regression.folds.squares`).
    """
    regressors = name.main.regressor, table.main.regressor
    if not (isinstance(regressors[0], Named) and isinstance(regressors[1], Free) and model.problem.free):
        return float("nan")

    def left(one: Chosen) -> float:
        chosen = [*others, one]
        return float(squares(model.bank, model.blocks(chosen), model.folds, model.refitted(chosen).variance).sum())

    return left(table) / max(left(name), 1e-300)


def predict_alike(model: ChannelModel, others: Sequence[Chosen], effect: Chosen, other: Chosen) -> bool:
    """Whether two explanations predict what differs by next to nothing of what the first adds: evidence between them is
    that of their forms' corrections.
    """
    return _differ_by_less(model, others, effect, other, criteria.ALIKE**2)


def says_most_of(model: ChannelModel, others: Sequence[Chosen], effect: Chosen, other: Chosen) -> bool:
    """Whether another explanation, beside some others, predicts most of what an effect adds there: else it is another
    effect, which may act in a few recordings and gain as much.
    """
    return _differ_by_less(model, others, effect, other, criteria.EITHER)


def _differ_by_less(model: ChannelModel, others: Sequence[Chosen], effect: Chosen, other: Chosen, share: float) -> bool:
    """Whether two explanations beside some others differ by less than a ``share`` of the energy that the first adds."""
    number = model.problem.rows.number[model.problem.train]
    plain, one, two = (_predicted(model, chosen) for chosen in (others, [*others, effect], [*others, other]))
    return bool(np.sum(number * (one - two) ** 2) < share * np.sum(number * (one - plain) ** 2))


def untold(model: ChannelModel, others: Sequence[Chosen], effect: Chosen, other: Chosen) -> bool:
    """Whether two names predict so nearly the same that no rows could tell which of them there is: by what they differ
    over all rows that are fitted, each would be expected to gain less log density over the other than one has to be
    better by (:data:`criteria.VERY_STRONG`), were it the true one.

    Points left out may be predicted far worse by one of them even so, for it is less sure without these points: that
    tells how many numbers it has, and not that it is not there.
    """
    if UNKNOWN in (effect.effect, other.effect):
        return False
    one, two = (_predicted(model, chosen) for chosen in ([*others, effect], [*others, other]))
    return expected(model, one - two) < criteria.VERY_STRONG


def expected(model: ChannelModel, apart: FloatArray) -> float:
    """Log density that the true one of two explanations would be expected to gain over the other in the rows that are
    fitted (n,), by what they predict ``apart``.
    """
    white = model.bank.less_offsets(model.bank.whitening.apply(apart), model.fit.variance)
    return 0.5 * float(np.sum(white**2))


def _predicted(model: ChannelModel, chosen: Sequence[Chosen]) -> FloatArray:
    """What a model with some effects, fitted anew, says of the rows that are fitted (n,)."""
    return np.asarray(model.predict(model.problem.rows.frame, chosen, model.refitted(chosen))[model.problem.train])


def numbers_of(chosen: Chosen) -> int:
    """How many fitted numbers an explanation has."""
    return sum(block.regressor.numbers for block in chosen.blocks)
