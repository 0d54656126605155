"""The refined identification: joint least squares on the samples of all recordings of one direction.

Inside a recording the samples enter by their normal equations (sums over angle, block by block); for given A_k, φ_k, a₀
as functions of the inputs these sums hold all that the samples say. So the fit goes in two levels that repeat until
they agree: harmonics of each recording at its mean inputs, all orders and the ripple's jointly, with what the inputs'
changes within the recording contribute taken off; then polynomials through the harmonics of all recordings,
weighted by the noise seen beside each order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.identification.samples.reduction import Reduction
from bench.identification.samples.sums import projections
from bench.identification.series.harmonics import (
    ComplexArray,
    Places,
    RecordingHarmonics,
    harmonics_of,
    noise_beside,
    normal_of,
    without_input_changes,
)
from bench.identification.series.inputs import Design, make_design, undetermined
from bench.identification.series.points import counting_covariance, points_covariance
from bench.identification.series.polish import PolarFit, Spread, fit_linear, fit_polar
from bench.simulation import TERM_COUNT, FourierSet

FloatArray = NDArray[np.float64]

PASSES = 4
"""Most rounds in which harmonics and polynomials correct each other."""
SETTLED = 0.01
"""Change of a vector, in standard deviations, at which they agree."""


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
    places = Places.of(members[0][1], listed, len(orders))
    normals = [normal_of(steady, listed) for _, steady in members]
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
            error = without_input_changes(normal, fourier, places)
            normal.solution = normal.inverse @ projections(error, listed, normal.sums.fractions)
            normal.spread = noise_beside(normal, error, places)
        harmonics = [harmonics_of(normal, name, places) for normal, (name, _) in zip(normals, members, strict=True)]
        if before and _has_converged(before, harmonics):
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


def _has_converged(before: Sequence[ComplexArray], after: Sequence[RecordingHarmonics]) -> bool:
    """Whether no vector has moved by more than a hundredth of its standard deviation."""
    return all(
        bool(np.all(np.abs(h.z - z) <= SETTLED * np.sqrt(h.variance))) for z, h in zip(before, after, strict=True)
    )
