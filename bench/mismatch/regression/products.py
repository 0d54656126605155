"""Functions of two quantities that are a product: a function found of one of them, times a function of another.

A table of two quantities that is close in one of them has more values than recordings can tell. A product of two tables
has the values of each. A drag that acts in a part of the revolution, and only above a speed, is such a product of a
table over the output angle, whatever name the angle alone would have. It is found by alternating least squares (the
criss-cross regression of Gabriel and Zamir, Technometrics 21 (1979) 489), and stands in the model by what its values
may change to first order: each table's values with the other's held.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch.regression.finer import coarser
from bench.mismatch.regression.knots import KNOTS, close_knots, halved, knots_of
from bench.mismatch.regression.model import Block, Chosen, add_block
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, Regressor
from bench.mismatch.regression.state import Search
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import ANGLE, kind_of, quantity, without_a_jump
from bench.simulation.tables import Grid
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE, TRANSMISSION_ERROR

MOST_ITERATIONS = 12
"""times that each of the two tables is fitted with the other held"""
MOST_KINDS = 2
"""quantities of a product"""
_LEAST = 1e-6
"""precision of a table's values, over the mean energy of their columns: values that no recording tells stay small"""
_KIND = (
    {"torque": "load", "load": "load", "load_motor_torque": "load", "speed": "speed", "velocity": "speed"}
    | {"temperature": "temperature"}
    | {"angle": "angle"}
)
"""what a quantity tells: the size of a load is told by the load"""
_POINT: dict[str, dict[str, str]] = {
    MOTOR_TORQUE: {"load": "torque", "speed": "speed", "temperature": "temperature"},
    LOAD_TORQUE: {"load": "load_motor_torque", "speed": "speed", "temperature": "temperature"},
    TRANSMISSION_ERROR: {"load": "torque", "speed": "speed", "temperature": "temperature"},
}
"""quantity of each kind, by channel"""
_CLOSEST = ("angle", "speed", "load", "temperature")
"""kinds, the one of which a table can be closest first"""
_BY_THE_LOAD = {MOTOR_TORQUE: {"angle"}, TRANSMISSION_ERROR: {"angle"}}
"""kinds of whose functions a name says how they go with the load, by channel: a wave of the friction that grows with
it, the reaction of a load on a ratio that varies over the angle
"""


def products(search: Search) -> list[Block]:
    """Products in place of functions without a name in the model, of one or two quantities of the operating point; with
    those of a closer table that table by itself.
    """
    if search.model.problem.free or search.model.channel not in _POINT:
        return []  # where a motion is followed, or heat is summed up, no points of an operation stand apart
    return [b for b in _products(search) if not search.out(b.regressor)]


def _products(search: Search) -> Iterator[Block]:
    problem = search.model.problem
    frame = problem.rows.frame.take(problem.train)
    point = _POINT[search.model.channel]
    asked: set[tuple[tuple[str, ...], tuple[str, ...]]] = set()
    for one in search.model.chosen:
        free = _function(one, frame)
        kinds = _kinds(free)
        if free is None or not kinds or len(kinds) > MOST_KINDS or (kinds, free.times) in asked:
            continue
        asked.add((kinds, free.times))
        first = free.grids
        if len(kinds) > 1 or "angle" in kinds:
            # both tables close, where one table of both has to be coarse
            name = without_a_jump(point.get(kinds[0], kinds[0]), frame)
            knots = _knots(name, frame)
            if knots is None:
                continue
            first = tuple(Grid((name,), grid.times, (knots,)) for grid in free.grids)
            # so close a table may say by itself what a product says with it, and may have a name
            chosen = (c.main.regressor for c in search.model.chosen)
            if not any(isinstance(r, Free) and r.grids == first for r in chosen):
                yield add_block(problem, search.model.bank, replace(free, grids=first))
        others = kinds[1:] if len(kinds) > 1 else [k for k in point if k not in kinds]
        told = _BY_THE_LOAD.get(search.model.channel, set()) & set(kinds)
        for kind in (k for k in others if not (k == "load" and told)):
            block = _product(search, replace(free, grids=first), point[kind], frame)
            if block is not None:
                yield block


def replaced(chosen: Sequence[Chosen], product: Regressor) -> list[Chosen]:
    """Functions among some effects that a product stands in place of, without a name, of no other quantities, times the
    same; or that a finer table does, the same function.
    """
    if not isinstance(product, Free) or not product.mixing:
        return [c for c in chosen if coarser(c.main.regressor, product)]
    kinds, times = {_KIND.get(name) for name in product.variables}, set(product.times)

    def held(one: Chosen) -> bool:
        free = _function(one)
        return free is not None and bool(of := _kinds(free)) and set(of) <= kinds and set(free.times) == times

    return [c for c in chosen if held(c)]


