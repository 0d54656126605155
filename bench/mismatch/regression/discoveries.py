"""What a channel's search found, as the report's makers take it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import AMBIGUOUS, NAMED, Discovery, RefittedAlternative
from bench.mismatch.discovery import UNKNOWN as UNKNOWN_STATUS
from bench.mismatch.recordings.motion import NEARLY_ALL, share_of_one_way
from bench.mismatch.regression import windows
from bench.mismatch.regression.alone import alone
from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.bends import bends_of
from bench.mismatch.regression.beside import differs_from_zero
from bench.mismatch.regression.course import beyond
from bench.mismatch.regression.excess import excess, levelled
from bench.mismatch.regression.independent import independent, much_is_left
from bench.mismatch.regression.model import ChannelModel, Chosen, of_start
from bench.mismatch.regression.refine import strained
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, Regressor, of_reading
from bench.mismatch.regression.slots import Contender, Slot
from bench.mismatch.regression.spells import spell_of
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import ANGLE, QUANTITIES, factor, kind_of, quantity, without_a_jump
from bench.simulation.waves import Wave

FRICTION_OVER_ANGLE = "friction.position_dependent"
"""effect that changes its sign with the direction, and nothing else of it"""
MODULATES = ("1", "last_d", "load_motor", "tau", "w")
"""factors that a function of the output angle may be multiplied with"""
WAVES = ("m", "f")
"""symbols of a term's order per output revolution"""


def discoveries(
    search: Search,
    slots: Sequence[Slot],
    whole: FloatArray,
    number: FloatArray,
    frame: Frame | None = None,
    y: FloatArray | None = None,
) -> list[Discovery]:
    """Every effect of the found model, with its alternatives in ``slots``, as a discovery.

    ``whole`` (n,): the model's prediction on the channel's rows, ``number`` (n,) the samples of each that are compared.
    ``frame`` and ``y`` (n,), the measured values less all else, where these are not the search's own rows.
    """
    problem = search.model.problem
    rows = problem.rows.frame if frame is None else frame
    measured = problem.rows.y if y is None else y
    return [_discovery(search, slot, whole, number, rows, measured) for slot in slots]


def _discovery(
    search: Search, slot: Slot, whole: FloatArray, number: FloatArray, frame: Frame, y: FloatArray
) -> Discovery:
    model, tested = search.model, slot.chosen
    others = [c for c in model.chosen if c is not tested]

    def predicted(chosen: Sequence[Chosen], fitted: Fit) -> FloatArray:
        out = model.predict(frame, chosen, fitted)
        return of_start(model.problem, out) if frame is model.problem.rows.frame else out

    without = predicted(others, model.refitted(others))
    alternatives = [r for r in slot.alternatives if r.chosen.effect != tested.effect]
    as_good = [r for r in alternatives if r.as_good and r.chosen.effect != UNKNOWN]
    status = UNKNOWN_STATUS if tested.effect == UNKNOWN else (AMBIGUOUS if as_good else NAMED)
    regressor = tested.main.regressor
    coefficients, _ = model.fit.of(tested.main.indices)
    std = model.std(tested.main.indices)
    by_itself = alone(model, tested)
    wide = std if by_itself is None else by_itself.widened(std)
    course = excess_of(model, tested, frame, number)
    angles, orders = _over_angle(regressor, course, frame, number)
    size = size_of_term(regressor, coefficients, model.covariance(tested.main.indices))
    doubt = _doubt_of_name(model, tested, size) if status == NAMED else ""
    if doubt:
        model.notes.append(f"{regressor.words}: {doubt}; the confidence in the name is halved")
    return Discovery(
        effect=tested.effect,
        status=status,
        confidence=_confidence(slot, status, as_good, criteria.EITHER if doubt else 1.0),
        channel=model.channel,
        words=regressor.words,
        equation=regressor.equation,
        variables=regressor.variables,
        parameters=tuple(regressor.parameters(coefficients, wide)),
        alone=()
        if by_itself is None
        else tuple(regressor.parameters(by_itself.coefficients, by_itself.widened(by_itself.std))),
        added=whole - without,
        excess=course,
        gain=slot.gain,
        p_value=slot.p_value,
        simulation_rows=tuple(rows_of(model, tested)),
        alternatives=tuple(_refitted(model, r, others, predicted, y) for r in alternatives),
        orders=orders,
        angle_windows=angles,
        time_window=_window(tested, frame, coefficients),
        independent=status != UNKNOWN_STATUS and much_is_left(model) and independent(search, model.chosen, tested),
        numbers=regressor.numbers,
    )


