"""The refined identification: joint least squares on the samples of all recordings of one direction.

Inside a recording the samples enter by their normal equations (sums over angle, block by block); for given A_k, φ_k, a₀
as functions of the inputs these sums hold all that the samples say. So the fit goes in two levels that repeat until
they agree: harmonics of each recording at its mean inputs, all orders and the ripple's jointly, with what the inputs'
changes within the recording contribute taken off; then polynomials through the harmonics of all recordings,
weighted by the noise seen beside each order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.reduction import Reduction
from bench.identification.samples.steady import SteadySums
from bench.identification.samples.sums import Shifts, gram, projections
from bench.identification.series.inputs import Design, make_design, undetermined
from bench.identification.series.points import counting_covariance, points_covariance
from bench.identification.series.polish import PolarFit, Spread, fit_linear, fit_polar
from bench.simulation import TERM_COUNT, FourierSet, basis

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

PASSES = 4
"""Most rounds in which harmonics and polynomials correct each other."""
SETTLED = 0.01
"""Change of a vector, in standard deviations, at which they agree."""
NEIGHBOURS = 10
"""Orders on each side whose residual is taken as the noise at an order."""


@dataclass(slots=True)
class _Normal:
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
class _Places:
    """Orders of a fit, the first ``asked`` of them the model's, and where their sums stand."""

    orders: FloatArray
    asked: int
    model: Shifts
    every: Shifts

    @classmethod
    def of(cls, steady: SteadySums, orders: FloatArray, asked: int) -> _Places:
        frequencies = np.concatenate([np.arange(steady.highest_order + 1.0), steady.fractions])
        whole = steady.unit.shape[-1] - steady.unit_extra.size
        model, every = (Shifts.of(frequencies, own, whole, steady.unit_extra) for own in (orders[:asked], orders))
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


@dataclass(frozen=True, slots=True)
class RefinedDirection:
    """Result of one direction: coefficients, the harmonics they rest on, what could not be determined.

    ``spreads`` has amplitude's and phase's of each order, and a₀'s last (twice). ``freedom`` counts the recordings
    beyond those that the polynomials take: the standard deviations rest on so many.
    """

    fourier: FourierSet
    harmonics: tuple[RecordingHarmonics, ...]
    design: Design
    spreads: tuple[tuple[Spread, Spread], ...]
    sentences: tuple[str, ...]
    freedom: int


