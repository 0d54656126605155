"""The load's reaction through the transmission error, in the motor's torque.

A gearbox whose output is off by TE(theta) passes the load tau to its input as tau*(1 + dTE/dtheta)/u (virtual work).
The first part is a term of the simulation, the second holds every order of the transmission error in proportion to the
load and to the order. It is no effect of its own but follows from the series. How much of it the drive reports is asked
of the recordings, for a drive's speed loop answers slow orders whole and quick ones in part.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bench.mismatch import criteria
from bench.mismatch.orders.periodic import Periodic
from bench.mismatch.recordings.notch import spectrum
from bench.mismatch.recordings.output_orders import OutputSpectrum, orders_of
from bench.mismatch.recordings.rows import settled_rows
from bench.mismatch.recordings.vibration import ShaftSpectrum
from bench.simulation.frame import FloatArray, Frame, IntArray

BLOCK_S = 1.0
"""in which the motor torque has a free level: what is slower is friction's"""
SURROGATES = 9999


@dataclass(frozen=True, slots=True)
class Reaction:
    """``share`` of tau/u*dTE/dtheta that the motor torque holds, its standard deviation (None: not estimated here);
    what is ``periodic`` of the transmission error; and what it comes to on the rows of that channel's ``frame``.
    """

    share: float
    std: float | None
    periodic: Periodic
    frame: Frame
    values: FloatArray

    @property
    def words(self) -> str:
        """What a report says of it."""
        std = "" if self.std is None else f" ± {self.std:.2g}"
        return (
            f"the motor torque holds {self.share:.3g}{std} of the load's reaction through the transmission error, "
            "tau/u*dTE/dtheta; its orders in proportion to the load are part of that and no effect of their own"
        )

    def on_rows(self, frame: Frame) -> FloatArray:
        """Its mean over each row of a frame (n,), N·m."""
        return self.share * unit(self.periodic, frame)

    def less_output(self, seen: OutputSpectrum) -> OutputSpectrum:
        """A spectrum of the motor torque over the output angle without it."""
        rows = self._rows(seen.recording, seen.time)
        if rows is None:
            return seen
        return replace(seen, amplitude=seen.amplitude - orders_of(self.frame.q[rows], self.values[rows]))

    def less_shaft(self, seen: ShaftSpectrum) -> ShaftSpectrum:
        """A spectrum of the motor torque over the motor's angle without it."""
        rows = self._rows(seen.recording)
        if rows is None:
            return seen
        angle = self.frame.theta[rows] * self.frame.ratio
        count = self.frame.count[rows]
        of_series = 2.0 / float(count.sum()) * spectrum(angle, self.values[rows] * count, seen.amplitude.size - 1)
        return replace(seen, amplitude=seen.amplitude - of_series)

    def _rows(self, recording: int, time: float | None = None) -> IntArray | None:
        """Steady rows of a recording, of the segment about a ``time`` alone where one is given; None where none is."""
        steady = (self.frame.steady > 0.5) & (self.frame.direction != 0)
        found = np.flatnonzero(steady & (self.frame.recording == recording))
        if found.size and time is not None:
            parts = np.split(found, np.flatnonzero(np.diff(found) > 1) + 1)
            found = min(parts, key=lambda rows: abs(float(np.mean(self.frame.time[rows])) - time))
        return found if found.size else None


def unit(periodic: Periodic, frame: Frame) -> FloatArray:
    """The whole reaction through what is periodic, mean over each row of a frame (n,), N·m at the motor."""
    return np.asarray(frame.torque / frame.ratio * periodic.slope_of_rows(frame))


def reaction_of(
    periodic: Periodic, frame: Frame, usable: NDArray[np.bool_], train: NDArray[np.bool_], known: float, seed: int
) -> Reaction | None:
    """The reaction that the motor torque of the transmission error's rows holds; None where it holds none.

    ``frame`` of these rows, which of them are ``usable``; ``train`` (recordings,) who may be fitted; ``known``: the
    share that the given simulation says, which stands where these recordings do not tell it.
    """
    whole = unit(periodic, frame)
    found = estimated(whole, frame, usable & train[frame.recording] & settled_rows(frame), seed)
    if found is not None:
        share, std = found
        return Reaction(share, std, periodic, frame, share * whole)
    return Reaction(known, None, periodic, frame, known * whole) if known else None


def estimated(whole: FloatArray, frame: Frame, chosen: NDArray[np.bool_], seed: int) -> tuple[float, float] | None:
    """Share of the ``whole`` reaction (n,) in the motor torque of the rows ``chosen`` and its standard deviation; None
    where the signs of whole recordings, drawn at random, say as much.
    """
    rows = np.flatnonzero(chosen)
    if not rows.size:
        return None
    recording = frame.recording[rows]
    block_number = np.floor(frame.elapsed[rows] / BLOCK_S).astype(np.int64)
    block = np.unique(recording * (int(block_number.max()) + 1) + block_number, return_inverse=True)[1]
    count = frame.count[rows]
    x = _within(whole[rows], block, count)
    y = _within(frame.motor_torque[rows] - frame.torque[rows] / frame.ratio, block, count)
    number = np.unique(recording, return_inverse=True)[1]
    products, squares = np.bincount(number, count * x * y), np.bincount(number, count * x * x)
    total = float(squares.sum())
    if total <= 0.0 or products.size < criteria.FEWEST_RECORDINGS:
        return None
    signs = np.random.default_rng([seed, 11]).choice([-1.0, 1.0], size=(SURROGATES, products.size))
    p_value = (1.0 + np.count_nonzero(signs @ products >= products.sum())) / (1.0 + SURROGATES)
    if p_value > criteria.ERROR_RATE_OF_A_CHANNEL:
        return None
    share = float(products.sum()) / total
    spread = float(np.sum((products - share * squares) ** 2)) * products.size / (products.size - 1)
    return share, float(np.sqrt(spread)) / total


def _within(values: FloatArray, block: IntArray, count: FloatArray) -> FloatArray:
    """Values less the mean of their block."""
    mean = np.bincount(block, count * values) / np.bincount(block, count)
    return np.asarray(values - mean[block])
