"""What is there for a part of the campaign's time: spells between two moments, and levels that change at moments.

A spell is looked for like any other free function, at moments between the recordings. Levels are cut where what is left
changes, inside recordings as well: a seal that sticks at times, a zero that jumps. Where to cut is found by dynamic
programming (Jackson et al., IEEE Signal Process. Lett. 12 (2005) 105), how often by the price of a cut.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.bends import Bends, bending, bends_of, often, times_of
from bench.mismatch.regression.model import Block, ChannelModel, add_block, fit_blocks
from bench.mismatch.regression.regressors import UNKNOWN, Free, Regressor, by_definition
from bench.simulation.frame import FloatArray, Frame, IntArray
from bench.simulation.quantities import factor
from bench.simulation.tables import Grid
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR

SPELLS: dict[str, tuple[str, ...]] = {
    MOTOR_TORQUE: ("d", "1"),
    LOAD_TORQUE: ("1", "d", "load_motor"),
    TRANSMISSION_ERROR: ("1", "tau"),
    TEMPERATURE: (),
}
"""what may be there for a spell of the campaign's time only"""
SIGNS = ("1", "d")
"""factors of size one: what they are multiplied with is a level"""
SPELL_ENDS = 16
FEWEST_ENDS = 9
"""moments at which a spell may begin or end, below which none is looked for"""
FEWEST_WITHOUT = 2
"""recordings without it that tell a spell from something that is always there and one recording that differs"""
NOT_ENDED_S = 1e9
"""s of the campaign, thirty years: the end of a spell that the last recording has not seen
"""
STEEP_S = 1e-3
"""how long a change takes, s: no time"""
MOST_CUTS = 16
"""changes of a level in a campaign that are looked for: with more of them it is scatter"""
MOST_BENDS = 12
"""bends of a course over the campaign that are looked for: a level that comes and goes has four"""
SHORTEST_BLOCKS = 2
"""blocks that a level lasts at least"""


class Spell(Grid):
    """A table over time that is 0 before and after two moments and one value between: a single regressor."""

    __slots__ = ()

    @property
    def size(self) -> int:
        """One value."""
        return 1

    @property
    def course(self) -> str:
        """From when to when it is there."""
        begin, end = self.knots[0][1:3]
        until = "on" if end >= NOT_ENDED_S else f"to {end:.0f} s of the campaign"
        return f"a constant{times_of(self)} from {begin:.0f} s {until}"

    def knot_points(self) -> FloatArray:
        """The moment at which it begins (1, 1)."""
        return np.array([[self.knots[0][1]]])

    def columns(self, frame: Frame) -> FloatArray:
        """The regressor (n, 1)."""
        begin, _, end, _ = self.knots[0]
        inside = (frame.time > begin) & (frame.time <= end)
        return np.asarray((inside * factor(self.times, frame))[:, None])

    def to_json(self, values: FloatArray) -> dict[str, object]:
        """As a table of four knots."""
        return Grid(self.over, self.times, self.knots).to_json(np.array([0.0, values[0], values[0], 0.0]))


class Levels(Grid):
    """A table over time that jumps at its inner knots and is constant between: a regressor for each level."""

    __slots__ = ()

    @property
    def size(self) -> int:
        """A value for each level."""
        return len(self.knots[0]) - 1

    @property
    def changes(self) -> int:
        """How often the level changes."""
        return self.size - 1

    @property
    def course(self) -> str:
        """How often it changes."""
        return f"a level{times_of(self)} that changes {often(self.changes)}"

    def knot_points(self) -> FloatArray:
        """The moments at which the levels begin (size, 1)."""
        return np.asarray(self.knots[0][:-1])[:, None]

    def columns(self, frame: Frame) -> FloatArray:
        """The regressors (n, size): the factor while a level lasts, else 0."""
        which = np.searchsorted(np.asarray(self.knots[0][1:-1]), frame.time, side="left")
        out = np.zeros((frame.size, self.size))
        out[np.arange(frame.size), which] = factor(self.times, frame)
        return out

    def to_json(self, values: FloatArray) -> dict[str, object]:
        """As a table with two knots at each change."""
        inner = [at for cut in self.knots[0][1:-1] for at in (cut, cut + STEEP_S)]
        knots = (self.knots[0][0], *inner, self.knots[0][-1])
        return Grid(self.over, self.times, (knots,)).to_json(np.repeat(values, 2))


def spells(channel: str, frame: Frame, times: str) -> Iterator[Free]:
    """Something that is there between two moments of the campaign: a table over time with two steep sides."""
    every = spell_ends(frame)
    if len(every) < FEWEST_ENDS:
        return
    chosen = np.unique(np.round(np.linspace(1, len(every) - 2, SPELL_ENDS)).astype(int))
    for i, j in combinations((0, *chosen.tolist(), len(every) - 1), 2):
        if _is_spell(i, j, len(every), times):
            yield spell(channel, times, every[i], every[j])


