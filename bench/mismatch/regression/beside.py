"""An effect fitted beside others: a free function, a term refined, and whether what comes out is physically
possible and leaves the others so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import chi2, norm

from bench.mismatch import criteria
from bench.mismatch.regression.bank import Bank, Fit
from bench.mismatch.regression.candidates import exercised, shape_of
from bench.mismatch.regression.heredity import laws
from bench.mismatch.regression.model import Block, Chosen, add_block, fit_blocks, weak_precision, with_shape
from bench.mismatch.regression.one_way import impossible, named_by_course
from bench.mismatch.regression.refine import projector, refined, strained
from bench.mismatch.regression.regressors import Named, Regressor
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray

BEYOND_BOUNDS = 2.0
"""standard deviations by which a coefficient may lie on the wrong side of a physical bound"""


def free_function(search: Search, others: Sequence[Chosen], block: Block) -> Chosen:
    """A free function beside other effects; where no recording has been, its values are as large as elsewhere at
    most.
    """
    model = search.model
    weak = np.full(len(block.indices), weak_precision(model.bank, block.indices))
    fitted = fit_blocks(model.bank, [*model.blocks(others), replace(block, precision=weak)], model.variances)
    values = block.regressor.columns(model.problem.rows.frame)[model.problem.train] @ fitted.of(block.indices)[0]
    size = _weighted_size(values)
    if model.problem.spec.integral:  # its values are rates
        size = float(np.sqrt(np.mean(fitted.of(block.indices)[0] ** 2)))
    precision = np.maximum(weak, 1.0 / max(size, 1e-300) ** 2)
    return named_by_course(model, others, Chosen(replace(block, precision=precision)), fitted)


def shaped(search: Search, others: Sequence[Chosen], start: Regressor) -> Chosen | None:
    """A term refined beside other effects, with the correction of its shape; None where it is physically impossible."""
    model = search.model
    assert isinstance(start, Named)
    problem, bank = model.problem, model.bank
    beside = model.blocks(others)
    variance = fit_blocks(bank, beside, model.variances).variance

    def fitted_from(term: Named, variance: float, tied: bool = False) -> tuple[Named, Block, Fit]:
        better = refined(problem, bank, beside, term, variance, tied)
        main = add_block(problem, bank, better)
        return better, main, fit_blocks(bank, [*beside, main], model.variances)

    better, main, fitted = fitted_from(start, variance)
    if start.point and fitted.variance < variance:
        # without the term its changes were recordings' offsets, and those of one recording alone told its numbers
        better, main, fitted = fitted_from(better, fitted.variance)
    if not _shares(main, beside, fitted):
        better, main, fitted = fitted_from(better, min(variance, fitted.variance), tied=True)
    if not (admissible(better, *fitted.of(main.indices)) and _shares(main, beside, fitted)):
        return None
    if problem.free and not (sound_beside(search, others, main, fitted) and not _taking(search, main, others, fitted)):
        return None
    for other in others:
        # two of one kind with opposite signs are another curve in disguise
        term = other.main.regressor
        if isinstance(term, Named) and not admissible(term, *fitted.of(other.main.indices)):
            return None
    train = problem.train
    shape, size = None, 0.0
    if model.noise.independent_rows is None and all(c.effect != better.effect for c in others):
        shape = shape_of(problem.channel, better, problem.rows.frame.take(train))
    if shape is not None:
        effect = better.columns(problem.rows.frame)[train] @ fitted.of(main.indices)[0]
        size = _weighted_size(effect) * _beyond(search, effect, min(variance, fitted.variance))
    whole = with_shape(problem, bank, main, shape, criteria.SHAPE * size)
    fitted = fit_blocks(bank, [*beside, *whole.blocks], model.variances)
    return None if impossible(model, others, whole, fitted) else whole


def _beyond(search: Search, effect: FloatArray, variance: float) -> float:
    """Share of an effect at the training rows (n,), as a root mean square, that the calibrated simulation cannot say:
    by so much of it nature's form may be told from the library's.
    """
    model = search.model
    white = model.bank.whitening.apply(effect[:, None])[:, 0]
    left = projector(model.bank, model.base, variance)(white)
    return float(np.linalg.norm(left)) / max(float(np.linalg.norm(white)), 1e-300)


def in_its_form(
    search: Search, others: Sequence[Chosen], chosen: Chosen, density: FloatArray
) -> tuple[Chosen, FloatArray]:
    """A name beside other effects with the correction of its form or, refined anew, without it, by which of the two
    points left out are predicted better; and the log predictive density of these (folds,), which is ``density`` as it
    was.

    Two names that both are corrected tell themselves apart by little: each correction can be the other's form.
    """
    start = chosen.main.regressor
    if chosen.shape is None or not isinstance(start, Named):
        return chosen, density
    model = search.model
    better = refined(model.problem, model.bank, model.blocks(others), start, model.fit.variance)
    plain = Chosen(add_block(model.problem, model.bank, better))
    fitted = fit_blocks(model.bank, model.blocks([*others, plain]), model.variances)
    if not admissible(better, *fitted.of(plain.main.indices)) or impossible(model, others, plain, fitted):
        return chosen, density
    without = search.density([*others, plain])
    return (plain, without) if float((without - density).sum()) >= 0.0 else (chosen, density)


def _weighted_size(values: FloatArray) -> float:
    """Size of an effect where it acts: its mean square weighted by itself."""
    square = values**2
    return float(np.sqrt(np.sum(square**2) / max(float(square.sum()), 1e-300)))


def handicap_of(search: Search, candidate: Chosen) -> float:
    """Log density by which a term has to be better than others to be reported: one at the end of its range, or a loop
    that the recordings hardly turned, is another term in disguise; a form that depends on more than the others of its
    term do has to be better for each number that it has beyond theirs.
    """
    regressor, frame = candidate.main.regressor, search.model.problem.rows.frame
    return criteria.RICHER * (int(strained(regressor, frame)) + int(idle(search, candidate)) + _richer(regressor))


def _richer(regressor: Regressor) -> int:
    """Numbers that a form which depends on more than the others of its term has beyond the fewest of theirs."""
    if not isinstance(regressor, Named) or not regressor.form.variables:
        return 0
    forms = (f for f in regressor.term.forms[regressor.channel] if not f.variables)
    fewest = min((len(form.linear) + len(form.nonlinear) for form in forms), default=regressor.numbers)
    return max(regressor.numbers - fewest, 0)


def idle(search: Search, candidate: Chosen) -> bool:
    """Whether a term is a loop that the recordings hardly turned: they cannot tell it from a function of the torque."""
    problem = search.model.problem
    regressor, frame = candidate.main.regressor, problem.rows.frame
    return not exercised(regressor, regressor.columns(frame)[problem.train], frame.take(problem.train))


def bounds_exceeded(named: Named, coefficients: FloatArray, doubt: FloatArray) -> FloatArray:
    """Physical bound that each of a term's coefficients (k,) is beyond, by more than its ``doubt`` (k,); nan where it
    is beyond none.
    """
    low = np.array([s.lower for s in named.form.linear])
    high = np.array([s.upper for s in named.form.linear])
    return np.where(coefficients + doubt < low, low, np.where(coefficients - doubt > high, high, np.nan))


def admissible(named: Named, coefficients: FloatArray, covariance: FloatArray) -> bool:
    """Whether a term's coefficients are physically possible: a lag that leads is no lag."""
    doubt = BEYOND_BOUNDS * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    if not np.isnan(bounds_exceeded(named, coefficients, doubt)).all():
        return False
    if named.form.ratio is not None and not _of_that_ratio(named.form.ratio, coefficients, covariance):
        return False
    return not (named.form.one_sign and np.any(coefficients > doubt) and np.any(coefficients < -doubt))


