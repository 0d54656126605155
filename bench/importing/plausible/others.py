"""What other axes do to the torque: columns beside the law of motion, so that its friction has its own sign."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.importing.plausible.motion import POSITION, SURE, Blocks, Law, law, over_position

FloatArray = NDArray[np.float64]
MOTIONS = ("rad", "m", "rad/s", "m/s")
"""SI units of channels that say how another axis moves. Torques, currents, voltages and pressures are left out: the
drive's own follow from the friction that is asked for, and would hide it or turn its sign."""
_ALONG = 0.9
"""Correlation of two speeds from which an axis moves along with the motor. It may be a second encoder of the same
shaft, of which the difference is the torque itself, or another axis that drives this one: neither can be fitted."""
_LATE_S = 0.3
"""Seconds by which one may come after the other all the same: a motor follows its set value so."""
_BLOCKS_PER_COLUMN = 30
"""Least number of blocks of motion for each column of the law: a block is correlated with some of its neighbours."""
_ENOUGH = 0.9
"""Share of stretches left out that the law alone predicts, from which no other axis is asked. What is left then is
little, and the set value of the motor's own controller would explain it: its torque is the difference of both."""
_BETTER = 0.9
"""What is left of stretches left out, with an axis over without it, from which the axis is taken (variances)."""


@dataclass(frozen=True, slots=True)
class Beside:
    """The law of motion beside other axes: ``taken`` are those that it needs, ``along`` those that move along with
    the motor and cannot be told from it.
    """

    law: Law
    taken: tuple[str, ...] = ()
    along: tuple[str, ...] = ()


def law_beside(
    averaged: Blocks, torque: str, load: str | None, others: Mapping[str, str], *, linear: bool
) -> Beside | None:
    """Fit the law, with what other axes do where stretches that are left out are predicted better with it.

    One axis after the other is taken, the best first: the sines and cosines of its angle and their products with
    those of the motor's position and of the axes taken before (gravity along a chain of joints), and its acceleration.

    Parameters
    ----------
    averaged : blocks of the motor's motion, with :data:`~bench.importing.plausible.motion.POSITION` and the others.
    others : SI unit (of :data:`MOTIONS`) of each channel that is another axis' angle or speed.

    Returns
    -------
    None where nothing moves.
    """
    alone = law(averaged, torque, load, linear=linear)
    if alone is None:
        return None
    own = _shapes(averaged.channels[POSITION], linear=linear)
    axes = {name: _Axis.of(averaged, name, unit) for name, unit in others.items()}
    axes = {name: axis for name, axis in axes.items() if float(np.std(axis.speed)) > 0.0}
    late = max(1, round(_LATE_S / float(np.median(np.diff(averaged.time)))))
    along = tuple(name for name, axis in axes.items() if _correlation(axis.speed, averaged.speed, late) > _ALONG)
    best = alone
    taken: list[str] = []
    columns: list[FloatArray] = []
    while alone.predicted < _ENOUGH:
        trials: list[tuple[Law, str, list[FloatArray]]] = []
        for name, axis in axes.items():
            if name in along or name in taken:
                continue
            more = [*columns, *axis.columns(own, [axes[other] for other in taken])]
            if np.sum(averaged.moving) < _BLOCKS_PER_COLUMN * (len(more) + len(own)):
                continue
            fitted = law(averaged, torque, load, linear=linear, beside=more)
            if fitted is not None:
                trials.append((fitted, name, more))
        if not trials:
            break
        fitted, name, more = max(trials, key=lambda trial: trial[0].predicted)
        if 1.0 - fitted.predicted > _BETTER * (1.0 - best.predicted):
            break
        best, columns = fitted, more
        taken.append(name)
    if alone.loss_t > SURE and best.loss_t < -SURE:
        return Beside(alone, (), along)  # what was taken turns a friction that is positive for sure: it is no load
    return Beside(best, tuple(taken), along)


@dataclass(frozen=True, slots=True)
class _Axis:
    """Motion of another axis in blocks (M,): ``shapes`` over its position (none where only its speed is known)."""

    shapes: list[FloatArray]
    speed: FloatArray
    acceleration: FloatArray

    @classmethod
    def of(cls, averaged: Blocks, name: str, unit: str) -> _Axis:
        values = averaged.channels[name]
        if unit.endswith("/s"):
            return cls([], values, np.gradient(values, averaged.time))
        speed = np.gradient(values, averaged.time)
        shapes = over_position(values, linear=unit == "m")
        return cls(shapes, speed, np.gradient(speed, averaged.time))

    def columns(self, own: Sequence[FloatArray], before: Sequence[_Axis]) -> list[FloatArray]:
        """What it may do beside the motor's position (``own`` shapes) and the axes taken ``before``; each of mean 0."""
        products = [mine * theirs for axis in before for mine in self.shapes for theirs in axis.shapes]
        raw = [shape * at for shape in (*self.shapes, *products, self.acceleration) for at in own]
        return [column - np.mean(column) for column in raw]


def _shapes(position: FloatArray, *, linear: bool) -> list[FloatArray]:
    """A constant, and what may act over the motor's position."""
    return [np.ones(position.size), *over_position(position, linear=linear)]


def _correlation(one: FloatArray, other: FloatArray, late: int) -> float:
    """Largest correlation, whatever its sign, with either up to ``late`` samples after the other; 0 where one rests."""
    found = 0.0
    for shift in range(-late, late + 1):
        x, y = (one[shift:], other[: other.size - shift]) if shift >= 0 else (one[:shift], other[-shift:])
        if float(np.std(x)) > 0.0 and float(np.std(y)) > 0.0:
            found = max(found, abs(float(np.corrcoef(x, y)[0, 1])))
    return found
