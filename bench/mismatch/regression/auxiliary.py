"""Free functions of quantities that are no channel of the bench: what a logger recorded beside it, ``aux/NAME``.

No term of the library knows such a quantity, so a dependence on it has no name but its own: the finding is unknown
physics, said to depend on ``aux/NAME``.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product

import numpy as np

from bench.mismatch.regression.candidates import KNOTS, knots_of
from bench.mismatch.regression.regressors import Free
from bench.mismatch.regression.sensitivity import is_carried
from bench.simulation.composed import OWN_ANGLE, summed
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import AUXILIARY, FACTOR_OF, quantity
from bench.simulation.tables import Grid
from bench.simulation.terms import LOAD_TORQUE, MOTOR_TORQUE, TEMPERATURE, TRANSMISSION_ERROR

# factors: of drag, of the drag that grows with speed, of what does not ask for the motion, of losses that follow load
_TIMES: dict[str, tuple[str, ...]] = {
    MOTOR_TORQUE: ("d", "w", "1", "d*abs_tau"),
    LOAD_TORQUE: ("d", "w", "1", "load_motor"),
    TRANSMISSION_ERROR: ("1", "last_d", "tau"),
    TEMPERATURE: ("1",),
}


def auxiliary_candidates(channel: str, frame: Frame) -> Iterator[Free]:
    """Functions of each auxiliary quantity that varies in the rows of ``frame``: straight, and of some knots, times
    each factor that a channel's losses go by.
    """
    steady = {part for part, name in FACTOR_OF.items() if knots_of(quantity(name, frame), KNOTS[0]) is None}
    for name in sorted(frame.aux):
        values = frame.aux[name]
        ends = _ends(values)
        if ends is None or is_carried(name):
            continue
        several = knots_of(values, KNOTS[0])
        for times in _TIMES[channel]:
            if steady & set(times.split("*")):
                continue
            for knots in (ends, several):
                if knots is not None:
                    yield Free(channel, (Grid((AUXILIARY + name,), times, (knots,)),))


MOST_ANGLES = 3
"""angles in one sum: a link is turned by its own joint and those before it; more hardly differ from each other"""
MOST_IN_SUMS = 8
"""auxiliary angles from which on only pairs are summed"""
LEAST_TURN, MOST_TURN = 0.2, 200.0
"""rad: how far a quantity varies that can be the angle of a joint"""


def composed_candidates(channel: str, frame: Frame) -> Iterator[Free]:
    """Functions of auxiliary quantities that are composed of them: cosine and sine of sums of joints' angles together;
    sign, size and rate of each; products of two. In the torques only.
    """
    if channel not in (MOTOR_TORQUE, LOAD_TORQUE):
        return
    names = [n for n in sorted(frame.aux) if not is_carried(n) and _ends(frame.aux[n]) is not None]
    joints = [n for n in names if LEAST_TURN <= float(np.ptp(frame.aux[n])) <= MOST_TURN]
    most = MOST_ANGLES if len(joints) <= MOST_IN_SUMS else 2
    for number in range(1, most + 1):
        for own in combinations((OWN_ANGLE, *joints), number):
            if own == (OWN_ANGLE,):
                continue
            for signs in product((1, -1), repeat=number - 1):
                text = summed(own, (1, *signs))
                made = [_straight(f"{f}({text})", "1", frame) for f in ("cos", "sin")]
                grids = tuple(g for g in made if g is not None)
                if grids:
                    yield Free(channel, grids)
    single = [f"{f}({n})" for n in names for f in ("sign", "abs", "rate")]
    pairs = [f"product({a}, {b})" for a, b in combinations(names, 2)]
    for name in (*single, *pairs):
        grid = _straight(name, "1", frame)
        if grid is not None:
            yield Free(channel, (grid,))


def _straight(name: str, times: str, frame: Frame) -> Grid | None:
    """A straight line over a composed quantity; None where that does not vary."""
    ends = _ends(quantity(AUXILIARY + name, frame))
    return None if ends is None else Grid((AUXILIARY + name,), times, (ends,))


def _ends(values: FloatArray) -> tuple[float, float] | None:
    """The least and the largest value: a table of two knots is a straight line. None for a constant."""
    if values.size == 0 or not np.isfinite(values).all():
        return None
    low, high = float(values.min()), float(values.max())
    return (low, high) if high - low > 1e-9 * (abs(low) + abs(high)) else None