def _of_that_ratio(ratio: tuple[float, float], coefficients: FloatArray, covariance: FloatArray) -> bool:
    """Whether the second of two coefficients lies between two multiples of the first, but for their standard errors:
    cooling towards 130 degC is none.
    """
    for factor, side in zip(ratio, (1.0, -1.0), strict=True):
        beyond = side * np.array([-factor, 1.0])
        if float(beyond @ coefficients[:2]) < -BEYOND_BOUNDS * float(np.sqrt(beyond @ covariance[:2, :2] @ beyond)):
            return False
    return True


def _shares(block: Block, blocks: Sequence[Block], fitted: Fit) -> bool:
    """Whether a term's coefficient is that of the term it shares it with, but for a factor of two and the standard
    errors of both: nature's lag is not of first order, and late by what cools as well.
    """
    term = block.regressor
    assert isinstance(term, Named)
    for other in (b for b in blocks if term.form.shares and b.regressor.effect == term.form.shares):
        values, covariance = fitted.of([block.indices[0], other.indices[0]])
        difference = np.array([1.0, -1.0])
        most = criteria.EITHER * float(np.abs(values).max())
        if abs(float(difference @ values)) > most + BEYOND_BOUNDS * np.sqrt(difference @ covariance @ difference):
            return False
    return True


