"""What the motor's encoder misreads, told from what the gearbox does by the load's reaction in the motor's torque.

A multiple of the ratio in the transmission error is the motor encoder's, or the gearbox turns so once a revolution of
the motor. The gearbox's own order passes its share tau/u*dTE/dtheta of the load to the motor
(:mod:`bench.mismatch.orders.reaction`), an encoder's error passes none: it moves nothing. What the drive's loop makes
of the error goes with the speed and its square, not with the load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from bench.mismatch import criteria
from bench.mismatch.orders.revolutions import Complex, Revolution, Seen
from bench.mismatch.recordings.vibration import ShaftSpectrum
from bench.simulation.frame import FloatArray
from bench.simulation.waves import Wave

ENCODER, HARMONIC = "sensor.motor_encoder", "te.harmonic"
HALF = 0.5
"""of an order, which the first that is told must be the encoder's: the loop may answer an order by a part more or less
than it answers the others"""
ALIKE = 0.2
"""sine of the angle within which two vectors have one phase: a loop turns what it answers a little"""
NUISANCES = 3
"""parts of an order that go with the speed: level, slope, square"""


@dataclass(frozen=True, slots=True)
class Misread:
    """The encoder's part of an order: vector b + j*a in rad, standard deviation of either component, chance that an
    order of the gearbox alone looks so, gain of log-likelihood, whether the gearbox has the order ``beside`` it.

    ``followed``: whether the drive followed it. The drive holds what its encoder says, so it turns the shaft against
    the error, and the inertia asks for a torque that goes with the square of the speed whatever the load.
    """

    order: float
    vector: complex
    std: float
    p_value: float
    gain: float
    beside: bool
    followed: bool = False

    @property
    def wave(self) -> Wave:
        """It as a wave of a simulation file."""
        return Wave(self.order, "1", self.vector.imag, self.vector.real, self.std, self.std)

    @property
    def taken_off(self) -> Wave:
        """What is taken off the order as a whole to have the gearbox's part of it."""
        return Wave(self.order, "1", -self.vector.imag, -self.vector.real)


@dataclass(frozen=True, slots=True)
class TorqueCheck:
    """``orders`` whose origin the motor's torque decides, and the encoder's parts that were ``found``."""

    orders: tuple[float, ...] = ()
    found: tuple[Misread, ...] = ()

    def beside(self, order: float) -> complex:
        """The encoder's part of an order that is the gearbox's as well (rad), 0 where there is none."""
        return next((m.vector for m in self.found if m.order == order and m.beside), 0j)


def torque_check(
    seen: Seen,
    revolutions: Sequence[Revolution],
    recordings: frozenset[int],
    shaft: Sequence[ShaftSpectrum],
    ratio: float,
    share: tuple[float, float],
    orders: Sequence[float],
) -> TorqueCheck:
    """Ask the motor's torque in ``recordings`` (their indices) about ``orders``, multiples of the ``ratio``.

    ``share`` of the load's reaction that the other orders have in the motor torque, with its standard deviation.
    """
    shown = [_points(seen, revolutions, recordings, shaft, ratio, order) for order in orders]
    estimates = [_estimated(points, share) for points in shown if points is not None]
    rate = criteria.ERROR_RATE_OF_A_CHANNEL / max(len(estimates), 1)
    found = [m for m in estimates if m.p_value < rate and not _of_the_loop(seen, m)]
    mostly = any(abs(m.vector) > HALF * _size(seen, m.order) for m in found)
    return TorqueCheck(tuple(m.order for m in estimates), tuple(found) if mostly else ())


def _of_the_loop(seen: Seen, part: Misread) -> bool:
    """Whether an order of the gearbox alone looks so, of which the drive's loop answers less than of the slower ones: a
    part of the order in its own phase, clearly less than the whole, which the drive did not follow.
    """
    if part.followed:
        return False
    ratio = part.vector / complex(np.mean(seen.vectors[:, seen.orders.index(part.order)]))
    std = part.std * abs(ratio) / abs(part.vector)
    return abs(ratio.imag) < criteria.SURE * std + ALIKE * abs(ratio) and ratio.real < 1.0 - criteria.SURE * std


