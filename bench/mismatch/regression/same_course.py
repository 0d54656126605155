"""Names that any function of a quantity bears, as other explanations of an effect that is one of it in these
recordings.

A campaign that only warms up shows a function of the temperature as a function of the time, however many numbers that
takes. Points left out would tell the two apart by their numbers; the recordings do not. So the function is made of the
effect itself: with knots where its course over the quantity bends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.bends import bending
from bench.mismatch.regression.beside import free_function
from bench.mismatch.regression.candidates import PATH, overlapping, single_functions
from bench.mismatch.regression.equivalent import expected
from bench.mismatch.regression.model import Chosen, add_block
from bench.mismatch.regression.regressors import UNKNOWN, Free, by_definition
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, IntArray
from bench.simulation.quantities import factor, quantity
from bench.simulation.tables import Grid

CELLS = 1000
"""parts of a quantity's range, each with as many samples, over which an effect's course is averaged"""
FEWEST_CELLS = 12
"""values of a quantity, below which an effect is soon a function of it: as many knots as a fine table has"""
FEWEST_RECORDINGS = 12
"""fitted recordings below which their levels are soon in the order of some quantity: of twelve in random order one in
four hundred turns back once at most, of such that saturate at two levels one in seventy
"""
TRIED = 60
"""cells near which a knot is tried, each with as much of the course's way between it and the next"""
MOST_TURNS = 1
"""times that a course may turn back: what rises and falls again and again over a quantity only says which recording it
is
"""
MOST_BENDS = 24
"""bends of a course, beyond which it is no function that anybody would call so"""


def same_courses(search: Search, others: Sequence[Chosen], tested: Chosen) -> list[Chosen]:
    """Functions of one quantity that bear a name and are the same as an effect in the rows that are fitted, each beside
    the ``others``: whatever they are over that quantity, the recordings cannot tell them from the effect.
    """
    model = search.model
    problem = model.problem
    if problem.spec.integral or problem.free or tested.effect == UNKNOWN:
        return []
    if model.bank.whitening.starts.size - 1 < FEWEST_RECORDINGS:
        return []
    taken = {tested.effect, *(c.effect for c in others)}
    # two names of one quantity differ by their forms
    variables = tested.main.regressor.variables
    own = {*variables, *(("torque", "load_motor_torque") if PATH in variables else ())}
    frame = problem.rows.frame.take(problem.train)
    course = model.contribution(tested, problem.rows.frame)[problem.train]
    out: dict[str, Chosen] = {}
    for name, times in single_functions(problem.channel):
        effect = by_definition(problem.channel, name, (times,))
        if effect == UNKNOWN or effect in (*taken, *out) or name in own or (name == "time" and overlapping(frame)):
            continue
        by = factor(times, frame)
        acts = by != 0.0
        values = np.divide(course, by, out=np.zeros(course.size), where=acts)
        over = _Course.of(
            quantity(name, frame), values, np.where(acts, problem.rows.number[problem.train] * by**2, 0.0)
        )
        if (
            over is None
            or turns(over.value) > MOST_TURNS
            or expected(model, course - by * over.interpolated) >= criteria.VERY_STRONG
        ):
            continue
        knots = over.knots()
        if knots is None:
            continue
        free = Free(problem.channel, (Grid((name,), times, (knots,)),), effect)
        chosen = free_function(search, others, add_block(problem, model.bank, free))
        # what comes and goes is not what bears the name
        if chosen.effect == effect and not search.out(chosen.main.regressor):
            out[effect] = chosen
    return list(out.values())


@dataclass(frozen=True, slots=True)
class _Course:
    """An effect over a quantity: means (c,) in cells of it, with their weights; and at each row (n,) what lies on the
    straight lines between them.
    """

    at: FloatArray
    value: FloatArray
    weight: FloatArray
    interpolated: FloatArray

    @classmethod
    def of(cls, over: FloatArray, values: FloatArray, weight: FloatArray) -> _Course | None:
        """The course of ``values`` (n,) over a quantity (n,); None where it takes too few values."""
        acts = weight > 0.0
        if not acts.any():
            return None
        level, which = np.unique(over[acts], return_inverse=True)
        share = np.bincount(which, weight[acts])
        mean = np.bincount(which, weight[acts] * values[acts]) / share
        # rows of one value are of one cell
        middle = (np.cumsum(share) - 0.5 * share) / share.sum()
        cell = np.minimum((CELLS * middle).astype(np.int64), CELLS - 1)
        first = np.flatnonzero(np.diff(cell, prepend=-1))
        total = np.add.reduceat(share, first)
        at, value = (np.add.reduceat(share * of, first) / total for of in (level, mean))
        if at.size < FEWEST_CELLS:
            return None
        return cls(at, value, total, np.interp(over, at, value))

    def knots(self) -> tuple[float, ...] | None:
        """Knots of a table that is the course to within a hundredth of its size; None where too many are needed."""
        size = float(self.weight @ (self.value - np.average(self.value, weights=self.weight)) ** 2)
        jumps = _where_it_changes(self.value)
        courses = bending(self.at, self.value, self.weight, jumps, MOST_BENDS)
        return next((knots for knots, left in courses if left <= criteria.ALIKE**2 * size), None)


def turns(value: FloatArray) -> int:
    """How often a course (n,) turns back by more than a form may be off (:data:`criteria.SHAPE`), over its range."""
    least = criteria.SHAPE * float(np.ptp(value))
    low = high = float(value[0])
    way, out = 0, 0
    for one in value.tolist():
        low, high = min(low, one), max(high, one)
        if way >= 0 and one < high - least:
            out, way, low = out + (way > 0), -1, one
        elif way <= 0 and one > low + least:
            out, way, high = out + (way < 0), 1, one
    return out


def _where_it_changes(value: FloatArray) -> IntArray:
    """Cells between which a course goes equally far."""
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(value)))])
    return np.unique(np.searchsorted(way, np.linspace(0.0, way[-1], TRIED + 2)[1:-1]))
