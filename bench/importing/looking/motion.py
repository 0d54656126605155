"""Which angles and speeds of a file are of one machine, and on which side of its gearbox."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from bench.importing.looking.column import Column
from bench.importing.looking.guesses import (
    STRETCH,
    FloatArray,
    integral,
    of_sign_and_size,
    overflow,
    ratio_of,
    sign_bit,
)
from bench.importing.looking.names import Meaning
from bench.importing.units import si_of, unit_of

_SAME_SIDE = 1.1
"""how much faster a speed may be than the rate of an angle for both to be of one shaft"""
_ONE_WAY = 0.5
"""Mean sign of what an angle moves, below which it goes to and fro: a quarter of it goes against the rest."""
_TOGETHER, _APART = 0.95, 0.5
"""correlations of what two angles move in a stretch: above the first they turn together, below the second not"""


def values_of(column: Column, column_meaning: Meaning) -> FloatArray:
    """Values of a column in SI units, with a sign that stands in a bit; an angle that starts again is unwrapped."""
    values = column.seconds
    bit = sign_bit(column)
    if bit is not None:
        values = of_sign_and_size(values, bit)
    elif column_meaning.quantity == "angle":
        wraps = overflow(column, column_meaning.unit, column_meaning.counted)
        values = values if wraps is None else np.unwrap(values, period=wraps)
    return values * unit_of("counts" if column_meaning.counted else column_meaning.unit, "").factor


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Angles and speeds of a file with what they may be, and the clock in ``seconds`` where it is known."""

    meanings: Mapping[str, Meaning]
    seconds: FloatArray | None

    def ratio(self, motor: Column, load: Column) -> float | None:
        """Gear ratio, were the one of the motor's side and the other of the output's; None where they do not fit."""
        column_meanings = [self.meanings[column.name] for column in (motor, load)]
        units = {si_of(one.unit).removesuffix("/s") for one in column_meanings}
        if len(units) > 1 or "" in units:
            return None
        if column_meanings[0].quantity == column_meanings[1].quantity:
            return ratio_of(values_of(motor, column_meanings[0]), values_of(load, column_meanings[1]))
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

    def other_side(self, angle: Column, others: Iterable[Column]) -> Column | None:
        """Another measured angle that turns with this one, farther or less far: that of the gearbox' other side."""
        for column in others:
            meaning = self.meanings[column.name]
            if meaning.quantity != "angle" or meaning.setpoint or column.constant:
                continue
            if column.values.size == angle.values.size and meaning.unit == self.meanings[angle.name].unit:
                ratio = ratio_of(*(values_of(own, self.meanings[own.name]) for own in (angle, column)))
                if ratio is not None and not 1.0 / _SAME_SIDE < abs(ratio) < _SAME_SIDE:
                    return column
        return None

    def turned(self, angle: Column) -> float:
        """Range over which an angle turns, in SI units of what its column says; starting again does not count."""
        values = values_of(angle, self.meanings[angle.name])
        return float(np.nanmax(values) - np.nanmin(values))

    def counts_per_revolution(self, angle: Column, velocity: Column) -> float | None:
        """Counts of an encoder in a revolution, were a speed that of its shaft; None where they do not fit."""
        run = self._angle(velocity)
        if run is None or self.meanings[velocity.name].quantity != "velocity" or run.size != angle.values.size:
            return None
        per_radian = ratio_of(values_of(angle, self.meanings[angle.name]), run)
        return None if per_radian is None else abs(per_radian) * 2 * np.pi

    def against(self, angle: Column, velocity: Column) -> bool:
        """Whether a speed keeps one sign and an angle goes to and fro all the same: they are of no shaft, whatever the
        clock. A phase angle of a power analyser is one such, beside the speed of the motor.

        It is asked of single steps, of which an angle that starts again spoils few, and of stretches, of which noise
        does not.
        """
        if (self.meanings[angle.name].quantity, self.meanings[velocity.name].quantity) != ("angle", "velocity"):
            return False
        speeds = velocity.seconds[np.isfinite(velocity.seconds)]
        angles = angle.seconds[np.isfinite(angle.seconds)]
        if not speeds.size or angles.size <= 2 * STRETCH or float(np.min(speeds)) <= 0.0 <= float(np.max(speeds)):
            return False
        moved = [angles[span:] - angles[:-span] for span in (1, STRETCH)]
        return all(abs(float(np.mean(np.sign(way[way != 0.0])))) < _ONE_WAY for way in moved if np.any(way))

    def strangers(self, columns: Iterable[Column]) -> set[str]:
        """Names of angles that turn by themselves where another one turns with the speed: another joint's, say."""
        moving = [column for column in columns if not column.constant and not self.meanings[column.name].setpoint]
        speeds = [column for column in moving if self.meanings[column.name].quantity == "velocity"]
        angles = [column for column in moving if self.meanings[column.name].quantity == "angle"]
        run = self._angle(speeds[0]) if speeds else None
        if run is None:
            return set()
        together = {column.name: _together(run, self._angle(column)) for column in angles}
        if not any(correlation is not None and correlation > _TOGETHER for correlation in together.values()):
            return set()
        return {name for name, correlation in together.items() if correlation is not None and correlation < _APART}

    def _angle(self, column: Column) -> FloatArray | None:
        """An angle, or the integral of a speed; None where unit or clock are not known."""
        column_meaning = self.meanings[column.name]
        if not si_of(column_meaning.unit):
            return None
        values = values_of(column, column_meaning)
        if column_meaning.quantity == "angle":
            return values
        return None if self.seconds is None or self.seconds.size != values.size else integral(self.seconds, values)


def _together(one: FloatArray, other: FloatArray | None) -> float | None:
    """Correlation of what two angles move in stretches, whatever the sign; None where one of them rests."""
    if other is None or other.size != one.size or one.size <= 2 * STRETCH:
        return None
    moved = [angle[STRETCH:] - angle[:-STRETCH] for angle in (one, other)]
    good = np.isfinite(moved[0]) & np.isfinite(moved[1])
    x, y = (angle[good] for angle in moved)
    return abs(float(np.corrcoef(x, y)[0, 1])) if x.size and np.std(x) > 0.0 and np.std(y) > 0.0 else None