def without_parts(chosen: Sequence[Chosen], new: Regressor) -> list[Chosen]:
    """Effects beside a new one: without those that it stands in place of."""
    gone = replaced(chosen, new)
    return [c for c in chosen if not any(c is g for g in gone)]


def _function(chosen: Chosen, frame: Frame | None = None) -> Free | None:
    """An effect that is any function of the output angle by definition as a function without a name, and one that has
    none; on the rows of a ``frame`` with the knots of one that is searched for. None for any other effect.
    """
    regressor = chosen.main.regressor
    term = LIBRARY.get(chosen.effect)
    if isinstance(regressor, Free) and regressor.effect == UNKNOWN:
        return regressor
    if term is None or not term.any_function or term.variables != ("angle",):
        return None
    if isinstance(regressor, Free):
        return replace(regressor, effect=UNKNOWN)
    assert isinstance(regressor, Named)
    name = ANGLE if frame is None else without_a_jump(ANGLE, frame)
    knots = None if frame is None else knots_of(quantity(name, frame), KNOTS[1])
    of = term.shape_of(regressor.channel, regressor.form)
    grids = tuple(Grid((name,), times, (knots or (0.0, 1.0),)) for _, times in of)
    return Free(regressor.channel, grids) if grids else None


def _kinds(regressor: Regressor | None) -> tuple[str, ...]:
    """What the tables of a function without a name are of, the one that can be closest first; nothing of any other."""
    if not isinstance(regressor, Free) or regressor.effect != UNKNOWN or regressor.mixing:
        return ()
    if any(type(g) is not Grid or not g.over or g.over != regressor.grids[0].over for g in regressor.grids):
        return ()
    kinds = [_KIND.get(kind_of(name), "") for name in regressor.grids[0].over]
    return tuple(sorted(kinds, key=_CLOSEST.index)) if all(kinds) else ()


def _product(search: Search, first: Free, name: str, frame: Frame) -> Block | None:
    """A function times a table of a further quantity; None where that is constant."""
    knots = _knots(name, frame)
    if knots is None:
        return None
    base, further = first.columns(frame), Grid((name,), "1", (knots,)).columns(frame)
    grids = tuple(Grid((*grid.over, name), grid.times, (*grid.knots, knots)) for grid in first.grids)
    made = replace(first, grids=grids, mixing=((1.0,),))
    fitted = _fitted(search, without_parts(search.model.chosen, made), base, further)
    if fitted is None:
        return None
    f, g = fitted
    # each table's values, the other's held; along the first table's own values the second's say it all
    across = np.linalg.svd(f[None, :])[2][1:].T
    mixing = np.hstack([np.kron(f[:, None], np.eye(g.size)), np.kron(across, g[:, None])])
    made = replace(made, mixing=tuple(tuple(float(v) for v in row) for row in mixing))
    columns = np.hstack([(base @ f)[:, None] * further, (further @ g)[:, None] * (base @ across)])
    added = search.bank.add(columns)
    return Block(made, added, np.zeros(len(added)))


def _knots(name: str, frame: Frame) -> tuple[float, ...] | None:
    values = quantity(name, frame)
    close = close_knots(values) if name == "speed" else None
    if close is None:
        close = knots_of(values, KNOTS[1])
    # of the angle all values are driven, so that a table of it can be close
    return halved(close, values) if kind_of(name) == ANGLE and close is not None else close


def _fitted(
    search: Search, others: Sequence[Chosen], first: FloatArray, second: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Values of both tables beside other effects, each of unit size: columns ``first`` (n, k) and ``second`` (n, l).
    None where they follow nothing.
    """
    model, bank = search.model, search.bank
    blocks = model.blocks(others)
    known = bank.columns.some([i for b in blocks for i in b.indices])
    prior = np.concatenate([np.zeros(0), *(b.precision for b in blocks)])
    weight = bank.shrunk(model.fit.variance)

    def solved(columns: FloatArray) -> FloatArray:
        white = np.hstack([known, bank.whitening.apply(columns), bank.y[:, None]])
        ones = bank.whitening.by_recording(bank.one[:, None] * white)
        gram = white.T @ white - (weight[:, None] * ones).T @ ones
        size = np.diag(gram)[:-1].copy()
        size[size <= 0.0] = 1.0
        least = _LEAST * float(size[prior.size :].mean())
        inner = gram[:-1, :-1] + np.diag([*(prior + 1e-9 * size[: prior.size]), *np.full(columns.shape[1], least)])
        values = np.linalg.solve(inner, gram[:-1, -1])[prior.size :]
        return np.asarray(values / max(float(np.sqrt(np.mean(values**2))), 1e-300))

    f, g = np.zeros(first.shape[1]), np.ones(second.shape[1])
    for _ in range(MOST_ITERATIONS):
        f = solved((second @ g)[:, None] * first)
        g = solved((first @ f)[:, None] * second)
    return (f, g) if np.isfinite(f).all() and np.isfinite(g).all() and np.any(f) and np.any(g) else None