def _size(seen: Seen, order: float) -> float:
    """Root mean square of an order's amplitude over the revolutions."""
    return float(np.sqrt(np.mean(np.abs(seen.vectors[:, seen.orders.index(order)]) ** 2)))


@dataclass(frozen=True, slots=True)
class _Points:
    """An order in each recording (n,): vectors a + j*b of it in the motor's torque and of the whole reaction,
    what an error of one radian takes off that, relative speed, standard deviation of a component, vectors b + j*a in
    the transmission error.
    """

    order: float
    torque: Complex
    reaction: Complex
    unit: Complex
    speed: FloatArray
    sigma: FloatArray
    vectors: Complex


def _points(
    seen: Seen,
    revolutions: Sequence[Revolution],
    recordings: frozenset[int],
    shaft: Sequence[ShaftSpectrum],
    ratio: float,
    order: float,
) -> _Points | None:
    """None where too few recordings show the order in both."""
    times = round(order / ratio)
    column = seen.vectors[:, seen.orders.index(order)]
    recording = np.array([t.recording for t in revolutions])
    vectors_per_share = (
        np.array([t.torque for t in revolutions]) / ratio * -1j * order
    )  # derivative of a + j*b is -j*f*(a + j*b)
    rows = []
    for one in shaft:
        rows_of_recording = np.flatnonzero(recording == one.recording)
        if one.recording not in recordings or not rows_of_recording.size or times >= one.amplitude.size:
            continue
        at = one.in_band[times]
        if np.isfinite(at):
            whole = np.mean(vectors_per_share[rows_of_recording] * 1j * np.conj(column[rows_of_recording]))
            rows.append(
                (
                    at,
                    whole,
                    np.mean(vectors_per_share[rows_of_recording]),
                    one.velocity,
                    one.sigma,
                    np.mean(column[rows_of_recording]),
                )
            )
    if len(rows) < criteria.FEWEST_RECORDINGS + 1 + NUISANCES:
        return None
    torque, reaction, unit, velocity, sigma, vectors = (np.array(c) for c in zip(*rows, strict=True))
    return _Points(order, torque, reaction, unit, velocity.real / np.abs(velocity).max(), sigma.real, vectors)


def _estimated(points: _Points, share: tuple[float, float]) -> Misread:
    """The encoder's part by least squares, its scatter by leaving out one recording after another."""
    of_speed = [np.ones(points.speed.size), points.speed, points.speed**2]
    design = np.column_stack([-share[0] * points.unit, *of_speed]) / points.sigma[:, None]
    left = (points.torque - share[0] * points.reaction) / points.sigma
    size = left.size
    without, _, _, _ = np.linalg.lstsq(design[:, 1:], left, rcond=None)
    whole, _, _, _ = np.linalg.lstsq(design, left, rcond=None)
    others = [np.arange(size) != k for k in range(size)]
    without_one = np.array([np.linalg.lstsq(design[kept], left[kept], rcond=None)[0] for kept in others])
    scatter = np.sum(np.abs(without_one - without_one.mean(axis=0)) ** 2, axis=0) * (size - 1) / size / 2.0
    variance = float(scatter[0])
    variance += (share[1] / share[0]) ** 2 * float(np.mean(np.abs(points.vectors) ** 2)) / 2.0
    vector = complex(1j * np.conj(whole[0]))
    freedom = 2 * (size - 1 - NUISANCES)
    p_value = float(stats.f.sf(abs(vector) ** 2 / (2.0 * variance), 2, freedom))
    before, after = (float(np.sum(np.abs(left - design[:, k:] @ c) ** 2)) for k, c in ((1, without), (0, whole)))
    rest = float(np.mean(np.abs(points.vectors - vector) ** 2))
    beside = rest > criteria.SURE**2 * 2.0 * variance
    by_inertia = complex(whole[-1] / whole[0])
    sure = bool(abs(whole[-1]) ** 2 > criteria.SURE**2 * 2.0 * float(scatter[-1]))
    followed = sure and by_inertia.real < 0.0 and abs(by_inertia.imag) < ALIKE * abs(by_inertia)
    gain = size * float(np.log(before / after))
    return Misread(points.order, vector, float(np.sqrt(variance)), p_value, gain, beside, followed)