def _normal(steady: SteadySums, orders: FloatArray) -> _Normal:
    samples = steady.unit[:, 0].real
    inputs = np.stack([steady.torque, steady.velocity, steady.temperature], axis=1)
    inputs = np.where(np.isfinite(inputs), inputs, 0.0)
    unit = steady.unit.sum(axis=0)
    return _Normal(
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


def _moved(normal: _Normal, fourier: FourierSet | None, places: _Places) -> ComplexArray:
    """Sums of the error less what the model says of the changes of the inputs within the recording."""
    if fourier is None:
        return normal.error
    deviation = _local(fourier, normal.inputs) - _local(fourier, normal.mean[None, :])
    moved = places.model.series(normal.sums.unit, deviation)
    return np.asarray(normal.error - moved - _torque_slope(fourier, normal.inputs) @ normal.sums.torque_change)


def _beside(power: FloatArray, order: int) -> FloatArray:
    """Powers of the orders beside one that are not fitted (NaN marks the fitted); further off where few are."""
    for width in (NEIGHBOURS, 2 * NEIGHBOURS, 4 * NEIGHBOURS, power.size):
        near = power[max(order - width, 1) : order + width + 1]
        near = near[np.isfinite(near)]
        if near.size >= NEIGHBOURS // 2:
            break
    return near


def _noise(normal: _Normal, error: ComplexArray, places: _Places) -> FloatArray:
    """Residual power |Σ r·exp(imθ)|²/N beside each order (K,) and, last, at order 0; the median of its neighbours."""
    orders = places.orders
    rest = (error - places.every.series(normal.unit[None, :], normal.solution[None, :]))[
        : normal.sums.highest_order + 1
    ]
    power = np.abs(rest) ** 2 / normal.unit[0].real
    # a fraction differs little from the whole order next to it: neither says what the noise is
    power[np.rint(orders).astype(np.int64)] = np.nan
    power[0] = np.nan
    out = np.empty(places.asked + 1)
    for k, order in enumerate([*orders[: places.asked], 0]):
        near = _beside(power, round(order))
        # The power of noise at an order is exponentially distributed: its mean is its median / ln 2.
        out[k] = float(np.median(near)) / np.log(2.0)
    return out


def _harmonics(normal: _Normal, name: str, places: _Places) -> RecordingHarmonics:
    size, asked = places.orders.size, places.asked
    own = np.diag(normal.inverse)
    spread = 0.5 * (own[:size] + own[size : 2 * size])
    z = normal.solution[:size] + 1j * normal.solution[size : 2 * size]
    # One count of the encoder is where its zero lies: nothing in the recording says more about a₀'s constant.
    return RecordingHarmonics(
        name,
        z[:asked],
        spread[:asked] * normal.spread[:-1],
        float(normal.solution[-1]) + normal.sums.reference,
        float(own[-1] * normal.spread[-1]),
        normal.mean,
        z[asked:],
        normal.sums.counting_bias,
    )


def _polynomials(
    harmonics: Sequence[RecordingHarmonics],
    design: Design,
    orders: NDArray[np.float64],
    counts: tuple[float, float],
    fits: dict[int, PolarFit],
    points: bool = False,
) -> tuple[FourierSet, tuple[tuple[Spread, Spread], ...]]:
    """Fit all orders and a₀; with ``points`` the covariances have what recordings of a point share.

    ``counts`` are one count of the motor's encoder at the load side and one of the load's, rad; 0 where not quantised.
    """
    embed = design.raw_matrix()
    size = orders.size
    # Half a count: whether an encoder rounds or reads the count it stands in is not known. It moves every angle by the
    # same amount, so it is in a₀'s constant and, times the order, in each phase's. The load's is in a₀'s constant only.
    zero_angle, zero_load = (0.5 * count for count in counts)
    amplitude, phase = np.zeros((size, TERM_COUNT)), np.zeros((size, TERM_COUNT))
    covariance = np.zeros((size, 2 * TERM_COUNT, 2 * TERM_COUNT))
    both = np.zeros((2 * embed.shape[0], 2 * TERM_COUNT))
    both[: embed.shape[0], :TERM_COUNT] = embed
    both[embed.shape[0] :, TERM_COUNT:] = embed
    spreads: list[tuple[Spread, Spread]] = []
    z = np.stack([h.z for h in harmonics])
    variance = np.stack([h.variance for h in harmonics])
    for k in range(size):
        fit = fits[k] = fit_polar(z[:, k], variance[:, k], design, fits.get(k), points)
        amplitude[k], phase[k] = fit.amplitude @ embed, fit.phase @ embed
        covariance[k] = both.T @ fit.covariance @ both
        covariance[k, -1, -1] += (orders[k] * zero_angle) ** 2
        spreads.append((fit.along, fit.across))
    offsets = np.asarray([h.offset for h in harmonics])
    offset_variance = np.asarray([h.offset_variance for h in harmonics])
    coefficients, offset_covariance, spread = fit_linear(design.regressors, offsets, offset_variance)
    spreads.append((spread, spread))
    if points:
        weighted = spread.variance(offset_variance)
        effect = offset_covariance @ (design.regressors.T / weighted)
        counting = counting_covariance(design, np.asarray([h.counting_bias for h in harmonics]), effect)
        residual = offsets - design.regressors @ coefficients
        offset_covariance = (
            offset_covariance + counting + points_covariance(design, offset_covariance, residual, weighted)
        )
    raw_covariance = embed.T @ offset_covariance @ embed
    raw_covariance[-1, -1] += zero_angle**2 + zero_load**2
    std = np.sqrt(np.einsum("kii->ki", covariance))
    fourier = FourierSet(
        orders,
        amplitude,
        phase,
        coefficients @ embed,
        amplitude_std=std[:, :TERM_COUNT],
        phase_std=std[:, TERM_COUNT:],
        offset_std=np.sqrt(np.diag(raw_covariance)),
        covariance=covariance,
        offset_covariance=raw_covariance,
    )
    return fourier, tuple(spreads)


def identify_direction(
    reductions: Sequence[Reduction],
    orders: Sequence[float],
    notch_orders: Sequence[int],
    direction: str,
    nuisance: Sequence[int] = (),
) -> RefinedDirection | None:
    """Identify one direction of motion from recordings that moved that way; None without any.

    ``nuisance`` orders are there, too: they are fitted to each recording and not reported, so that they neither bias
    the others nor count as their noise.
    """
    members = [(r.recording_id, r.steady) for r in reductions if r.steady is not None]
    if not members:
        return None
    beside = [n for n in dict.fromkeys([*notch_orders, *nuisance]) if n not in orders]
    listed = np.asarray([*orders, *beside], dtype=np.float64)
    places = _Places.of(members[0][1], listed, len(orders))
    normals = [_normal(steady, listed) for _, steady in members]
    design = make_design(np.stack([n.mean for n in normals]))
    known = [r.load_count for r in reductions if r.steady is not None and np.isfinite(r.load_count)]
    counts = max(steady.resolution for _, steady in members), max(known, default=0.0)
    fourier: FourierSet | None = None
    harmonics: list[RecordingHarmonics] = []
    spreads: tuple[tuple[Spread, Spread], ...] = ()
    fits: dict[int, PolarFit] = {}
    for _ in range(PASSES):
        before = [h.z for h in harmonics]
        for normal in normals:
            error = _moved(normal, fourier, places)
            normal.solution = normal.inverse @ projections(error, listed, normal.sums.fractions)
            normal.spread = _noise(normal, error, places)
        harmonics = [_harmonics(normal, name, places) for normal, (name, _) in zip(normals, members, strict=True)]
        if before and _settled(before, harmonics):
            break
        fourier, spreads = _polynomials(harmonics, design, np.asarray(orders, dtype=np.float64), counts, fits)
    fourier, spreads = _polynomials(harmonics, design, np.asarray(orders, dtype=np.float64), counts, fits, True)
    return RefinedDirection(
        fourier,
        tuple(harmonics),
        design,
        spreads,
        tuple(undetermined(design, direction)),
        max(len(members) - int(design.kept.size), 1),
    )


def _settled(before: Sequence[ComplexArray], after: Sequence[RecordingHarmonics]) -> bool:
    """Whether no vector has moved by more than a hundredth of its standard deviation."""
    return all(
        bool(np.all(np.abs(h.z - z) <= SETTLED * np.sqrt(h.variance))) for z, h in zip(before, after, strict=True)
    )


def single_recording(
    steady: SteadySums, orders: Sequence[float], notch_orders: Sequence[int]
) -> tuple[ComplexArray, ComplexArray]:
    """Fourier series fitted to one recording alone: z (K,) of the orders and of the ripple; the bound of any model."""
    listed = np.asarray([*orders, *(n for n in notch_orders if n not in orders)], dtype=np.float64)
    normal = _normal(steady, listed)
    solution = normal.inverse @ projections(normal.error, listed, steady.fractions)
    z = solution[: listed.size] + 1j * solution[listed.size : 2 * listed.size]
    return z[: len(orders)], z[len(orders) :]
