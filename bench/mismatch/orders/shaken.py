"""A shaft that its own ripple shakes: an order of its torque is ripple and inertia times the shaking together.

Rows that are short enough to follow the shaking hold both as well. The inertia is told beside the orders: of each order
that stands, what its model leaves of the torque is compared with what it leaves of the acceleration, over all
recordings and orders together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.orders.lines import Complex, Line, Model, Revolutions, significant_lines
from bench.mismatch.orders.periodicity import Periodicity
from bench.mismatch.orders.shaft import PLAIN, SHAFT_MODELS, shaft_revolutions
from bench.mismatch.orders.torques import OUTPUT_MODELS, output_revolutions
from bench.mismatch.recordings.output_orders import OutputSpectrum
from bench.mismatch.recordings.smoothing import passed_by
from bench.mismatch.recordings.vibration import ShaftSpectrum
from bench.mismatch.regression.model import ChannelModel
from bench.simulation.frame import FloatArray

INERTIA = "motor.inertia"
"""term whose constant is the inertia: a shaft that speeds up asks it for torque, and stores energy by it"""
PASSED = 0.5
"""share of an acceleration that the window of the rates lets pass, from which its order is asked for the inertia: the
rest is made up for, and with it the noise in what passed
"""
FINE, FAR = 1000, 5.0
"""frequencies at which the share that passes is calculated, and periods in the window up to which there are any"""
Seen = TypeVar("Seen", ShaftSpectrum, OutputSpectrum)


@dataclass(frozen=True, slots=True)
class Rates:
    """How accelerations were smoothed: over ``span`` s, at a sample ``rate`` in Hz."""

    rate: float
    span: float

    def passed(self, hertz: FloatArray) -> FloatArray:
        """Share of an acceleration that passes, at many frequencies in Hz, between those of a fine grid; nothing far
        beyond what the window lasts.
        """
        fine = np.linspace(0.0, FAR / self.span, FINE)
        share = np.append(1.0, passed_by(self.rate, self.span, fine[1:]))
        out: FloatArray = np.interp(hertz, fine, share, right=0.0)
        return out


def _hertz(seen: Seen) -> FloatArray:
    """How fast each order of a spectrum is, Hz."""
    first = seen.hertz if isinstance(seen, ShaftSpectrum) else abs(seen.velocity) / (2.0 * np.pi)
    return np.asarray(first * np.arange(seen.shaking.size), dtype=np.float64)


def less_inertia(seen: Seen, inertia: float, rates: Rates) -> Seen:
    """A spectrum of the motor torque less what an ``inertia`` (kg·m²) asks for. What the window of the rates takes of
    an order's acceleration is made up for where most of it passes.
    """
    if not inertia or not seen.shaking.size:
        return seen
    passed = rates.passed(_hertz(seen))
    return replace(seen, amplitude=seen.amplitude - inertia * seen.shaking / np.where(passed >= PASSED, passed, 1.0))


def inertia_of(model: ChannelModel) -> float:
    """The inertia (kg·m²) that a model of the motor torque has, the simulation's or found; 0 where it has none."""
    return float(sum(value for value, _ in _inertias(model, INERTIA)))


def largest_inertia(model: ChannelModel, effect: str) -> float | None:
    """The largest inertia (kg·m²) that a model may have by a term ``effect``, as far as 95 % of intervals reach; None
    where it has none that is told from nothing.
    """
    found = _inertias(model, effect)
    value, std = sum(v for v, _ in found), float(np.sqrt(sum(s**2 for _, s in found)))
    return float(value + criteria.TOLD * std) if value > criteria.TOLD * std else None


def _inertias(model: ChannelModel, effect: str) -> list[tuple[float, float]]:
    """Values and standard deviations of a term that is an inertia."""
    blocks = [*model.base, *(block for chosen in model.chosen for block in chosen.blocks)]
    fits = [model.fit.of(b.indices) for b in blocks if b.regressor.effect == effect]
    return [(float(value[0]), float(np.sqrt(covariance[0, 0]))) for value, covariance in fits]


