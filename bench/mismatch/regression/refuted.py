"""What points left out refute is not told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.recordings.rows import error_of_mean, hardly_acts
from bench.mismatch.regression.auxiliary import of_auxiliary
from bench.mismatch.regression.beside import differs_from_zero
from bench.mismatch.regression.candidates import PATH
from bench.mismatch.regression.excess import levelled
from bench.mismatch.regression.folds import carried, density, squares, weights
from bench.mismatch.regression.heredity import without
from bench.mismatch.regression.independent import beyond_floor
from bench.mismatch.regression.model import Block, ChannelModel, Chosen, explained, fit_blocks, of_start
from bench.mismatch.regression.noise import durations
from bench.mismatch.regression.problem import NUISANCE, WanderingZero
from bench.mismatch.regression.refine import strained
from bench.mismatch.regression.regressors import UNKNOWN
from bench.simulation.frame import FloatArray, Frame


def not_refuted(model: ChannelModel, chosen: Sequence[Chosen]) -> list[Chosen]:
    """Effects without those with which points left out are predicted worse than without them, by more log-likelihood
    than noise gains in a search.

    The search asks for density: a form that is sure of most points may be wild at others, and say so. What a model is
    for is prediction. Only points that may be fitted are asked: recordings held out score, and choose nothing. And
    against an effect only points that others can stand for: without the one warm-up of a campaign nothing is known of
    what a warm-up shows. One point alone refutes no name with which most others are predicted better: of two warm-ups
    either is predicted badly without the other.
    """
    current = list(chosen)
    while current:
        blocks = model.blocks(current)
        fitted = fit_blocks(model.bank, blocks, model.variances)

        def left(some: Sequence[Block], zeros: bool = False, at: float = fitted.variance) -> FloatArray:
            return squares(model.bank, some, model.folds, at, zeros)

        whole = left(blocks)
        found = []
        for c in current:
            others = model.blocks(without(current, c, model.problem.lacking))
            spared = carried(model.bank, blocks, c.main, model.folds, fitted) <= criteria.CANNOT_BE_SPARED
            one = c.effect != UNKNOWN
            worse = _worse(whole, left(others), spared, model.price, one)
            # a name may show in heating runs alone, whose zeros nothing tells: beside these it is asked again if it is
            # surely better, where it is not as wrong as it says it may be; a function without a name is whatever
            # follows these recordings
            gain = _sure_gain(model, blocks, others) if worse[0] > 0.0 and c.effect != UNKNOWN else None
            if gain is not None:
                worse = _worse(left(blocks, True), left(others, True), spared & (gain <= model.price), model.price, one)
            found.append(worse)
        worst = int(np.argmax([beyond for beyond, _ in found]))
        beyond, ratio = found[worst]
        if not beyond > 0.0:
            break
        gone, current = current[worst], without(current, current[worst], model.problem.lacking)
        note = (
            f"{_gained(gone)} likelihood, but points left out of the fit are predicted"
            f" {np.sqrt(ratio):.3g} times as badly with it: it is not reported"
        )
        if note not in model.notes:
            model.notes.append(note)
    return current


def _worse(
    whole: FloatArray, squared: FloatArray, spared: NDArray[np.bool_], price: float, but_one: bool = False
) -> tuple[float, float]:
    """Log-likelihood beyond a price by which points left out are predicted worse, of squares (folds,) with an effect
    and without it; and the ratio of the squares. Points that cannot be spared do not count against the effect; nor does
    the one that speaks against it the most, if it is ``but_one`` and most of the others are predicted better (sign
    test).
    """
    better = whole < squared
    counted = spared | better
    more = float(better.sum()) - float((counted & ~better).sum())
    if but_one and more > criteria.BESIDE_UNKNOWN_ERRORS * np.sqrt(counted.sum()):
        counted[np.argmax(np.where(counted, whole - squared, -np.inf))] = False
    ratio = float(whole[counted].sum()) / max(float(squared[counted].sum()), 1e-300)
    return 0.5 * float((whole - squared)[counted].sum()) - price, ratio


def _sure_gain(model: ChannelModel, blocks: Sequence[Block], others: Sequence[Block]) -> FloatArray | None:
    """Log density that some blocks gain over others at each point left out (folds,); None unless they would predict
    these better, had these been drawn again, but for the error rate.
    """
    if not model.problem.spec.integral or not any(b.regressor.effect == NUISANCE for b in blocks):
        return None
    densities = np.array([density(model, some) for some in (blocks, others)])
    if float(weights(densities, 0)[0]) < 1.0 - criteria.ERROR_RATE:
        return None
    return np.asarray(densities[0] - densities[1])


def borne_out(model: ChannelModel) -> list[Chosen]:
    """Effects of a model without those that recordings held out refute: they are predicted worse than without them.

    A function without a name claims nothing but that it predicts: it goes however little worse they are predicted, and
    where they are not predicted better by more than the standard error of the difference, if they should be by twice
    that and no more than noise is left without it. A name goes however little worse they are predicted as well: what is
    true takes its square off, so that it has to be nearly nothing before noise makes it worse. Where it adds less than
    half of what it adds to the fitted ones, they say nothing of it: a lag shows in warm-ups. It then goes only beside a
    function without a name, at the end of its range, or if its size may be nothing, and if they are worse by more than
    the standard error of the difference.
    Several functions without a name go together where recordings held out are predicted better without all of them.
    A function of a quantity that is no channel of the bench goes if they are worse by more than the standard error: it
    may stand for another machine that acts on this one.
    A name that predicts better within recordings stays: their levels differ by themselves. In free motion these tell
    friction, and nothing stays with which, all together, recordings held out are predicted worse than with nothing.
    What a hysteresis is like at the beginning of a recording, none can predict: terms of the torque's path go only if
    they are worse by more than that as well. Which effects there are was chosen without these recordings; they only
    decide what is reported.
    """
    current = list(model.chosen)
    while True:
        ratios = ((c, worse_with(model, current, c)) for c in current)
        refuted = [(c, ratio) for c, ratio in ratios if ratio is not None]
        if refuted:
            worst, ratio = max(refuted, key=lambda one: one[1])
            _tell(model, [worst], ratio)
            # what stood beside it may have made up for it: it is asked again
            current = without(current, worst, model.problem.lacking)
            continue
        helping = _with_functions_that_help(model, current)
        if len(helping) == len(current):
            return [] if _worse_than_nothing(model, current) else current
        current = helping


def _tell(model: ChannelModel, gone: Sequence[Chosen], ratio: float) -> None:
    """Note that effects are not reported with which recordings held out are predicted so many times as badly."""
    how = f"{ratio:.3g} times as badly" if ratio >= 1.0 else "no better than by chance"
    them = "it: it is" if len(gone) == 1 else "them together: they are"
    words = " and ".join([*(c.main.regressor.words for c in gone[:-1]), _gained(gone[-1])])
    model.notes.append(f"{words} the fit, but recordings held out are predicted {how} with {them} not reported")


def _squared(model: ChannelModel, chosen: Sequence[Chosen]) -> float:
    """Mean square that some effects leave of recordings held out."""
    held = model.problem.held_out
    return float(np.average(_left(model, chosen)[held] ** 2, weights=model.problem.rows.number[held]))


def _worse_than_nothing(model: ChannelModel, current: Sequence[Chosen]) -> bool:
    """Whether recordings of free motion that are held out are predicted worse with some effects than with none: no
    improved simulation is worse than the calibrated one.
    """
    free = model.noise.independent_rows is not None and model.problem.held_out.any()
    if not free or not current or any(c.nominal for c in current):
        return False
    with_them, with_none = _squared(model, current), _squared(model, [])
    if with_them <= with_none:
        return False
    _tell(model, current, float(np.sqrt(with_them / max(with_none, 1e-300))))
    return True


def _with_functions_that_help(model: ChannelModel, current: list[Chosen]) -> list[Chosen]:
    """Some effects without those functions without a name, two or more together, without which recordings held out are
    predicted best: each may make up for another, and together they say nothing. All of them where they help.
    """
    functions = [c for c in current if without_a_name(c)]
    if len(functions) < 2 or not model.problem.held_out.any():
        return current

    def others(some: Sequence[Chosen]) -> list[Chosen]:
        return [c for c in current if not any(c is one for one in some)]

    several = [some for size in range(2, len(functions) + 1) for some in combinations(functions, size)]
    whole = _squared(model, current)
    least, which = min((_squared(model, others(some)), k) for k, some in enumerate(several))
    if least >= whole:
        return current
    gone = several[which]
    _tell(model, gone, float(np.sqrt(whole / max(least, 1e-300))))
    return others(gone)


def _gained(chosen: Chosen) -> str:
    """How a note begins that says why an effect is not reported."""
    return f"{chosen.main.regressor.words} gained in"


def forget(model: ChannelModel) -> None:
    """Take the notes away that say an effect is not reported which the model has after all: it was refuted beside
    another.
    """
    found = tuple(_gained(c) for c in model.chosen)
    model.notes[:] = [note for note in model.notes if not note.startswith(found)]


def worse_with(model: ChannelModel, current: Sequence[Chosen], effect: Chosen) -> float | None:
    """How many times as badly recordings held out are predicted with an effect beside the others of some; None where
    they do not refute it.
    """
    problem = model.problem
    held = problem.held_out
    if not held.any():
        return None
    if effect.effect != UNKNOWN and effect.nominal:
        return None
    others = without(current, effect, problem.lacking)
    whole = [_left(model, chosen) for chosen in (current, others)]
    left = [one[held] for one in whole]
    number, recording = problem.rows.number[held], problem.rows.frame.recording[held]
    change = left[0] ** 2 - left[1] ** 2
    worse = float(np.average(change, weights=number))
    ratio = np.sqrt(np.average(left[0] ** 2, weights=number) / max(np.average(left[1] ** 2, weights=number), 1e-300))
    # a function that is true takes its square off, one that is not adds it: what predicts worse is more likely not
    # true, however small the difference. Nature's form of a name may differ from the library's
    added = float(np.average((left[0] - left[1]) ** 2, weights=number))
    found = error_of_mean(change, recording, number)
    error = np.inf if found is None else criteria.ONE_ERROR * found
    if of_auxiliary(effect.main.regressor):
        allowed = error
    elif effect.effect == UNKNOWN:
        # where more than noise is left without it, something is missing, and what predicts better says where
        allowed = -error if added > 2.0 * error and not _much_is_left(model, others) else 0.0
    elif PATH in effect.main.regressor.variables:
        allowed = error
    elif not hardly_acts(whole[0] - whole[1], problem.rows.number, held, problem.train):
        allowed = 0.0
    elif any(without_a_name(c) for c in current) or _vague(model, current, effect):
        allowed = error
    else:
        return None
    if (
        effect.effect != UNKNOWN
        and not problem.spec.integral
        and _better_within(left, problem.rows.frame.take(held), number)
    ):
        return None
    if worse > allowed:
        return float(ratio)
    return _worse_as_it_is(model, (current, others)) if without_a_name(effect) else None


def _worse_as_it_is(model: ChannelModel, chosen: Sequence[Sequence[Chosen]]) -> float | None:
    """How many times as badly the first of two lists of effects predicts recordings held out as the second, with all
    that zeros of torques add to the heat; None where it predicts them better. A name may be drowned by that; a function
    without one claims nothing but that it predicts.
    """
    if not any(isinstance(block.regressor, WanderingZero) for block in model.base):
        return None
    problem = model.problem
    held = problem.held_out
    number = problem.rows.number[held]
    first, second = (float(np.average(_left_as_it_is(model, one)[held] ** 2, weights=number)) for one in chosen)
    return float(np.sqrt(first / max(second, 1e-300))) if first > second else None


def _much_is_left(model: ChannelModel, chosen: Sequence[Chosen]) -> bool:
    """Whether some effects leave more of recordings held out than noise usually is, about the recordings' levels and
    beside what stands for errors of sensors. What an integral leaves grows by itself.
    """
    problem = model.problem
    if problem.spec.integral:
        return False
    without = replace(model, chosen=list(chosen), fit=model.refitted(chosen))
    held, frame = problem.held_out, problem.rows.frame
    number = problem.rows.number[held]
    left = levelled((problem.rows.y - explained(without))[held], frame.take(held), number)
    return beyond_floor(model, left, number)


def _better_within(left: Sequence[FloatArray], frame: Frame, number: FloatArray) -> bool:
    """Whether the first of two predictions leaves less than the second (n, each) about the levels of recordings, by
    more than the standard error: levels differ from one to the next by themselves, and a few of them may speak against
    an effect that comes and goes within recordings. Of one that acts in the levels alone, what little it does within
    recordings is no evidence.
    """
    first, second = (levelled(one, frame, number) for one in left)
    differs = float(np.average((left[0] - left[1]) ** 2, weights=number))
    if np.average((first - second) ** 2, weights=number) < (1.0 - criteria.ACTIVE_ENERGY) * differs:
        return False
    change = first**2 - second**2
    error = error_of_mean(change, frame.recording, number)
    return error is not None and float(np.average(change, weights=number)) < -criteria.ONE_ERROR * error


def _vague(model: ChannelModel, current: Sequence[Chosen], effect: Chosen) -> bool:
    """Whether an effect of some is at the end of its range, or none of its coefficients is told from nothing."""
    sure = differs_from_zero(*model.refitted(current).of(effect.main.indices))
    return not sure or strained(effect.main.regressor, model.problem.rows.frame)


def without_a_name(effect: Chosen) -> bool:
    """Whether an effect is a free function of the bench's own quantities."""
    return effect.effect == UNKNOWN and not of_auxiliary(effect.main.regressor)


def _left(model: ChannelModel, chosen: Sequence[Chosen]) -> FloatArray:
    """What some effects leave of each row (n,), without what the motor torque's own zero in each recording adds to the
    heat: it says nothing of them, and grows far above the noise.
    """
    problem, frame = model.problem, model.problem.rows.frame
    left = _left_as_it_is(model, chosen)
    for block in model.base:
        if isinstance(block.regressor, WanderingZero):
            number = np.where(problem.usable, problem.rows.number, 0.0)
            noise = np.full(frame.size, np.inf)
            noise[number > 0.0] = model.samples.of_means(number, durations(frame))[number > 0.0]
            left = left - block.regressor.told(frame, block.precision, left, noise)
    return np.asarray(left)


def _left_as_it_is(model: ChannelModel, chosen: Sequence[Chosen]) -> FloatArray:
    """What some effects leave of each row (n,)."""
    problem = model.problem
    return np.asarray(
        problem.rows.y - of_start(problem, model.predict(problem.rows.frame, chosen, model.refitted(chosen)))
    )
