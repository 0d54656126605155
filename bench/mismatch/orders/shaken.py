"""A shaft that its own ripple shakes: an order of its torque is ripple and inertia times the shaking together.

Rows that are short enough to follow the shaking hold both as well. The inertia is told beside the orders: of each order
that stands, what its model leaves of the torque is compared with what it leaves of the acceleration, over all
recordings and orders together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from bench.mismatch.orders.lines import Complex, Line, Model, Turns, standing
from bench.mismatch.orders.periodicity import Periodicity
from bench.mismatch.orders.shaft import PLAIN, shaft_turns
from bench.mismatch.orders.torques import OUTPUT_MODELS, output_turns
from bench.mismatch.recordings.output_orders import OutputSpectrum
from bench.mismatch.recordings.vibration import ShaftSpectrum
from bench.mismatch.regression.model import ChannelModel

INERTIA = "motor.inertia"
TOLD = 1.96
"""standard deviations from nothing that an inertia has to be: its 95 % interval"""
Seen = TypeVar("Seen", ShaftSpectrum, OutputSpectrum)


def less_inertia(seen: Seen, inertia: float) -> Seen:
    """A spectrum of the motor torque less what an ``inertia`` (kg·m²) asks for."""
    if not inertia or not seen.shaking.size:
        return seen
    return replace(seen, amplitude=seen.amplitude - inertia * seen.shaking)


def inertia_of(model: ChannelModel) -> float:
    """The inertia (kg·m²) that a model of the motor torque has, the simulation's or found; 0 where it has none."""
    blocks = [*model.base, *(block for own in model.chosen for block in own.blocks)]
    return float(sum(model.fit.of(b.place)[0][0] for b in blocks if b.regressor.effect == INERTIA))


def still(seen: Periodicity, inertia: float) -> Periodicity:
    """What is periodic less what an ``inertia`` (kg·m²) asks for."""
    return replace(
        seen,
        shaft=[less_inertia(s, inertia) for s in seen.shaft],
        output=[less_inertia(s, inertia) for s in seen.output],
    )


def inertia_told(seen: Periodicity, seed: int) -> float | None:
    """Inertia (kg·m²) that the orders of revolutions with the inertia's part in them tell; None where they do not tell
    it from nothing.
    """
    product = square = left = 0.0
    freedom = 0
    for turns, shaking, models in _looks(seen):
        for line in standing(turns, models, seed):
            torque, rate = _beyond(turns, turns.vectors, line), _beyond(turns, shaking, line)
            product += float(np.sum((np.conj(rate) * torque).real))
            square += float(np.sum(np.abs(rate) ** 2))
            left += float(np.sum(np.abs(torque) ** 2))
            freedom += 2 * (torque.size - len(line.model))
    if square <= 0.0 or freedom < 2:
        return None
    inertia = product / square
    variance = max(left - product**2 / square, 0.0) / (freedom - 1) / square
    return inertia if inertia > TOLD * np.sqrt(variance) else None


def _looks(seen: Periodicity) -> list[tuple[Turns, Complex, Sequence[Model]]]:
    """Revolutions over the shaft and over the output, the shaking in them (turns, orders), and the models of orders:
    a model of a drive's loop has as many numbers as there are speeds, and takes what the inertia asks for.
    """
    out: list[tuple[Turns, Complex, Sequence[Model]]] = []
    if seen.shaft:
        shaft, turns = shaft_turns(seen)
        out.append((turns, np.array([s.shaking for s in shaft]), PLAIN))
    if seen.output:
        turns = output_turns(seen.output, seen.folds)
        out.append((turns, np.array([s.shaking for s in seen.output]), OUTPUT_MODELS))
    return out


def _beyond(turns: Turns, vectors: Complex, line: Line) -> Complex:
    """What an order's model leaves of its vectors in the training revolutions, over their noise."""
    seen = turns.train & np.isfinite(turns.vectors[:, line.order])
    scale = turns.sigma[seen]
    x = np.column_stack([turns.factors[t][seen] for t in line.model]) / scale[:, None]
    y = vectors[seen, line.order] / scale
    return np.asarray(y - x @ np.linalg.lstsq(x.astype(np.complex128), y, rcond=None)[0])