def _is_spell(begin: int, end: int, ends: int, times: str) -> bool:
    """Whether what lasts from one to another of so many moments between the recordings is a spell: what is always there
    is none. A level may differ in one recording; of what changes inside recordings, a gain, one says nothing.
    """
    without = ends - 1 - (end - begin)
    return begin < end and without >= (1 if times in SIGNS else FEWEST_WITHOUT)


def spell_ends(frame: Frame) -> list[float]:
    """Moments between the recordings at which a spell may begin or end, and one before and after all of them, s: what
    is there in the last one goes on.
    """
    first = np.flatnonzero(np.diff(frame.recording, prepend=frame.recording[0] - 1))
    gaps = 0.5 * (frame.time[first[1:] - 1] + frame.time[first[1:]])
    return [min(float(frame.time.min()), 0.0) - 1.0, *(float(g) for g in gaps), NOT_ENDED_S]


def spell(channel: str, times: str, begin: float, end: float) -> Free:
    """Something that is there from one moment of the campaign to another, in s of its time."""
    return Free(channel, (Spell(("time",), times, ((begin, begin + STEEP_S, end, end + STEEP_S),)),))


def spell_of(regressor: Regressor) -> Spell | None:
    """The spell that a regressor is, if it is one."""
    grid = regressor.grids[0] if isinstance(regressor, Free) else None
    return grid if isinstance(grid, Spell) else None


def levels_of(regressor: Regressor) -> Levels | None:
    """The levels that a regressor is, if it is such."""
    grid = regressor.grids[0] if isinstance(regressor, Free) else None
    return grid if isinstance(grid, Levels) else None


def changing_of(regressor: Regressor) -> Levels | Bends | None:
    """The levels or the course with bends that a regressor is, if it is either."""
    return levels_of(regressor) or bends_of(regressor)


def timed(model: ChannelModel, block: Block) -> Block:
    """A spell with its ends at the likeliest moments between the recordings; any other candidate as it is."""
    found = spell_of(block.regressor)
    if found is None:
        return block
    beside = model.blocks(model.chosen)
    ends = spell_ends(model.problem.rows.frame.take(model.problem.train))
    begin, _, end, _ = found.knots[0]
    nearest = [int(np.argmin(np.abs(np.asarray(ends) - at))) for at in (begin, end)]
    tried: dict[tuple[int, int], tuple[float, Block]] = {}

    def likelihood(i: int, j: int) -> float:
        if (i, j) not in tried:
            one = add_block(model.problem, model.bank, spell(model.channel, found.times, ends[i], ends[j]))
            tried[i, j] = (fit_blocks(model.bank, [*beside, one], model.variances).likelihood, one)
        return tried[i, j][0]

    here = (nearest[0], nearest[1])
    while True:
        around = [(here[0] + a, here[1] + b) for a in (-1, 0, 1) for b in (-1, 0, 1)]
        inside = [(i, j) for i, j in around if i >= 0 and j < len(ends) and _is_spell(i, j, len(ends), found.times)]
        best = max(inside, key=lambda p: (likelihood(*p), p == here))
        if best == here:
            return tried[here][1]
        here = best


def price_of_cuts(model: ChannelModel, regressor: Regressor) -> float:
    """Log-likelihood that the cuts of levels, or the bends of a course, have to gain: each may be at any block of the
    campaign, and brings a level (half a logarithm of what it is fitted to, Schwarz, Ann. Stat. 6 (1978) 461).
    """
    found = changing_of(regressor)
    changes = 0 if found is None else found.changes
    return 1.5 * changes * float(np.log(max(_blocks(model).size, 2))) if changes else 0.0


def in_levels(model: ChannelModel, factors: Sequence[str]) -> list[Block]:
    """Levels that change over the campaign beside a model, for each of the ``factors`` with as many changes as pay."""
    found = (_best_levels(model, times) for times in factors if times in SPELLS[model.channel])
    return [block for block in found if block is not None]


