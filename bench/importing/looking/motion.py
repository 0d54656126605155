"""Which angles and speeds of a file are of one machine, and on which side of its gearbox."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from bench.importing.looking.guesses import STRETCH, FloatArray, integral, overflow, ratio_of
from bench.importing.looking.inventory import Column
from bench.importing.looking.names import Meaning
from bench.importing.units import si_of, unit_of

_SAME_SIDE = 1.1
"""how much faster a speed may be than the rate of an angle for both to be of one shaft"""
_TOGETHER, _APART = 0.95, 0.5
"""correlations of what two angles move in a stretch: above the first they turn together, below the second not"""


def values_of(column: Column, own: Meaning) -> FloatArray:
    """Values of a column in SI units, unwrapped where it is an angle that starts again."""
    values = column.seconds
    wraps = overflow(column, own.unit, own.counted) if own.quantity == "angle" else None
    if wraps is not None:
        values = np.unwrap(values, period=wraps)
    return values * unit_of("counts" if own.counted else own.unit, "").factor


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Angles and speeds of a file with what they may be, and the clock in ``seconds`` where it is known."""

    meanings: Mapping[str, Meaning]
    seconds: FloatArray | None

    def ratio(self, motor: Column, load: Column) -> float | None:
        """Gear ratio, were the one of the motor's side and the other of the output's; None where they do not fit."""
        own = [self.meanings[column.name] for column in (motor, load)]
        units = {si_of(one.unit).removesuffix("/s") for one in own}
        if len(units) > 1 or "" in units:
            return None
        if own[0].quantity == own[1].quantity:
            return ratio_of(values_of(motor, own[0]), values_of(load, own[1]))
        angles = [self._angle(column) for column in (motor, load)]
        return None if angles[0] is None or angles[1] is None else ratio_of(angles[0], angles[1])

    def of_output(self, angle: Column, velocity: Column) -> Column | None:
        """Which of the two is the output's if it turns so much slower than the other; None where its name says a side,
        or both are of one shaft.
        """
        ratio = self.ratio(velocity, angle)
        if ratio is None or 1.0 / _SAME_SIDE < abs(ratio) < _SAME_SIDE:
            return None
        slower = angle if abs(ratio) > 1.0 else velocity
        return None if self.meanings[slower.name].sided else slower

    def strangers(self, columns: Iterable[Column]) -> set[str]:
        """Names of angles that turn by themselves where another one turns with the speed: another joint's, say."""
        moving = [own for own in columns if not own.constant and not self.meanings[own.name].setpoint]
        speeds = [own for own in moving if self.meanings[own.name].quantity == "velocity"]
        angles = [own for own in moving if self.meanings[own.name].quantity == "angle"]
        run = self._angle(speeds[0]) if speeds else None
        if run is None:
            return set()
        together = {own.name: _together(run, self._angle(own)) for own in angles}
        if not any(own is not None and own > _TOGETHER for own in together.values()):
            return set()
        return {name for name, own in together.items() if own is not None and own < _APART}

    def _angle(self, column: Column) -> FloatArray | None:
        """An angle, or the integral of a speed; None where unit or clock are not known."""
        own = self.meanings[column.name]
        if not si_of(own.unit):
            return None
        values = values_of(column, own)
        if own.quantity == "angle":
            return values
        return None if self.seconds is None or self.seconds.size != values.size else integral(self.seconds, values)


def _together(one: FloatArray, other: FloatArray | None) -> float | None:
    """Correlation of what two angles move in stretches, whatever the sign; None where one of them rests."""
    if other is None or other.size != one.size or one.size <= 2 * STRETCH:
        return None
    moved = [own[STRETCH:] - own[:-STRETCH] for own in (one, other)]
    good = np.isfinite(moved[0]) & np.isfinite(moved[1])
    x, y = (own[good] for own in moved)
    return abs(float(np.corrcoef(x, y)[0, 1])) if x.size and np.std(x) > 0.0 and np.std(y) > 0.0 else None