def without_shaking(seen: Periodicity, inertia: float, rates: Rates) -> Periodicity:
    """What is periodic less the torque that an ``inertia`` (kg·m²) takes."""
    return replace(
        seen,
        shaft=[less_inertia(s, inertia, rates) for s in seen.shaft],
        output=[less_inertia(s, inertia, rates) for s in seen.output],
    )


def inertia_from_orders(seen: Periodicity, rates: Rates, seed: int) -> float | None:
    """Inertia (kg·m²) estimated from orders of revolutions that have the inertia's part in them; None where they do not
    tell it from nothing. What the smoothing of the acceleration takes of an order is made up for, and orders that are
    too fast for it say nothing.
    """
    product = square = left = 0.0
    freedom = 0
    for revolutions, shaking, hertz, models, plain in _looks(seen):
        passed = rates.passed(hertz)
        slow = np.all(passed >= PASSED, axis=0)
        shaking = shaking / np.where(slow, passed, 1.0)
        for line in significant_lines(revolutions, models, seed):
            if line.model not in plain or not slow[line.order] or (plain is PLAIN and line.order in seen.followed):
                continue
            torque, shaken = _beyond(revolutions, revolutions.vectors, line), _beyond(revolutions, shaking, line)
            product += float(np.sum((np.conj(shaken) * torque).real))
            square += float(np.sum(np.abs(shaken) ** 2))
            left += float(np.sum(np.abs(torque) ** 2))
            freedom += 2 * (torque.size - len(line.model))
    if square <= 0.0 or freedom < 2:
        return None
    inertia = product / square
    variance = max(left - product**2 / square, 0.0) / (freedom - 1) / square
    return inertia if inertia > criteria.TOLD * np.sqrt(variance) else None


Look = tuple[Revolutions, Complex, FloatArray, Sequence[Model], Sequence[Model]]


def _looks(seen: Periodicity) -> list[Look]:
    """Revolutions over the shaft and over the output, the shaking in them (revolutions, orders), how fast each order is
    in each (revolutions, orders) in Hz, the models that an order may have and those of them by which it is asked. An
    order that changes with the load, or as a drive's loop answers it, has what the inertia asks for in its numbers.
    """
    out: list[Look] = []
    taken: set[int] = set()
    if seen.shaft:
        shaft, revolutions = shaft_revolutions(seen)
        shaking = np.array([s.shaking for s in shaft])
        hertz = np.array([_hertz(s) for s in shaft])
        out.append((revolutions, shaking, hertz, SHAFT_MODELS[:3], PLAIN))
        taken = {round(n * seen.ratio) for n in range(shaking.shape[1])}
    output = [s for s in seen.output if s.shaking.size]
    if output:
        # what the shaft tells as well is not counted twice
        revolutions = output_revolutions(output, seen.folds)
        revolutions.vectors[:, [f for f in range(revolutions.vectors.shape[1]) if f in taken]] = np.nan
        shaking = np.array([s.shaking for s in output])
        hertz = np.array([_hertz(s) for s in output])
        out.append((revolutions, shaking, hertz, OUTPUT_MODELS, OUTPUT_MODELS))
    return out


def _beyond(revolutions: Revolutions, vectors: Complex, line: Line) -> Complex:
    """What an order's model leaves of its vectors in the training revolutions, over their noise."""
    seen = revolutions.train & np.isfinite(revolutions.vectors[:, line.order])
    scale = revolutions.sigma[seen]
    x = np.column_stack([revolutions.factors[t][seen] for t in line.model]) / scale[:, None]
    y = vectors[seen, line.order] / scale
    return np.asarray(y - x @ np.linalg.lstsq(x.astype(np.complex128), y, rcond=None)[0])