def sound_beside(
    search: Search, others: Sequence[Chosen], by: Block, fitted: Fit, in_place_of: Chosen | None = None
) -> bool:
    """Whether an effect leaves terms physically possible that are so without it, or with the one that it takes the
    place of: friction that it makes negative is no friction, but what it takes from it. An inertia that comes out
    negative beside drag is another matter: of a term that it shares next to nothing with it takes nothing.
    """
    model = search.model
    before = [model.refitted(others)]
    if in_place_of is not None:
        before.append(model.refitted([*others, in_place_of]))
    for block in [*model.base, *(c.main for c in others)]:
        term = block.regressor
        if not isinstance(term, Named) or not any(admissible(term, *plain.of(block.indices)) for plain in before):
            continue
        if (
            not admissible(term, *fitted.of(block.indices))
            and _shared(model.bank, block, by, fitted) > criteria.SHAPE**2
        ):
            return False
    return True


def _shared(bank: Bank, first: Block, second: Block, fitted: Fit) -> float:
    """Share of the energy of a fitted block's course that the course of another follows."""
    gram = bank.gram([*first.indices, *second.indices])
    size = len(first.indices)
    a, b = fitted.of(first.indices)[0], fitted.of(second.indices)[0]
    across = float(a @ gram[:size, size:] @ b)
    return across**2 / max(float(a @ gram[:size, :size] @ a) * float(b @ gram[size:, size:] @ b), 1e-300)


def _taking(search: Search, main: Block, others: Sequence[Chosen], fitted: Fit) -> bool:
    """Whether an effect takes the place of a law that it is a change of, or of another of its name: beside it the law
    is significant no longer, or they come to less than either, as each takes back what the other says.
    """
    model = search.model
    changed_laws = laws(main.regressor)
    frame = model.problem.rows.frame
    plain = model.refitted(others)

    def course(block: Block) -> FloatArray:
        return np.asarray(block.regressor.columns(frame)[model.problem.train] @ fitted.of(block.indices)[0])

    def needed(block: Block, by: Fit) -> bool:
        return differs_from_zero(*by.of(block.indices))

    effect_course = course(main)
    for block in [*model.base, *(c.main for c in others)]:
        effect = block.regressor.effect
        if effect not in (main.regressor.effect, *changed_laws):
            continue
        if effect in changed_laws and needed(block, plain) and not needed(block, fitted):
            return True
        other = course(block)
        if float(np.sum((effect_course + other) ** 2)) < min(float(np.sum(effect_course**2)), float(np.sum(other**2))):
            return True
    return False


FIXED = 5e-11
"""variance of a direction, over the largest of the coefficients', below which it is fixed; the sum of columns that are
the same has the ridge's, 1e-9 over their number
"""


def chance_of(coefficients: FloatArray, covariance: FloatArray) -> float:
    """Chance that coefficients (k,) of this ``covariance`` (k, k) are together as far from zero, if they are zero
    (Wald test). A direction that is fixed, as the mean of a table, says nothing.
    """
    scale = np.maximum(np.sqrt(np.maximum(np.diag(covariance), 0.0)), 1e-300)
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    free = values > FIXED * max(float(values[-1]), 1e-300)
    along = vectors.T @ (coefficients / scale)
    return float(chi2.sf(float(np.sum(along[free] ** 2 / values[free])), max(int(free.sum()), 1)))


def differs_from_zero(coefficients: FloatArray, covariance: FloatArray) -> bool:
    """Whether some fitted coefficients differ significantly from zero: one of them, or all together, where columns are
    so alike that none is sure by itself (Wald test). The largest of many is farther from zero by chance than one alone
    (Sidak, J. Am. Stat. Assoc. 62 (1967) 626).
    """
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    chance = 2.0 * float(norm.sf(criteria.TOLD))
    one_of = -np.expm1(np.log1p(-chance) / max(coefficients.size, 1))
    if np.any(np.abs(coefficients) > norm.isf(0.5 * one_of) * std):
        return True
    return chance_of(coefficients, covariance) < chance