def _over_angle(
    regressor: Regressor, course: FloatArray, frame: Frame, number: FloatArray
) -> tuple[tuple[tuple[float, float], ...], tuple[float, ...]]:
    """Windows of the output angle in which a function of it alone acts; its orders where it acts all around, or is a
    wave.
    """
    if isinstance(regressor, Named):
        symbols = [s.symbol for s in regressor.form.nonlinear]
        return (), tuple(v for name, v in zip(symbols, regressor.point, strict=True) if name in WAVES)
    if tuple(map(kind_of, regressor.variables)) != (ANGLE,):
        return (), ()
    angle = QUANTITIES[ANGLE].values(frame)
    by = [factor(times, frame) for times in MODULATES]
    factors = max(by, key=lambda values: windows.followed(angle, course, values, number))
    course, number = np.divide(course, factors, out=np.zeros(factors.size), where=factors != 0.0), number * factors**2
    found = windows.acting(angle, course, number)
    return (found, ()) if found else ((), windows.orders(angle, course, number))


def excess_of(model: ChannelModel, chosen: Chosen, frame: Frame, number: FloatArray) -> FloatArray:
    """What of an effect's course on the rows of a frame (n,) no calibration of the simulation can say.

    A reading that shifts at once is where it shifts, beyond what it is at rest without a load: heat shifts nothing at
    once, whatever level a recording begins with.
    """
    course = model.contribution(chosen, frame)
    base = model.calibrated
    if of_reading(chosen.main.regressor):
        nothing = np.zeros(1)
        rest = replace(frame.take(slice(0, 1)), velocity=nothing, torque=nothing, torque_level=nothing)
        return np.asarray(course - model.contribution(chosen, rest))
    if not model.problem.spec.integral:
        return beyond(course, base, frame, number)
    columns = [levelled(r.columns(frame), frame, number) for r in base]
    return excess(levelled(course, frame, number), columns, number)


def _refitted(
    model: ChannelModel, alternative: Contender, others: Sequence[Chosen], predicted: Any, y: FloatArray
) -> RefittedAlternative:
    chosen = [*others, alternative.chosen]
    regressor = alternative.chosen.main.regressor
    left = y - predicted(chosen, model.refitted(chosen))
    # of a table that a name foresees better than the weight is the name's
    foreseen = alternative.worse_by * criteria.EITHER > 1.0
    return RefittedAlternative(
        regressor.effect,
        regressor.words,
        alternative.loss,
        alternative.error,
        float("nan") if foreseen else alternative.weight,
        alternative.as_good,
        left,
        worse_by=alternative.worse_by,
    )


def _confidence(slot: Slot, status: str, as_good: Sequence[Contender], sure: float) -> float | None:
    """Weight of all models that say the same of the effect: its name, the names not told apart, or no name; times
    ``sure``, what a doubt in the name leaves of it. None where a name has more weight and is not taken, as it may be a
    part of what has none: then the weights are not those of what the report says.
    """
    if status == AMBIGUOUS:
        share = slot.weight + sum(r.weight for r in as_good)
    elif status == UNKNOWN_STATUS:
        share = slot.weight + sum(r.weight for r in slot.alternatives if r.chosen.effect == UNKNOWN)
        if any(r.weight > share for r in as_good):
            return None
    else:
        share = slot.weight
    return float(min(max(share * (1.0 - slot.p_value), 0.0), 1.0)) * sure


UNTOLD = 1e6
"""standard deviation, over the size, of a number that the recordings do not tell"""


