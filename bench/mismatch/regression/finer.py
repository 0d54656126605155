"""Finer tables: a function of one quantity that was found, with more knots in its place.

A coarse table is found first, for it has few values to pay for. What is sharper than its knots, such as a tight spot
of the gearbox, would be left beside it and be told as something else.
"""

from __future__ import annotations

from bench.mismatch.regression.candidates import EACH_KNOT
from bench.mismatch.regression.knots import knots_of
from bench.mismatch.regression.model import Block, add_block
from bench.mismatch.regression.regressors import Free, Regressor
from bench.mismatch.regression.state import Search
from bench.mismatch.regression.windows import HIGHEST
from bench.simulation.quantities import quantity
from bench.simulation.tables import Grid

MOST_KNOTS = 2 * HIGHEST
"""knots of the finest table: two in a period of the highest order of the output shaft that is told of a function"""

FINER = (2, 4)
"""times as many knots: what is much sharper than the coarse table is seen no better by one that is little finer"""


def finer_tables(search: Search) -> list[Block]:
    """Tables of more knots in place of the functions of one quantity in the model, where its values allow."""
    problem, bank = search.model.problem, search.bank
    if problem.free or search.model.noise.independent_rows is not None:
        return []  # where no points stand apart, each knot only follows the motion
    frame = problem.rows.frame
    made = []
    for one in search.model.chosen:
        free = one.main.regressor
        coarse = knots_of_table(free)
        if not isinstance(free, Free) or not coarse:
            continue
        values = quantity(free.variables[0], frame.take(problem.train))
        recordings = bank.whitening.starts.size - 1
        most = recordings // EACH_KNOT if free.variables == ("time",) else MOST_KNOTS
        for number in sorted({min(times * len(coarse), most) for times in FINER}):
            knots = knots_of(values, number)
            if knots is None or len(knots) <= len(coarse):
                continue
            fine = Free(free.channel, tuple(Grid(g.over, g.times, (knots,)) for g in free.grids), free.effect)
            if not search.out(fine):
                made.append(add_block(problem, bank, fine))
    return made


def coarser(regressor: Regressor, fine: Regressor) -> bool:
    """Whether a regressor is the same function as a ``fine`` one, a table of fewer knots."""
    knots = knots_of_table(regressor)
    if not knots or len(knots) >= len(knots_of_table(fine)):
        return False
    return _function(regressor) == _function(fine)


def _function(regressor: Regressor) -> tuple[object, ...]:
    """What tells functions of one quantity from each other."""
    times = tuple(g.times for g in regressor.grids) if isinstance(regressor, Free) else ()
    return (regressor.effect, regressor.variables, times)


def knots_of_table(regressor: Regressor) -> tuple[float, ...]:
    """Knots of a function of one quantity that is a plain table; none of anything else."""
    if not isinstance(regressor, Free) or regressor.mixing:
        return ()
    first = regressor.grids[0]
    plain = all(type(g) is Grid and (g.over, g.knots) == (first.over, first.knots) for g in regressor.grids)
    return first.knots[0] if plain and len(first.over) == 1 else ()
