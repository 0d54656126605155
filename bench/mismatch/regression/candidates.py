"""Everything that may enter a channel's model: the library's terms at grid points, and free functions.

The free functions know no physics. They say what the residual depends on where no name fits, compete with every name,
and are the effect itself where it is defined by what it depends on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations_with_replacement

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.excess import excess, levelled
from bench.mismatch.regression.knots import KNOTS, close_knots, ends, is_constant, knots_of
from bench.mismatch.regression.regressors import UNKNOWN, Free, Named, Regressor, by_definition
from bench.mismatch.regression.spells import SPELLS, spells
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import (
    ABOUT_ZERO,
    ANGLE,
    FACTOR_OF,
    FILM,
    OF_KIND,
    QUANTITIES,
    READ,
    WORKED,
    quantity,
    without_a_jump,
)
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
ROTATING = ("load.unbalance", *PERIODIC)
"""effects of something that turns: a linear axis, whose angle is a length, has none of them"""
PATH = "torque_path"
"""variable of terms that depend on whether the torque rises or falls"""
BY_GEOMETRY = ("motor.load_reaction", "load.reaction")
"""terms without a free parameter: they are taken off the measured channel"""
KNOTS_OF_SEVERAL = {2: ((5, 5), (9, 3), (3, 9)), 3: ((4, 4, 4),)}
"""knots of each quantity in functions of two, and of three: alike, or close in one and coarse in the other"""
EACH_KNOT = 3
"""recordings to each knot of a function of time, at least: a drift goes through several"""
WIDEST_SPRING = 1.0
"""rad: swing up to which a straight line over the angle is asked for; beyond, gravity bends it"""
_STRAIGHT = {
    **dict.fromkeys((ANGLE, ABOUT_ZERO), WIDEST_SPRING),
    **dict.fromkeys(("time", "elapsed", "load", "torque", "temperature"), np.inf),
}
"""quantities of which a straight line is tried as well, fewer numbers than a table, and how far they may vary for it"""

# functions of one quantity: (quantity, factors of the tables that stand together)
_ONE: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    MOTOR_TORQUE: (
        ("speed", ("d",)),
        ("velocity", ("1",)),
        ("load", ("d",)),
        ("torque", ("1",)),
        ("torque", ("p", "n")),
        ("load_power", ("1",)),
        ("load_power", ("d",)),
        ("temperature", ("d",)),
        ("temperature", ("w",)),
        ("temperature", ("1",)),
        ("temperature", ("d*abs_tau",)),
        ("quick_warming", ("d",)),
        ("warming", ("d",)),
        ("slow_warming", ("d",)),
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
        ("quick_warming", ("1",)),
        ("warming", ("1",)),
        ("slow_warming", ("1",)),
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
        ("speed", ("1",)),
        ("speed", ("p", "n")),
        ("temperature", ("1",)),
        ("temperature", ("p", "n")),
        ("quick_warming", ("1",)),
        ("warming", ("1",)),
        ("slow_warming", ("1",)),
        ("time", ("1",)),
        ("time", ("tau",)),
        ("since_reversal", ("last_d*reversed",)),
        # what is twisted by its inertia, where the sensor is on the other side of it
        ("speeding_up", ("last_d",)),
        ("elapsed", ("1",)),
    ),
    TEMPERATURE: (
        ("speed", ("1",)),
        ("temperature", ("1",)),
        ("temperature", ("1", "power")),  # a heat capacity that depends on temperature divides the loss and the cooling
        ("time", ("1",)),
        ("load", ("1",)),
        ("elapsed", ("1",)),
        # what moves, turns a drive on or bends a cable may shift the reading at once, and warms nothing
        ("velocity", (READ,)),
        ("torque", (READ,)),
        ("angle", (READ,)),
    ),
}
# functions of states that are not recorded, as above; none follows the channel itself, not even through the loss: it
# would predict itself
_OF_STATES: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    channel: tuple((name, factors) for names, factors in rows for name in names)
    for channel, rows in {
        MOTOR_TORQUE: (
            (OF_KIND["recent_speed"], ("d",)),
            (OF_KIND["recent_speed"], ("w",)),
            (OF_KIND["recent_load"], ("d",)),
            (OF_KIND["recent_load"], ("tau",)),
            *((OF_KIND[kind], ("d",)) for kind in WORKED),
            (OF_KIND[FILM], ("d",)),
            (OF_KIND[FILM], ("d*abs_tau",)),
        ),
        LOAD_TORQUE: (
            (OF_KIND["taken_along"], ("1",)),
            (OF_KIND["recent_speed"], ("d",)),
            (OF_KIND["recent_load_motor"], ("1",)),
        ),
        TRANSMISSION_ERROR: (
            (OF_KIND["recent_torque"], ("1",)),
            (OF_KIND["impulse"], ("1",)),
            (OF_KIND["recent_load"], ("1",)),
            (OF_KIND["recent_speed"], ("1",)),
            (OF_KIND["recent_loss"], ("1",)),
            *((OF_KIND[kind], ("1",)) for kind in WORKED),
            (OF_KIND[FILM], ("1",)),
            (OF_KIND[FILM], ("last_d",)),
        ),
        TEMPERATURE: (),
    }.items()
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
        *(
            "*".join(("d", *more))
            for n in (2, 3)
            for more in combinations_with_replacement(("abs_tau", "abs_v", "T"), n)
        ),
        *("*".join(more) for n in (2, 3) for more in combinations_with_replacement(("tau", "abs_v", "T"), n)),
    ),
    LOAD_TORQUE: tuple("*".join(("load_motor", *more)) for more in combinations_with_replacement(("abs_v", "T"), 2)),
    TRANSMISSION_ERROR: tuple(
        "*".join((*side, *more))
        for side in ((), ("last_d",))
        for more in combinations_with_replacement(("tau", "v", "T"), 3)
    ),
    TEMPERATURE: (),
}


def single_functions(channel: str) -> list[tuple[str, str]]:
    """Quantities, with one factor each, of which functions of one quantity are candidates of a channel."""
    return [(name, factors[0]) for name, factors in _ONE[channel] if len(factors) == 1]


def in_order(frame: Frame) -> bool:
    """Whether the motion says when something was done: speeds, accelerations, loads or angles that follow one after
    another, as in a sweep. In a motion that repeats they leave all of the time open, but for as much of its variance as
    a form may be off by, and vary inside the pieces more than from one to another.
    """
    number = frame.count

    def varies(values: FloatArray) -> float:
        return float(number @ values**2)

    def centred(values: FloatArray) -> FloatArray:
        return np.asarray(values - np.average(values, weights=number))

    speed, load, rates = np.abs(frame.velocity), np.abs(frame.torque), np.abs(frame.load_acceleration)
    states = [speed, speed**2, rates, frame.torque, load, frame.theta]
    time = centred(frame.time)
    left = excess(time, [centred(values)[:, None] for values in states], number)
    if varies(left) < (1.0 - criteria.SHAPE**2) * varies(time):
        return True
    inside = [(varies(levelled(values, frame, number)), varies(centred(values))) for values in (speed, rates, load)]
    return any(within < criteria.EITHER * whole for within, whole in inside)


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
    recordings of it time may be the order in which things were done, as in a sweep, and then gives no effect its name.
    """
    effects = [t for t in for_channel(channel) if t.effect not in PERIODIC]
    effects += [LIBRARY[e] for e in switched_off if channel in LIBRARY[e].forms and e not in PERIODIC]
    timeless = overlapping(frame) or (cut and channel != TEMPERATURE and in_order(frame))
    for term in effects:
        if term.effect in banned or term.effect in BY_GEOMETRY or (timeless and "time" in term.variables):
            continue
        if free and any(name in QUANTITIES and is_constant(quantity(name, frame)) for name in term.variables):
            continue
        for form in term.forms[channel]:
            # where what it depends on beside the term's own quantities is constant it is one of the plain forms
            if any(is_constant(quantity(name, frame)) for name in form.variables):
                continue
            for point in form.grid(frame):
                yield Named(term, channel, form, point)


