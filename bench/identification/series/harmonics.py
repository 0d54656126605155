"""Harmonic orders of one recording: complex amplitudes with their variances, by its normal equations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.steady import SteadySums
from bench.identification.samples.sums import Shifts, gram, projections
from bench.simulation import FourierSet, basis

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
NEIGHBOURS = 10
"""Orders on each side whose residual is taken as the noise at an order."""


@dataclass(slots=True)
class Normal:
    """Normal equations of one recording, regressors [sin f…, cos f…, 1] with the ripple's orders last.

    ``unit`` and ``error`` are sums over all blocks, ``inputs`` (B, 3) those of each block and ``mean`` (3,) theirs.
    """

    sums: SteadySums
    unit: ComplexArray
    error: ComplexArray
    inverse: FloatArray
    inputs: FloatArray
    mean: FloatArray
    solution: FloatArray = field(default_factory=lambda: np.empty(0))
    spread: FloatArray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, slots=True)
class Places:
    """Orders of a fit, the first ``asked`` of them the model's, and where their sums stand."""

    orders: FloatArray
    asked: int
    model: Shifts
    every: Shifts

    @classmethod
    def of(cls, steady: SteadySums, orders: FloatArray, asked: int) -> Places:
        """Where the sums of ``orders`` stand in those of a recording; all recordings of a fit have the same layout."""
        frequencies = np.concatenate([np.arange(steady.highest_order + 1.0), steady.fractions])
        whole = steady.unit.shape[-1] - steady.unit_extra.size
        model, every = (Shifts.of(frequencies, some, whole, steady.unit_extra) for some in (orders[:asked], orders))
        return cls(orders, asked, model, every)


@dataclass(frozen=True, slots=True)
class RecordingHarmonics:
    """Of one recording: z = A·exp(iφ) (K,), its variance a component, offset and its variance, mean inputs (3,)."""

    recording_id: str
    z: ComplexArray
    variance: FloatArray
    offset: float
    offset_variance: float
    inputs: FloatArray
    ripple: ComplexArray
    counting_bias: float


def normal_of(steady: SteadySums, orders: FloatArray) -> Normal:
    """Return the normal equations of the orders and an offset in one recording's sums."""
    samples = steady.unit[:, 0].real
    inputs = np.stack([steady.torque, steady.velocity, steady.temperature], axis=1)
    inputs = np.where(np.isfinite(inputs), inputs, 0.0)
    unit = steady.unit.sum(axis=0)
    return Normal(
        steady,
        unit,
        steady.error.sum(axis=0),
        np.asarray(np.linalg.inv(gram(unit, orders, steady.unit_extra)), dtype=np.float64),
        inputs,
        samples @ inputs / samples.sum(),
    )


def _local(fourier: FourierSet, inputs: FloatArray) -> FloatArray:
    """Coefficients of the regressors (..., 2K + 1) the model has at inputs (..., 3)."""
    rows = basis(inputs[..., 0], inputs[..., 1], inputs[..., 2])
    amplitude, phase = rows @ fourier.amplitude.T, rows @ fourier.phase.T
    offset = (rows @ fourier.offset)[..., None]
    return np.concatenate([amplitude * np.cos(phase), amplitude * np.sin(phase), offset], axis=-1)


def _torque_slope(fourier: FourierSet, inputs: FloatArray) -> FloatArray:
    """∂a₀/∂τ at inputs (..., 3)."""
    p, (tau, rate, temp) = fourier.offset, np.moveaxis(inputs, -1, 0)
    return np.asarray(2.0 * p[0] * tau + p[3] + p[6] * rate + p[7] * temp)


def without_input_changes(normal: Normal, fourier: FourierSet | None, listed: Places) -> ComplexArray:
    """Sums of the error less what the model says of the changes of the inputs within the recording."""
    if fourier is None:
        return normal.error
    deviation = _local(fourier, normal.inputs) - _local(fourier, normal.mean[None, :])
    change = listed.model.series(normal.sums.unit, deviation)
    return np.asarray(normal.error - change - _torque_slope(fourier, normal.inputs) @ normal.sums.torque_change)


def _unfitted_neighbours(power: FloatArray, order: int) -> FloatArray:
    """Powers of the orders beside one that are not fitted (NaN marks the fitted); further off where few are."""
    for width in (NEIGHBOURS, 2 * NEIGHBOURS, 4 * NEIGHBOURS, power.size):
        near = power[max(order - width, 1) : order + width + 1]
        near = near[np.isfinite(near)]
        if near.size >= NEIGHBOURS // 2:
            break
    return near


def noise_beside(normal: Normal, error: ComplexArray, listed: Places) -> FloatArray:
    """Residual power |Σ r·exp(imθ)|²/N beside each order (K,) and, last, at order 0; the median of its neighbours."""
    orders = listed.orders
    rest = (error - listed.every.series(normal.unit[None, :], normal.solution[None, :]))[
        : normal.sums.highest_order + 1
    ]
    power = np.abs(rest) ** 2 / normal.unit[0].real
    # a fraction differs little from the whole order next to it: neither says what the noise is
    power[np.rint(orders).astype(np.int64)] = np.nan
    power[0] = np.nan
    out = np.empty(listed.asked + 1)
    for k, order in enumerate([*orders[: listed.asked], 0]):
        near = _unfitted_neighbours(power, round(order))
        # The power of noise at an order is exponentially distributed: its mean is its median / ln 2.
        out[k] = float(np.median(near)) / np.log(2.0)
    return out


def harmonics_of(normal: Normal, name: str, listed: Places) -> RecordingHarmonics:
    """Return the vectors of a solved recording; their variances from the noise beside each order."""
    size, asked = listed.orders.size, listed.asked
    diagonal = np.diag(normal.inverse)
    spread = 0.5 * (diagonal[:size] + diagonal[size : 2 * size])
    z = normal.solution[:size] + 1j * normal.solution[size : 2 * size]
    # One count of the encoder is where its zero lies: nothing in the recording says more about a₀'s constant.
    return RecordingHarmonics(
        name,
        z[:asked],
        spread[:asked] * normal.spread[:-1],
        float(normal.solution[-1]) + normal.sums.reference,
        float(diagonal[-1] * normal.spread[-1]),
        normal.mean,
        z[asked:],
        normal.sums.counting_bias,
    )


def single_recording(
    steady: SteadySums, orders: Sequence[float], notch_orders: Sequence[int]
) -> tuple[ComplexArray, ComplexArray]:
    """Fourier series fitted to one recording alone: z (K,) of the orders and of the ripple; the bound of any model."""
    listed = np.asarray([*orders, *(n for n in notch_orders if n not in orders)], dtype=np.float64)
    normal = normal_of(steady, listed)
    solution = normal.inverse @ projections(normal.error, listed, steady.fractions)
    z = solution[: listed.size] + 1j * solution[listed.size : 2 * listed.size]
    return z[: len(orders)], z[len(orders) :]
