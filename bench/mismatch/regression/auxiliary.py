"""Free functions of quantities that are no channel of the bench: what a logger recorded beside it, ``aux/NAME``.

No term of the library knows such a quantity, so a dependence on it has no name but its own: the finding is unknown
physics, said to depend on ``aux/NAME``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import combinations, product

import numpy as np

from bench.mismatch.regression.knots import KNOTS, ends, knots_of
from bench.mismatch.regression.regressors import Free, Regressor
from bench.mismatch.regression.sensitivity import is_carried
from bench.simulation.composed import OUTPUT_ANGLE, acceleration_of, parts_of, summed
from bench.simulation.frame import Frame
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


def of_auxiliary(regressor: Regressor) -> bool:
    """Whether a regressor depends on a quantity that is no channel of the bench."""
    return any(name.startswith(AUXILIARY) for name in regressor.variables)


def auxiliary_candidates(channel: str, frame: Frame) -> Iterator[Free]:
    """Functions of each auxiliary quantity that varies in the rows of ``frame``: straight, and of some knots, times
    each factor that a channel's losses go by.
    """
    steady = {part for part, name in FACTOR_OF.items() if knots_of(quantity(name, frame), KNOTS[0]) is None}
    for name in _recorded(frame):
        values = frame.aux[name]
        straight = ends(values)
        if straight is None:
            continue
        several = knots_of(values, KNOTS[0])
        for times in _TIMES[channel]:
            if steady & set(times.split("*")):
                continue
            for knots in (straight, several):
                if knots is not None:
                    yield Free(channel, (Grid((AUXILIARY + name,), times, (knots,)),))


MOST_ANGLES = 3
"""angles in one sum: a link is turned by its own joint and those before it; more hardly differ from each other"""
MOST_IN_SUMS = 8
"""auxiliary angles from which on only pairs are summed"""
LEAST_RANGE, MOST_RANGE = 0.2, 200.0
"""rad: how far a quantity varies that can be the angle of a joint"""


def composed_candidates(channel: str, frame: Frame, allowed: Collection[str] | None = None) -> Iterator[Free]:
    """Functions of auxiliary quantities that are composed of them: cosine and sine of sums of joints' angles together,
    as gravity and as an inertia that changes; acceleration, sign, size and rate of each; products of two. In the
    torques only. ``allowed``: those that may be angles; None where nothing tells.
    """
    if channel not in (MOTOR_TORQUE, LOAD_TORQUE):
        return
    names = [n for n in _recorded(frame) if ends(frame.aux[n]) is not None]
    angles = names if allowed is None else [n for n in names if n in allowed]
    joints = [n for n in angles if LEAST_RANGE <= float(np.ptp(frame.aux[n])) <= MOST_RANGE]
    most = MOST_ANGLES if len(joints) <= MOST_IN_SUMS else 2
    for number in range(1, most + 1):
        for combined in combinations((OUTPUT_ANGLE, *joints), number):
            if combined == (OUTPUT_ANGLE,):
                continue  # gravity of the output itself has a name
            for signs in product((1, -1), repeat=number - 1):
                text = summed(combined, (1, *signs))
                waves = [f"{f}({text})" for f in ("cos", "sin")]
                yield from _together(channel, waves, frame)
                if channel == MOTOR_TORQUE:
                    yield from _together(channel, [f"momentum({wave})" for wave in waves], frame)
    if channel == MOTOR_TORQUE:
        for name in joints:
            yield from _together(channel, [acceleration_of(name)], frame)
            yield from _together(channel, [f"carried({f}({OUTPUT_ANGLE}), {name})" for f in ("cos", "sin")], frame)
    # the size of what never changes its sign is itself
    single = [f"{f}({n})" for n in names if np.ptp(np.sign(frame.aux[n])) > 1.0 for f in ("sign", "abs")]
    single += [f"rate({n})" for n in names]
    pairs = [f"product({a}, {b})" for a, b in combinations(names, 2)]
    for name in (*single, *pairs):
        grid = _straight(name, "1", frame)
        if grid is not None:
            yield Free(channel, (grid,))


def _recorded(frame: Frame) -> list[str]:
    """Auxiliary quantities that were recorded: neither what a simulation says nor their rates."""
    return [name for name in sorted(frame.aux) if not is_carried(name) and parts_of(name) == (name,)]


def _together(channel: str, names: Sequence[str], frame: Frame) -> Iterator[Free]:
    """Straight lines over some composed quantities as one function; none where none varies."""
    grids = tuple(grid for name in names if (grid := _straight(name, "1", frame)) is not None)
    if grids:
        yield Free(channel, grids)


def _straight(name: str, times: str, frame: Frame) -> Grid | None:
    """A straight line over a composed quantity; None where that does not vary."""
    straight = ends(quantity(AUXILIARY + name, frame))
    return None if straight is None else Grid((AUXILIARY + name,), times, (straight,))