def _best_levels(model: ChannelModel, times: str) -> Block | None:
    problem = model.problem
    blocks = _blocks(model)
    if blocks.size < FEWEST_ENDS * SHORTEST_BLOCKS:
        return None
    frame = problem.rows.frame.take(problem.train)
    sign = factor(times, frame)
    beside = model.blocks()
    # with offsets as large as the levels themselves only changes inside recordings would calibrate the simulation
    plain = fit_blocks(model.bank, beside, _small(model))
    left = (problem.rows.y - model.predict(problem.rows.frame, fitted=plain))[problem.train]
    number = problem.rows.number[problem.train] * np.abs(sign)
    total = np.add.reduceat(number, blocks)
    value = np.add.reduceat(number * sign * left, blocks) / np.maximum(total, 1e-300)
    # a level that changes once and for all is a drift, where one is any function of time
    drift = by_definition(model.channel, "time", (times,))
    every = list(_cut(value, total))
    cut = [Levels(("time",), times, (_knots(frame.time, blocks, cuts),)) for cuts in every]
    levels = _best(model, beside, [Free(model.channel, (g,), drift if g.changes == 1 else UNKNOWN) for g in cut])
    if levels is None:
        return None
    # where the most that were tried are the best, no number of changes is enough: a course in time is no levels
    found = levels_of(levels.regressor)
    if found is None or found.changes < len(every) or found.changes == 1:
        return levels
    time = np.add.reduceat(frame.time, blocks) / np.add.reduceat(np.ones(frame.size), blocks)
    knots = bending(time, value, total, np.asarray(every[-1], dtype=np.int64), MOST_BENDS)
    # whether it is a course, and no scatter that any number of knots follows, points left out say
    return _best(model, beside, [Free(model.channel, (Bends(("time",), times, (k,)),), UNKNOWN) for k, _ in knots])


def _best(model: ChannelModel, beside: Sequence[Block], functions: Sequence[Free]) -> Block | None:
    """The function whose likelihood beside other blocks gains most beyond the price of its changes; None if none
    does.
    """
    best: tuple[float, Block] | None = None
    for function in functions:
        one = add_block(model.problem, model.bank, function)
        gain = fit_blocks(model.bank, [*beside, one], model.variances).likelihood - model.fit.likelihood
        gain -= price_of_cuts(model, one.regressor)
        if best is None or gain > best[0]:
            best = (gain, one)
    return best[1] if best is not None and best[0] > 0.0 else None


def _small(model: ChannelModel) -> tuple[float, ...]:
    """Variances of the offsets up to that which noise gives a recording's mean."""
    least = [v for v in model.variances if v * float(np.median(model.bank.energy)) <= 1.0]
    return tuple(least) or (model.variances[0],)


def _blocks(model: ChannelModel) -> IntArray:
    """First training row of each block of a few correlation times of the noise, none across two recordings."""
    problem = model.problem
    frame = problem.rows.frame.take(problem.train)
    width = max(criteria.BLOCK_S, 3.0 * model.noise.memory)
    number = np.floor(frame.elapsed / width)
    fresh = (np.diff(number, prepend=-1.0) != 0.0) | (np.diff(frame.recording, prepend=-1) != 0)
    return np.flatnonzero(fresh)


def _cut(value: FloatArray, weight: FloatArray) -> Iterator[tuple[int, ...]]:
    """Blocks at which the level changes, for one change, two, and so on: least squares."""
    n = value.size
    sums = np.concatenate([[0.0], np.cumsum(weight)])
    firsts = np.concatenate([[0.0], np.cumsum(weight * value)])

    def cost(stop: int, starts: IntArray) -> FloatArray:
        # less the squares, which are the same however it is cut
        return np.asarray(-((firsts[stop] - firsts[starts]) ** 2) / np.maximum(sums[stop] - sums[starts], 1e-300))

    last = np.array([cost(stop, np.array([0]))[0] for stop in range(n + 1)])
    origin: list[IntArray] = []
    for cuts in range(1, min(MOST_CUTS, n // SHORTEST_BLOCKS - 1) + 1):
        now, where = np.full(n + 1, np.inf), np.zeros(n + 1, dtype=np.int64)
        for stop in range((cuts + 1) * SHORTEST_BLOCKS, n + 1):
            starts = np.arange(cuts * SHORTEST_BLOCKS, stop - SHORTEST_BLOCKS + 1)
            every = last[starts] + cost(stop, starts)
            best = int(np.argmin(every))
            now[stop], where[stop] = every[best], starts[best]
        origin.append(where)
        last = now
        yield _back(origin, n)


def _back(origin: Sequence[IntArray], n: int) -> tuple[int, ...]:
    out = []
    at = n
    for where in reversed(origin):
        at = int(where[at])
        out.append(at)
    return tuple(reversed(out))


def _knots(time: FloatArray, blocks: IntArray, cuts: Sequence[int]) -> tuple[float, ...]:
    """Begin of the campaign, the moments of the changes, its end; s of the campaign's time."""
    edges = [0.5 * (float(time[blocks[c] - 1]) + float(time[blocks[c]])) for c in cuts]
    return (float(time.min()) - 1.0, *edges, float(time.max()) + 1.0)
