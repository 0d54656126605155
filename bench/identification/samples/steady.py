"""The steady window of one recording, reduced to sums over angle in a few blocks of time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.identification.samples.fractions import extra_frequencies, fractions, sums_at
from bench.identification.samples.sums import angle_sums
from bench.identification.samples.windows import SteadyWindow, counting_bias

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

TURN = 2.0 * np.pi
ANGLE_STEPS = 2.0**32
"""Angles of kept samples are stored as this many steps per revolution (1.5 nrad)."""
KEPT = 1 << 15
"""Samples of a window that are kept for scores and figures, at least: every n-th of those there are.

Half as many per revolution as the highest order of the spectrum needs still have the mean square of what is periodic
exactly, so a score changes by its noise's share over √(2·KEPT) only (docs/identification.md has the figures).
"""


@dataclass(frozen=True, slots=True)
class ReductionOptions:
    """What to reduce to: ``orders``, whole ``notch_orders``, blocks a window, highest_order of the proposal spectrum.

    ``torque_step`` is the drive's own step of the motor torque in codes (:mod:`.rounding`), None where none is known.
    """

    orders: tuple[float, ...]
    notch_orders: tuple[int, ...] = (150, 300)
    blocks: int = 16
    spectrum_order: int = 5000
    band_limit_hz: float | None = None
    kinds: tuple[str, ...] = ("constant_velocity", "validation", "free")
    torque_step: float | None = None

    @property
    def highest_order(self) -> int:
        """Highest order of the sums; somewhat above the highest order fitted, so that its noise can be seen."""
        return int(np.ceil(max([*self.orders, *self.notch_orders, 1]))) + 12

    @property
    def block_count(self) -> int:
        """Fewer blocks where orders are high, so that memory stays bounded."""
        return int(np.clip(self.blocks * 320 // self.highest_order, 1, self.blocks))


@dataclass(frozen=True, slots=True)
class SteadySums:
    """The steady window of one recording in B blocks, M = ``highest_order``; rad. ``reference`` is taken off the error.

    Attributes
    ----------
    torque, velocity, temperature : (B,) means of the block (N·m, rad/s at the load side, °C).
    unit : (B, 2M + 1) sums of 1; ``error`` : (B, M + 1) of the transmission error; ``torque_change`` : (B, M + 1) of
        the load torque less its block mean. Behind them stand the sums at ``unit_extra`` and ``fractions``.
    error_square : Σ of the squared error over the window.
    spectrum : (S + 1,) power |Σ TE·exp(imθ)|²·(2/N)² of the window, orders 0 … S: squared amplitudes.
    angle, sample : (N,) samples kept for residuals (:data:`KEPT`): angle in 2⁻³² revolutions, error less ``reference``
        (float32).
    resolution : rad, one count of the motor encoder at the load side (0 where not quantised).
    counting_bias : rad, standard deviation of the mean error that counting leaves at this speed.
    fractions, unit_extra : (F,), (E,) frequencies that are no whole number; ``first_revolution`` : whole revolutions of
        the first kept sample, from which such orders go on.
    """

    window: SteadyWindow
    reference: float
    torque: FloatArray
    velocity: FloatArray
    temperature: FloatArray
    unit: ComplexArray
    error: ComplexArray
    torque_change: ComplexArray
    error_square: float
    spectrum: NDArray[np.float32]
    angle: NDArray[np.uint32]
    sample: NDArray[np.float32]
    resolution: float
    counting_bias: float
    fractions: FloatArray
    unit_extra: FloatArray
    first_revolution: float

    @property
    def highest_order(self) -> int:
        """Highest whole order M of the sums."""
        return int(self.error.shape[1]) - 1 - int(self.fractions.size)

    def turned(self) -> FloatArray:
        """Angles (N,) of the kept samples in rad, with their whole revolutions."""
        return np.asarray(np.unwrap(self.angle / ANGLE_STEPS * TURN) + self.first_revolution * TURN)


def _block_slices(start: int, stop: int, count: int) -> Iterable[slice]:
    edges = np.linspace(start, stop, count + 1).astype(np.int64)
    return (slice(int(edges[i]), int(edges[i + 1])) for i in range(count))


@njit(cache=True)
def _fixed_point(theta: FloatArray) -> NDArray[np.uint32]:
    """Angles (N,) in rad as 2⁻³² revolutions, whole revolutions dropped."""
    out = np.empty(theta.size, dtype=np.uint32)
    for n in range(theta.size):
        revolutions = theta[n] * (1.0 / TURN)
        out[n] = np.uint32((revolutions - np.floor(revolutions)) * ANGLE_STEPS)
    return out


def steady_sums(
    channels: dict[str, FloatArray], theta: FloatArray, error: FloatArray, bad: NDArray[np.bool_],
    window: SteadyWindow, options: ReductionOptions, resolution: float,
) -> SteadySums:  # fmt: skip
    """Reduce the window of one recording.

    Parameters
    ----------
    channels : (N,) each in SI units; ``time`` at least, ``load_torque`` and ``temperature`` where measured.
    theta, error : (N,) input angle in load-side scaling and transmission error, rad.
    bad : (N,) rows that are left out.
    resolution : one count of the motor encoder at the load side, rad; 0 where not quantised.
    """
    part = slice(window.start, window.stop)
    # Without a bad sample every part is a plain slice, which costs no copy.
    keep = ~bad if bad[part].any() else None

    def chosen(values: FloatArray, rows: slice) -> FloatArray:
        return values[rows] if keep is None else values[rows][keep[rows]]

    reference = float(chosen(error, part).mean())
    highest_order, count = options.highest_order, options.block_count
    means = np.full((3, count), np.nan)
    broken = fractions(options.orders)
    extra = extra_frequencies(broken, highest_order)
    unit = np.empty((count, 2 * highest_order + 1 + extra.size), dtype=np.complex128)
    first = np.empty((count, highest_order + 1 + broken.size), dtype=np.complex128)
    second = np.zeros((count, highest_order + 1 + broken.size), dtype=np.complex128)
    for b, rows in enumerate(_block_slices(window.start, window.stop, count)):
        angle, time = chosen(theta, rows), chosen(channels["time"], rows)
        centred = time - time.mean()
        means[1, b] = float(centred @ angle / (centred @ centred))
        off = chosen(error, rows) - reference
        unit[b, : 2 * highest_order + 1], both = angle_sums(angle, np.ones_like(angle), off, 2 * highest_order)
        unit[b, 2 * highest_order + 1 :] = sums_at(angle, np.ones_like(angle), extra)
        first[b] = np.concatenate([both[: highest_order + 1], sums_at(angle, off, broken)])
        if "load_torque" in channels:
            load = chosen(channels["load_torque"], rows)
            means[0, b] = load.mean()
            load = load - means[0, b]
            second[b, : highest_order + 1] = angle_sums(angle, load, np.zeros_like(load), highest_order)[0]
            second[b, highest_order + 1 :] = sums_at(angle, load, broken)
        if "temperature" in channels:
            means[2, b] = chosen(channels["temperature"], rows).mean()
    kept_theta, kept = chosen(theta, part), chosen(error, part) - reference
    limit = min(options.spectrum_order, max(kept.size // (3 * window.revolutions), 1))
    whole = angle_sums(kept_theta, kept, np.zeros_like(kept), limit)[0]
    some = slice(None, None, max(1, kept.size // KEPT))
    advance = abs(kept_theta[-1] - kept_theta[0]) / (resolution * (part.stop - part.start - 1)) if resolution else 0.0
    bias = counting_bias(advance, part.stop - part.start) if resolution else 0.0
    return SteadySums(
        window, reference, means[0], means[1], means[2], unit, first, second, float(kept @ kept),
        (np.abs(whole) ** 2 * (2.0 / kept.size) ** 2).astype(np.float32),
        _fixed_point(kept_theta[some]),
        kept[some].astype(np.float32),
        resolution, resolution * bias, broken, extra, float(np.floor(kept_theta[0] / TURN)),
    )  # fmt: skip
