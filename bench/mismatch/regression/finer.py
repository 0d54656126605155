"""Finer tables: a function of one quantity that was found, with more knots in its place.

A coarse table is found first, for it has few values to pay for. What is sharper than its knots, such as a tight spot
of the gearbox, would be left beside it and be told as something else.
"""

from __future__ import annotations

from bench.mismatch.regression.candidates import EACH_KNOT
from bench.mismatch.regression.knots import KNOTS, halved
from bench.mismatch.regression.model import Block, add_block
from bench.mismatch.regression.regressors import UNKNOWN, Free, Regressor, kinds, knots_of_table
from bench.mismatch.regression.state import Search
from bench.simulation.quantities import quantity
from bench.simulation.tables import Grid

MOST_HALVINGS = 2
"""times that intervals are halved in one step: what is much sharper than the coarse table is seen no better by one that
is little finer
"""
MOST_KNOTS = 2**MOST_HALVINGS * (KNOTS[-1] - 1) + 1
"""knots of the finest table: those of the finest that is searched for, with its intervals halved so often"""


def finer_tables(search: Search) -> list[Block]:
    """Tables with more knots in place of the functions of one quantity in the model, where its values allow."""
    problem, bank = search.model.problem, search.bank
    if problem.free or search.model.noise.independent_rows is not None:
        return []  # where no points stand apart, each knot only follows the motion
    frame = problem.rows.frame
    made = []
    for one in search.model.chosen:
        free = one.main.regressor
        knots = knots_of_table(free)
        if not isinstance(free, Free) or not knots:
            continue
        values = quantity(free.variables[0], frame.take(problem.train))
        recordings = bank.whitening.starts.size - 1
        most = recordings // EACH_KNOT if free.variables == ("time",) else MOST_KNOTS
        for _ in range(MOST_HALVINGS):
            coarse, knots = knots, halved(knots, values)
            if not len(coarse) < len(knots) <= most:
                break
            fine = Free(free.channel, tuple(Grid(g.over, g.times, (knots,)) for g in free.grids), free.effect)
            if not search.out(fine):
                made.append(add_block(problem, bank, fine))
    return made


def coarser(regressor: Regressor, fine: Regressor) -> bool:
    """Whether a regressor is the same function as a ``fine`` one, a table of fewer knots; a function without a name may
    be that of an effect.
    """
    if not isinstance(regressor, Free) or not isinstance(fine, Free):
        return False
    if not 0 < len(knots_of_table(regressor)) < len(knots_of_table(fine)):
        return False
    alike = regressor.effect == fine.effect or UNKNOWN in (regressor.effect, fine.effect)
    return alike and (kinds(regressor), regressor.times) == (kinds(fine), fine.times)
