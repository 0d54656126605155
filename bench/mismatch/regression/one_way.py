"""Whether an effect goes one way, where it is defined so: a drift is a slope, a settling, a step. What comes and goes
with time is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import norm

from bench.mismatch import criteria
from bench.mismatch.regression.bank import Fit
from bench.mismatch.regression.bends import Bends
from bench.mismatch.regression.model import ChannelModel, Chosen
from bench.mismatch.regression.regressors import UNKNOWN, Free, by_definition
from bench.mismatch.regression.spells import Levels, Spell
from bench.simulation.frame import FloatArray, recording_starts
from bench.simulation.tables import Grid
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE


def named_by_course(model: ChannelModel, others: Sequence[Chosen], chosen: Chosen, fitted: Fit) -> Chosen:
    """A fitted table beside others under its name or, where the effect goes one way and the table comes and goes, under
    none. Anything else is as it is.
    """
    free = chosen.main.regressor
    tables = (Grid, Spell, Levels, Bends)
    if not isinstance(free, Free) or free.mixing or any(type(g) not in tables or len(g.over) != 1 for g in free.grids):
        return chosen
    effect = by_definition(free.channel, free.variables[0], free.times)
    if effect == UNKNOWN or not LIBRARY[effect].one_way:
        return chosen
    members = [*(c for c in others if c.effect == effect), chosen]
    name = effect if goes_one_way(model, members, fitted) else UNKNOWN
    return (
        chosen
        if name == free.effect
        else replace(chosen, main=replace(chosen.main, regressor=replace(free, effect=name)))
    )


def impossible(model: ChannelModel, others: Sequence[Chosen], chosen: Chosen, fitted: Fit) -> bool:
    """Whether a term comes and goes, with its form's correction and others of its name, where the effect does not."""
    if not LIBRARY[chosen.effect].one_way:
        return False
    return not goes_one_way(model, [*(c for c in others if c.effect == chosen.effect), chosen], fitted)


def goes_one_way(model: ChannelModel, members: Sequence[Chosen], fitted: Fit) -> bool:
    """Whether what fitted parts of an effect add up to goes one way through the campaign: without a load, and for
    what is in the friction in one direction at one speed.
    """
    frame = model.problem.rows.frame
    unloaded = replace(frame, torque=np.zeros(frame.size), torque_level=np.zeros(frame.size))
    if model.channel == MOTOR_TORQUE:
        ones = np.ones(frame.size)
        speed = float(np.mean(np.abs(frame.velocity))) * ones
        unloaded = replace(unloaded, direction=ones, last_direction=ones, velocity=speed)
    starts = recording_starts(frame)
    rows = np.unique([*starts[:-1], *(starts[1:] - 1)])
    rows = rows[model.problem.train[rows] | np.isin(frame.recording[rows], frame.recording[model.problem.train])]
    rows = rows[np.argsort(frame.time[rows], kind="stable")]
    blocks = [b for c in members for b in c.blocks]
    columns = np.hstack([b.regressor.columns(unloaded)[rows] for b in blocks])
    values, covariance = fitted.of([i for b in blocks for i in b.indices])
    return one_way(columns @ values, columns @ covariance @ columns.T)


def one_way(values: FloatArray, covariance: FloatArray) -> bool:
    """Whether values (k,) rise only, or fall only: the largest change the other way is no more than their
    ``covariance`` (k, k) lets one of so many changes be by chance, or than a form may be off.
    """
    first, second = np.triu_indices(values.size, 1)
    change = values[second] - values[first]
    variance = np.diag(covariance)[first] + np.diag(covariance)[second] - 2.0 * covariance[first, second]
    error = np.sqrt(np.maximum(variance, 0.0)) * norm.isf(criteria.ERROR_RATE_OF_A_CHANNEL / max(change.size, 1))
    largest = float(np.max(np.abs(change), initial=0.0))
    significant = np.abs(change) > np.maximum(error, criteria.SHAPE * largest)
    return not (np.any(significant & (change > 0.0)) and np.any(significant & (change < 0.0)))
