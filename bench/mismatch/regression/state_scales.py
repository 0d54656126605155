"""Functions of states that are not recorded, with the likeliest scale of the state: its time constant or its reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from bench.mismatch.regression.knots import knots_of
from bench.mismatch.regression.model import Block, ChannelModel, add_block, fit_blocks
from bench.mismatch.regression.regressors import Free, Regressor
from bench.simulation.quantities import quantity, range_of, state_named, state_of

WITHIN = 3.0
"""times the scale to either side within which it is looked for, a little more than to the next candidate; not beyond
the first and the last
"""
FINE = 0.02
"""of the scale's logarithm: to a fiftieth of the scale its function is the same"""
MOST_TRIED = 12


def is_of_state(regressor: Regressor) -> bool:
    """Whether a regressor is a function of a state that is not recorded."""
    return any(state_of(name) is not None for name in regressor.variables)


def scaled(model: ChannelModel, block: Block) -> Block:
    """A function of a state with the likeliest scale of it beside a model; any other candidate as it is."""
    free = block.regressor
    state = state_of(free.variables[0]) if isinstance(free, Free) and len(free.variables) == 1 else None
    if state is None or not isinstance(free, Free):
        return block
    kind, begin = state
    beside = model.blocks(model.chosen)
    frame = model.problem.rows.frame.take(model.problem.train)
    tried: dict[str, tuple[float, Block]] = {free.variables[0]: (_likelihood(model, beside, block), block)}

    def cost(logarithm: float) -> float:
        name = state_named(kind, float(np.exp(logarithm)))
        if name in tried:
            return -tried[name][0]
        knots = knots_of(quantity(name, frame), len(free.grids[0].knots[0]))
        if knots is None:
            return float("inf")
        grids = tuple(replace(grid, over=(name,), knots=(knots,)) for grid in free.grids)
        one = add_block(model.problem, model.bank, replace(free, grids=grids))
        likelihood = _likelihood(model, beside, one)
        tried[name] = (likelihood, one)
        return -likelihood

    least, most = range_of(kind)
    bounds = (float(np.log(max(begin / WITHIN, least))), float(np.log(min(begin * WITHIN, most))))
    minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": FINE, "maxiter": MOST_TRIED})
    return max(tried.values(), key=lambda one: one[0])[1]


def _likelihood(model: ChannelModel, beside: list[Block], block: Block) -> float:
    return fit_blocks(model.bank, [*beside, block], model.variances).likelihood