def free_candidates(channel: str, frame: Frame, straight: bool = False, states: bool = False) -> Iterator[Free]:
    """Free functions of the quantities that vary in the rows of ``frame``; ``straight``: straight lines as well, where
    each number has its price; ``states``: those of states that are not recorded as well.
    """
    timeless, recordings = overlapping(frame), int(np.unique(frame.recording).size)
    further = _OF_STATES[channel] if states and not timeless else ()
    if not np.any(frame.motor_torque):
        # nothing tells the loss
        further = tuple((name, factors) for name, factors in further if name not in OF_KIND["recent_loss"])
    if any(is_constant(quantity(name, frame)) for name in ("torque", "temperature")):
        # without a load, or at a temperature that nothing measured, it is a function of the speed
        further = tuple((name, factors) for name, factors in further if name not in OF_KIND[FILM])
    for each_name, factors in (*_ONE[channel], *further):
        name = without_a_jump(each_name, frame)
        if name == "time" and timeless:
            continue
        # denser than the recordings, a function of time only says which recording it is
        most = max(recordings // EACH_KNOT, 2) if name == "time" else KNOTS[-1]
        values = quantity(name, frame)
        line = ends(values) if straight else None
        if line is not None and line[1] - line[0] <= _STRAIGHT.get(name, 0.0):
            grids = tuple(Grid((name,), times, (line,)) for times in factors)
            yield Free(channel, grids, by_definition(channel, name, factors))
        for number in sorted({min(n, most) for n in KNOTS}):
            knots = knots_of(values, number)
            if knots is not None and (number <= KNOTS[0] or len(knots) > KNOTS[0]):
                grids = tuple(Grid((name,), times, (knots,)) for times in factors)
                yield Free(channel, grids, by_definition(channel, name, factors))
        close = close_knots(values) if name == "speed" else None
        if close is not None:
            yield Free(
                channel,
                tuple(Grid((name,), times, (close,)) for times in factors),
                by_definition(channel, name, factors),
            )
    for names, times in _MORE[channel]:
        made = set()
        for numbers in KNOTS_OF_SEVERAL[len(names)]:
            each = [knots_of(quantity(name, frame), n) for name, n in zip(names, numbers, strict=True)]
            known = tuple(knots for knots in each if knots is not None)
            if len(known) == len(names) and known not in made:
                made.add(known)
                yield Free(channel, (Grid(names, times, known),))
    constant = {part for part, name in FACTOR_OF.items() if knots_of(quantity(name, frame), KNOTS[0]) is None}
    for times in _PRODUCTS[channel]:
        if constant & set(times.split("*")):
            continue
        yield Free(channel, (Grid((), times, ()),), _of_product(channel, times))
    for times in () if timeless else SPELLS[channel]:
        yield from spells(channel, frame, times)


HARMONIC = "te.harmonic"
LOW_ORDERS = range(1, 13)
"""orders that rows averaged in time show; higher ones are looked for in the rows over the angle"""


def swing_candidates(channel: str, frame: Frame) -> Iterator[Regressor]:
    """Further candidates in the transmission error of a joint that never turns its output round steadily: functions of
    the angle and, where no load torque was recorded that winds the gearbox up, of the motor's torque; and, where it
    was, low orders of which a whole period was run, but for the motor shaft's. Where nothing tells the load, gravity
    winds an arm up as a low order would, and no name is told.
    """
    loaded = not is_constant(quantity("torque", frame))
    term = LIBRARY[HARMONIC]
    travelled = float(np.ptp(frame.theta)) if frame.size else 0.0
    for order in LOW_ORDERS if loaded else ():
        of_shaft = frame.ratio > 1.0 and abs(order / frame.ratio - max(round(order / frame.ratio), 1)) < 1e-6
        if order * travelled >= 2.0 * np.pi and not of_shaft:
            yield Named(term, channel, term.forms[channel][0], (float(order),))
    for name in (without_a_jump(ANGLE, frame), *(() if loaded else ("motor_torque",))):
        values = quantity(name, frame)
        every = [ends(values), *(knots_of(values, number) for number in KNOTS)]
        for knots in dict.fromkeys(k for k in every if k is not None):
            yield Free(channel, (Grid((name,), "1", (knots,)),))


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
    driving = "load_motor_torque" if regressor_channel(regressor) == LOAD_TORQUE else "torque"
    values = quantity(driving, frame)
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


def shape_of(channel: str, regressor: Regressor, frame: Frame, number: int = KNOTS[-1]) -> Free | None:
    """The function by which nature's form of an effect may differ from a name's; None where it has none."""
    grids = []
    form = regressor.form if isinstance(regressor, Named) else None
    for each_name, times in LIBRARY[regressor.effect].shape_of(channel, form):
        name = without_a_jump(each_name, frame)
        knots = knots_of(quantity(name, frame), number)
        if knots is not None:
            grids.append(Grid((name,), times, (knots,)))
    return Free(channel, tuple(grids), regressor.effect) if grids else None
