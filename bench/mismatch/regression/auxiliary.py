"""Free functions of quantities that are no channel of the bench: what a logger recorded beside it, ``aux/NAME``.

No term of the library knows such a quantity, so a dependence on it has no name but its own: the finding is unknown
physics, said to depend on ``aux/NAME``.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bench.mismatch.regression.candidates import KNOTS, knots_of
from bench.mismatch.regression.regressors import Free
from bench.mismatch.regression.sensitivity import is_carried
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


def _ends(values: FloatArray) -> tuple[float, float] | None:
    """The least and the largest value: a table of two knots is a straight line. None for a constant."""
    if values.size == 0 or not np.isfinite(values).all():
        return None
    low, high = float(values.min()), float(values.max())
    return (low, high) if high - low > 1e-9 * (abs(low) + abs(high)) else None