def size_of_term(
    regressor: Regressor, coefficients: FloatArray, covariance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Numbers (k,) that are all zero where a term is nothing, and their covariance (k, k), as good as infinite where
    the recordings do not tell one: its coefficients; of a term with the coefficient of another its nonlinear
    parameters.
    """
    if isinstance(regressor, Named) and regressor.form.shares and regressor.point:
        deviation = regressor.deviation or (None,) * len(regressor.point)
        std = [UNTOLD * max(abs(p), 1.0) if d is None else d for d, p in zip(deviation, regressor.point, strict=True)]
        return np.asarray(regressor.point), np.diag(np.square(std))
    return coefficients, covariance


def sure_of_name(status: str, at_the_end: bool, coefficients: FloatArray, covariance: FloatArray) -> float:
    """Share of a confidence that is left for what the recordings say of a named term's shape and coefficients (k,)."""
    sure = not at_the_end and differs_from_zero(coefficients, covariance)
    return criteria.EITHER if status == NAMED and not sure else 1.0


def _doubt_of_name(model: ChannelModel, tested: Chosen, size: tuple[FloatArray, FloatArray]) -> str:
    """Why something else may be in the place of a name, by what the recordings say of its shape and its numbers
    (``size``: :func:`size_of_term`); empty where nothing is.
    """
    if sure_of_name(NAMED, strained(tested.main.regressor, model.problem.rows.frame), *size) < 1.0:
        return "its numbers stand at an end of their range, or may be nothing by their standard deviations"
    if no_better_than_a_parabola(model, tested):
        return (
            "over the angles that were run a parabola over the angle, such as a spring's straight line, describes the"
            " recordings as well within the noise"
        )
    if tested.effect == FRICTION_OVER_ANGLE and one_way_only(model):
        return "nearly all of the fitted motion goes one way, in which a torque that keeps its sign says the same"
    return ""


def one_way_only(model: ChannelModel) -> bool:
    """Whether nearly all of the motion that is fitted goes one way."""
    rows = model.problem.rows.take(model.problem.train)
    share = share_of_one_way(rows.frame.direction, rows.number)
    return share is not None and share >= NEARLY_ALL


def no_better_than_a_parabola(model: ChannelModel, tested: Chosen) -> bool:
    """Whether a parabola over the output angle, in place of a named wave over it, leaves no more of the fitted rows
    than the wave does, but for less than the noise tells: a sine of any size is one, where the angle hardly varies.
    """
    regressor, bank = tested.main.regressor, model.bank
    if not isinstance(regressor, Named) or regressor.variables != (ANGLE,) or regressor.point:
        return False
    q = quantity(without_a_jump(ANGLE, model.problem.rows.frame), model.problem.rows.frame)[model.problem.train]
    white = bank.whitening.apply(np.column_stack([np.ones(q.size), q - q.mean(), (q - q.mean()) ** 2]))
    residual = bank.residual([i for b in model.blocks() for i in b.indices], model.fit.coefficients)
    coefficients, _ = model.fit.of(tested.main.indices)
    course = bank.columns.some(tested.main.indices) @ coefficients
    left, said = (bank.less_offsets(values, model.fit.variance) for values in (residual, residual + course))
    columns = np.column_stack([bank.less_offsets(one, model.fit.variance) for one in white.T])
    columns /= np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    beside = said - columns @ np.linalg.lstsq(columns, said, rcond=1e-9)[0]
    return bool(beside @ beside < left @ left + criteria.TOLD**2)


def _window(chosen: Chosen, frame: Frame, coefficients: FloatArray) -> tuple[float, float] | None:
    """Begin and end in s of the campaign, as recorded, of what is there for a spell only, or comes and goes."""
    spell, course = spell_of(chosen.main.regressor), bends_of(chosen.main.regressor)
    if course is not None:
        return course.away(coefficients)
    if spell is None:
        return None
    begin, end = spell.knots[0][0], spell.knots[0][2]
    return max(begin, float(frame.time.min())), min(end, float(frame.time.max()))


def rows_of(model: ChannelModel, chosen: Chosen, fitted: Fit | None = None) -> list[dict[str, Any]]:
    """Rows of a simulation file that hold an effect, its shape's correction included."""
    fit = model.fit if fitted is None else fitted
    out: list[dict[str, Any]] = []
    for block in chosen.blocks:
        coefficients, _ = fit.of(block.indices)
        std = model.std(block.indices, fit)
        if isinstance(block.regressor, Free):
            out += [{"effect": chosen.effect, **row} for row in block.regressor.rows(coefficients)]
        elif isinstance(block.regressor, Named) and block.regressor.form.counts:
            # an order of the transmission error stands in a file as a wave
            wave = Wave(block.regressor.point[0], "1", *map(float, coefficients), *map(float, std))
            out.append({"effect": chosen.effect, "channels": [model.channel], "waves": [wave.to_json()]})
        else:
            out.append({"effect": chosen.effect, **block.regressor.row(coefficients, std)})
    return out
