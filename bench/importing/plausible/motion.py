"""Torque, speed and acceleration of a recording in blocks, and the plainest law of motion fitted to them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_BLOCKS_PER_SECOND = 50.0
_CHUNKS = 8
_MOST_BLOCKS = 20_000
_LEAST_BLOCKS = 80
_STANDING = 0.02
SURE = 5.0
"""Standard deviations from which a sign is sure: the spread is that over eight stretches, so it is not well known."""
_NOTHING = 1e-9
"""Singular value over the largest from which columns are taken for a sum of others."""
POSITION = "position"
"""key of the output's position among the channels of :class:`Blocks`: rad, on a linear axis m"""
ARC = np.radians(60.0)
"""Range of the output's angle from which a force over the position is told from a straight line: a sine leaves its
tangent by 5 % over half of it. Below it a constant, a sine and a cosine are nearly the same three numbers."""


@dataclass(frozen=True, slots=True)
class Blocks:
    """Means over blocks (M,): ``time`` in s, ``speed`` and ``acceleration`` of an angle, and the channels asked for."""

    time: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    channels: dict[str, FloatArray]

    @property
    def moving(self) -> NDArray[np.bool_]:
        """Blocks in which it moves."""
        return np.asarray(np.abs(self.speed) > _STANDING * float(np.percentile(np.abs(self.speed), 99)))


def blocks(time: FloatArray, angle: FloatArray, channels: dict[str, FloatArray]) -> Blocks | None:
    """Average over about a fiftieth of a second; None where there are too few blocks to say anything."""
    rate = (time.size - 1) / (time[-1] - time[0])
    size = max(1, round(rate / _BLOCKS_PER_SECOND), time.size // _MOST_BLOCKS)
    count = time.size // size
    if count < _LEAST_BLOCKS:
        return None

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(values[: count * size].reshape(count, size).mean(axis=1))

    moment, angles_mean = mean(time), mean(angle)
    speed = np.gradient(angles_mean, moment)
    acceleration = np.gradient(speed, moment)
    inner = slice(2, -2)
    averaged = {name: mean(samples)[inner] for name, samples in channels.items()}
    return Blocks(moment[inner], speed[inner], acceleration[inner], averaged)


@dataclass(frozen=True, slots=True)
class Law:
    """Torque = inertia·acceleration + friction + load·(load torque) + force over the position + constant, with the
    spread of each (t-values).

    ``loss`` is the mean power that friction takes, W; ``share`` of the torque's variance that the law explains, and
    ``predicted`` the share of stretches that were left out of the fit (negative where it is worse than the mean).
    ``carried`` is the mean size of the power that goes into or out of the load, W (0 without one).
    """

    inertia: float
    inertia_t: float
    loss: float
    loss_t: float
    load: float | None
    load_t: float
    share: float
    predicted: float
    carried: float = 0.0

    @property
    def load_spread(self) -> float:
        """Standard deviation of ``load``; infinite where it is not known."""
        return abs((self.load or 0.0) / self.load_t) if self.load_t else math.inf


def over_position(position: FloatArray, *, linear: bool) -> list[FloatArray]:
    """What gravity or a spring may do over the output's position (N,): sine and cosine of its angle, or a straight
    line where it turns less than :data:`ARC` or the axis is linear; nothing where it rests.
    """
    span = float(np.ptp(position))
    if not linear and span > ARC:
        return [np.sin(position), np.cos(position)]
    return [(position - np.mean(position)) / span] if span > 0.0 else []


def law(
    averaged: Blocks, torque: str, load: str | None, *, linear: bool = False, beside: Sequence[FloatArray] = ()
) -> Law | None:
    """Fit the law; the spreads are those over eight stretches, each left out once. None where nothing moves.

    The force over the position is fitted where ``averaged`` has a :data:`POSITION`; ``beside`` are columns (M,) of
    what else may act, fitted along.
    """
    moving = averaged.moving
    if np.sum(moving) < _LEAST_BLOCKS // 2 or float(np.std(averaged.channels[torque][moving])) == 0.0:
        return None
    speed = averaged.speed[moving]
    columns = [averaged.acceleration[moving], speed, np.ones(speed.size)]
    both = min(float(np.mean(speed > 0)), float(np.mean(speed < 0))) > _STANDING
    if both:
        columns.append(np.sign(speed))
    if POSITION in averaged.channels:
        columns += over_position(averaged.channels[POSITION][moving], linear=linear)
    columns += [column[moving] for column in beside]
    if load is not None and float(np.std(averaged.channels[load][moving])) > 0.0:
        columns.append(averaged.channels[load][moving])
    else:
        load = None
    design = np.column_stack(columns)
    y = averaged.channels[torque][moving]

    # one direction: friction cannot be separated from a constant, and both together have to take power
    terms = [1, 3] if both else [1, 2]

    scale = np.abs(design).max(axis=0)
    scale = np.where(scale > 0, scale, 1.0)
    chunk = np.arange(y.size) * _CHUNKS // y.size
    # a triangle stands for the rows of a stretch: it has their sums of squares, and fits are made of few rows
    both_sides = np.column_stack([design / scale, y])
    triangles = [np.linalg.qr(both_sides[chunk == k], mode="r") for k in range(_CHUNKS)]

    def solved(without: int | None) -> FloatArray:
        rows = np.vstack([triangle for k, triangle in enumerate(triangles) if k != without])
        return np.asarray(np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=_NOTHING)[0])

    def squares(k: int, scaled: FloatArray) -> float:
        return float(np.sum((triangles[k] @ np.append(scaled, -1.0)) ** 2))

    def numbers(scaled: FloatArray) -> FloatArray:
        beta = scaled / scale
        loss = float(np.mean((design[:, terms] @ beta[terms]) * speed))
        return np.array([beta[0], loss, beta[-1] if load is not None else 0.0])

    of_all = solved(None)
    whole = numbers(of_all)
    others = [solved(k) for k in range(_CHUNKS)]
    left_out = np.array([numbers(other) for other in others])
    spread = np.sqrt((_CHUNKS - 1) / _CHUNKS * np.sum((left_out - left_out.mean(axis=0)) ** 2, axis=0))
    t = whole / np.where(spread > 0, spread, np.inf)
    total = y.size * float(np.var(y))
    share = 1.0 - sum(squares(k, of_all) for k in range(_CHUNKS)) / total
    predicted = 1.0 - sum(squares(k, other) for k, other in enumerate(others)) / total
    inertia, loss, of_load = (float(value) for value in whole)
    carried = 0.0 if load is None else float(np.mean(np.abs(of_load * averaged.channels[load][moving] * speed)))
    with_load = of_load if load else None
    return Law(inertia, float(t[0]), loss, float(t[1]), with_load, float(t[2]), share, predicted, carried)
