"""Everything that may enter a channel's model: the library's terms at grid points, and free functions.

The free functions know no physics. They say what the residual depends on where no name fits, compete with every name,
and are the effect itself where it is defined by what it depends on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations_with_replacement

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, Regressor, by_definition
from bench.mismatch.regression.spells import SPELLS, spells
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import FACTOR_OF, QUANTITIES, quantity
from bench.simulation.tables import Grid, hats
from bench.simulation.terms import (
    LIBRARY,
    LOAD_TORQUE,
    MOTOR_TORQUE,
    TEMPERATURE,
    TRANSMISSION_ERROR,
    for_channel,
)

PERIODIC = (
    "te.harmonic",
    "te.sideband",
    "te.local_defect",
    "te.resonance",
    "te.fourier",
    "sensor.motor_encoder",
    "motor.torque_ripple",
)
"""effects periodic in the angle: looked for in order spectra (:mod:`bench.mismatch.orders`), not among rows"""
TURNING = ("load.unbalance", *PERIODIC)
"""effects of something that turns: a linear axis, whose angle is a length, has none of them"""
PATH = "torque_path"
"""variable of terms that depend on whether the torque rises or falls"""
BY_GEOMETRY = ("motor.load_reaction", "load.reaction")
"""terms without a free parameter: they are taken off the measured channel"""
KNOTS = (6, 12)
"""knots of free functions of one quantity: coarse and fine"""
CLOSE_KNOTS = 28
"""knots of a function of the speed in even ratios: from 0.01 to 1 rad/s one a fifth further than the last"""
KNOTS_OF_SEVERAL = {2: 5, 3: 4}
"""knots of each quantity in functions of two, and of three"""
EACH_KNOT = 3
"""recordings to each knot of a function of time, at least: a drift goes through several"""
_STRAIGHT = ("angle", "time", "elapsed", "load", "torque", "temperature")
"""quantities of which a straight line is tried as well: fewer numbers than a table"""
LEAST_VARIATION = 1e-9
"""relative spread of a quantity below which it is constant"""

# functions of one quantity: (quantity, factors of the tables that stand together)
_ONE: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    MOTOR_TORQUE: (
        ("speed", ("d",)),
        ("velocity", ("1",)),
        ("load", ("d",)),
        ("torque", ("1",)),
        ("torque", ("p", "n")),
        ("temperature", ("d",)),
        ("temperature", ("w",)),
        ("temperature", ("1",)),
        ("temperature", ("d*abs_tau",)),
        ("time", ("d",)),
        ("time", ("w",)),
        ("time", ("1",)),
        ("since_reversal", ("d",)),
        ("elapsed", ("d",)),
        ("speeding_up", ("d",)),
        # not times the load: its mean is a gain, and the ratio that varies over the angle would take the name of that
        ("angle", ("d",)),
        ("angle", ("1",)),
    ),
    LOAD_TORQUE: (
        ("load_motor_torque", ("1",)),
        ("load_motor_torque", ("d",)),
        ("speed", ("d",)),
        ("velocity", ("1",)),
        ("temperature", ("1",)),
        ("temperature", ("load_motor",)),
        ("temperature", ("d",)),
        ("time", ("1",)),
        ("time", ("load_motor",)),
        ("time", ("d",)),
        ("since_reversal", ("d",)),
        ("elapsed", ("1",)),
        ("speeding_up", ("d",)),
        ("angle", ("1",)),
        ("angle", ("d",)),
        ("angle", ("load_motor",)),
    ),
    TRANSMISSION_ERROR: (
        ("torque", ("1",)),
        ("torque", ("p", "n")),
        ("speed", ("p", "n")),
        ("temperature", ("p", "n")),
        ("time", ("1",)),
        ("time", ("tau",)),
        ("since_reversal", ("last_d*reversed",)),
        ("elapsed", ("1",)),
    ),
    TEMPERATURE: (
        ("speed", ("1",)),
        ("temperature", ("1",)),
        ("temperature", ("1", "power")),  # a heat capacity that depends on temperature divides the loss and the cooling
        ("time", ("1",)),
        ("load", ("1",)),
        ("elapsed", ("1",)),
    ),
}
# functions of two or three quantities together
_MORE: dict[str, tuple[tuple[tuple[str, ...], str], ...]] = {
    MOTOR_TORQUE: (
        (("load", "temperature"), "d"),
        (("load", "speed"), "d"),
        (("speed", "temperature"), "d"),
        (("torque", "velocity"), "1"),
        (("torque", "temperature"), "1"),
        (("load", "speed", "temperature"), "d"),
    ),
    LOAD_TORQUE: (
        (("load_motor_torque", "temperature"), "1"),
        (("load_motor_torque", "velocity"), "1"),
        (("speed", "temperature"), "d"),
    ),
    TRANSMISSION_ERROR: (
        (("torque", "temperature"), "1"),
        (("torque", "temperature"), "last_d"),
        (("torque", "speed"), "1"),
        (("torque", "speed"), "last_d"),
        (("speed", "temperature"), "1"),
        (("speed", "temperature"), "last_d"),
        (("torque", "speed", "temperature"), "1"),
        (("torque", "speed", "temperature"), "last_d"),
    ),
    TEMPERATURE: ((("load", "speed"), "1"),),
}
# products beyond the polynomials that the simulation has: a number each
_PRODUCTS: dict[str, tuple[str, ...]] = {
    MOTOR_TORQUE: (
        *("*".join(("d", *own)) for n in (2, 3) for own in combinations_with_replacement(("abs_tau", "abs_v", "T"), n)),
        *("*".join(own) for n in (2, 3) for own in combinations_with_replacement(("tau", "abs_v", "T"), n)),
    ),
    LOAD_TORQUE: tuple("*".join(("load_motor", *own)) for own in combinations_with_replacement(("abs_v", "T"), 2)),
    TRANSMISSION_ERROR: tuple(
        "*".join((*side, *own))
        for side in ((), ("last_d",))
        for own in combinations_with_replacement(("tau", "v", "T"), 3)
    ),
    TEMPERATURE: (),
}


def named_candidates(
    channel: str,
    frame: Frame,
    switched_off: Sequence[str],
    banned: Sequence[str] = (),
    free: bool = False,
    cut: bool = False,
) -> Iterator[Named]:
    """Terms beyond the nominal simulation, and nominal ones that the given simulation lacks, at their grid points.

    ``free``: in a motion that follows no set speeds nothing depends on what is constant; ``cut``: in pieces of a few
    recordings of it time is the order in which things were done, as in a sweep, and gives no effect its name.
    """
    effects = [t for t in for_channel(channel) if t.effect not in PERIODIC]
    effects += [LIBRARY[e] for e in switched_off if channel in LIBRARY[e].forms and e not in PERIODIC]
    timeless = overlapping(frame) or (cut and channel != TEMPERATURE)
    for term in effects:
        if term.effect in banned or term.effect in BY_GEOMETRY or (timeless and "time" in term.variables):
            continue
        if free and any(name in QUANTITIES and _constant(quantity(name, frame)) for name in term.variables):
            continue
        for form in term.forms[channel]:
            for point in form.grid(frame):
                yield Named(term, channel, form, point)


def _constant(values: FloatArray) -> bool:
    """Whether a quantity does not vary: nothing can be said to depend on it."""
    return values.size == 0 or float(np.ptp(values)) <= LEAST_VARIATION * (1.0 + float(np.abs(values).max()))


def free_candidates(channel: str, frame: Frame, straight: bool = False) -> Iterator[Free]:
    """Free functions of the quantities that vary in the rows of ``frame``; ``straight``: straight lines as well, where
    each number has its price.
    """
    timeless, recordings = overlapping(frame), int(np.unique(frame.recording).size)
    for name, factors in _ONE[channel]:
        if name == "time" and timeless:
            continue
        # denser than the recordings, a function of time only says which recording it is
        most = max(recordings // EACH_KNOT, 2) if name == "time" else KNOTS[-1]
        line = ends(quantity(name, frame)) if straight and name in _STRAIGHT else None
        if line is not None:
            grids = tuple(Grid((name,), times, (line,)) for times in factors)
            yield Free(channel, grids, by_definition(channel, name, factors))
        for number in sorted({min(n, most) for n in KNOTS}):
            knots = knots_of(quantity(name, frame), number)
            if knots is not None and (number <= KNOTS[0] or len(knots) > KNOTS[0]):
                grids = tuple(Grid((name,), times, (knots,)) for times in factors)
                yield Free(channel, grids, by_definition(channel, name, factors))
        close = close_knots(quantity(name, frame)) if name == "speed" else None
        if close is not None:
            yield Free(
                channel,
                tuple(Grid((name,), times, (close,)) for times in factors),
                by_definition(channel, name, factors),
            )
    for names, times in _MORE[channel]:
        each = [knots_of(quantity(name, frame), KNOTS_OF_SEVERAL[len(names)]) for name in names]
        known = tuple(knots for knots in each if knots is not None)
        if len(known) == len(names):
            yield Free(channel, (Grid(names, times, known),))
    constant = {part for part, name in FACTOR_OF.items() if knots_of(quantity(name, frame), KNOTS[0]) is None}
    for times in _PRODUCTS[channel]:
        if constant & set(times.split("*")):
            continue
        yield Free(channel, (Grid((), times, ()),), _of_product(channel, times))
    for times in () if timeless else SPELLS[channel]:
        yield from spells(channel, frame, times)


def overlapping(frame: Frame) -> bool:
    """Whether recordings overlap in time: their stamps are no time of one campaign then, and nothing depends on it."""
    first = np.flatnonzero(np.diff(frame.recording, prepend=-1))
    last = np.append(first[1:], frame.size) - 1
    order = np.argsort(frame.time[first], kind="stable")
    begin, end = frame.time[first][order], frame.time[last][order]
    return bool(np.any(begin[1:] < end[:-1]))


def exercised(regressor: Regressor, columns: FloatArray, frame: Frame) -> bool:
    """Whether the recordings have driven the loops of a regressor whose ``columns`` (n, k) depend on the torque's path.

    Where the torque never turns back inside a recording, a hysteresis is a function of the torque like any other.
    """
    if PATH not in regressor.variables:
        return True
    own = "load_motor_torque" if regressor_channel(regressor) == LOAD_TORQUE else "torque"
    values = quantity(own, frame)
    knots = knots_of(values, KNOTS[1])
    if knots is None:
        return False
    basis = hats(values, np.asarray(knots))
    left = columns - basis @ np.linalg.lstsq(basis, columns, rcond=1e-9)[0]
    energy = np.sum(columns**2, axis=0)
    return bool(np.max(np.sum(left**2, axis=0) / np.maximum(energy, 1e-300)) > criteria.EXERCISED)


def regressor_channel(regressor: Regressor) -> str:
    """Channel of a term or a free function."""
    return regressor.channel if isinstance(regressor, Named | Free) else ""


def _of_product(channel: str, times: str) -> str:
    """The effect that a product is, where it is a function of the one quantity by which an effect is defined."""
    parts = times.split("*")
    made_of = {FACTOR_OF[part] for part in parts if part in FACTOR_OF}
    if len(made_of) != 1:
        return UNKNOWN
    name = made_of.pop()
    # a function of the velocity is one of the speed in each direction
    either = ("speed" if name == "velocity" else name, ("p", "n"))
    for of, factors in ((name, ("1",)), either)["last_d" in parts :]:
        effect = by_definition(channel, of, factors)
        if effect != UNKNOWN:
            return effect
    return UNKNOWN


def shape_of(channel: str, effect: str, frame: Frame, number: int = KNOTS[-1]) -> Free | None:
    """The function by which nature's form of an effect may differ from the library's; None where it has none."""
    grids = []
    for name, times in LIBRARY[effect].shape.get(channel, ()):
        knots = knots_of(quantity(name, frame), number)
        if knots is not None:
            grids.append(Grid((name,), times, (knots,)))
    return Free(channel, tuple(grids), effect) if grids else None


def ends(values: FloatArray) -> tuple[float, float] | None:
    """The least and the largest value: a table of two knots is a straight line. None for a constant."""
    if values.size == 0 or not np.isfinite(values).all():
        return None
    low, high = float(values.min()), float(values.max())
    return (low, high) if high - low > 1e-9 * (abs(low) + abs(high)) else None


def knots_of(values: FloatArray, number: int) -> tuple[float, ...] | None:
    """Knots half by the quantiles of the values and half evenly, apart by a part of the range; None if constant."""
    if _constant(values):
        return None
    spread = float(np.ptp(values))
    levels = np.unique(np.round(values / spread, 4)) * spread
    if levels.size < 3:
        return None
    apart = spread / (3.0 * number)
    alike = np.split(levels, np.flatnonzero(np.diff(levels) > apart) + 1)
    if len(alike) <= number and all(np.ptp(own) < apart for own in alike):
        # a few levels, each with what a controller leaves: a knot each
        return tuple(float(own.mean()) for own in alike) if len(alike) >= 3 else None
    sample = np.quantile(values, np.linspace(0.005, 0.995, number))
    even = np.linspace(sample[0], sample[-1], number)
    kept: list[float] = []
    for knot in np.unique(0.5 * sample + 0.5 * even):
        if not kept or knot - kept[-1] >= apart:
            kept.append(float(knot))
    kept = _among_rows(kept, levels)
    return tuple(kept) if len(kept) >= 3 else None


def _among_rows(knots: Sequence[float], values: FloatArray) -> list[float]:
    """Knots (increasing) with sorted ``values`` nearer to them than to the next ones, and both ends.

    In a gap a table's value stands on rows far away, and what it says there is made many times as large.
    """
    middles = 0.5 * (np.array(knots[1:]) + np.array(knots[:-1]))
    here = np.diff(np.searchsorted(values, middles))
    return [*knots[:1], *(k for k, n in zip(knots[1:-1], here, strict=True) if n), *knots[1:][-1:]]


def close_knots(speed: FloatArray) -> tuple[float, ...] | None:
    """Knots of a function of the speed in even ratios, for what happens about one speed; None where too few speeds were
    driven.

    A warm-up runs five times as fast as any point: knots at even distances leave no more than three to all the others.
    """
    driven = speed[speed > 0.0]
    if driven.size < CLOSE_KNOTS:
        return None
    low, high = np.quantile(driven, [0.02, 1.0])
    # nothing is known of a speed that was never driven
    edges = _among_rows([float(own) for own in np.log(np.geomspace(low, high, CLOSE_KNOTS))], np.sort(np.log(driven)))
    return tuple(float(own) for own in np.exp(edges)) if len(edges) > KNOTS[1] else None
