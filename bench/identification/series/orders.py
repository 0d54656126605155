"""Harmonic orders: proposals from the spectra."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from bench.identification.samples.fractions import fractions
from bench.identification.samples.reduction import Reduction
from bench.simulation import Gearbox
from bench.simulation.parts import part_of

FloatArray = NDArray[np.float64]

NEIGHBOURHOOD = 61
"""Orders over which the noise beside a peak is taken."""
PEAK_RATIO = 12.0
"""A peak stands out of one recording's noise at this power ratio: by chance in 6 of a million orders."""
MIN_SHARE = 0.3
"""Share of the recordings in which a proposed order must stand out."""
MIN_AMPLITUDE_SHARE = 0.003
"""…and it must have this share of the strongest order's amplitude: less is of no use to any model."""


@dataclass(frozen=True, slots=True)
class Proposal:
    """An order seen in the spectra: median amplitude rad, share of recordings where it stands out, its part."""

    order: int
    amplitude: float
    share: float
    part: str
    used: bool


def peak_ratio(power: NDArray[np.float32]) -> FloatArray:
    """Power of each order over that of the noise beside it (the median of the neighbourhood / ln 2); 0 at order 0."""
    values = power.astype(np.float64)
    noise = median_filter(values, min(NEIGHBOURHOOD, values.size), mode="nearest") / np.log(2.0)
    ratio = values / np.maximum(noise, 1e-300)
    ratio[0] = 0.0
    return np.asarray(ratio)


def propose(
    reductions: Sequence[Reduction], gearbox: Gearbox, used: Sequence[float], notch_orders: Sequence[int]
) -> tuple[Proposal, ...]:
    """Find orders that stand out of the noise in many recordings, strongest first."""
    spectra = [r.steady.spectrum for r in reductions if r.steady is not None]
    if not spectra:
        return ()
    highest_order = min(s.size for s in spectra)
    ratios = np.stack([peak_ratio(s[:highest_order]) for s in spectra])
    share = (ratios > PEAK_RATIO).mean(axis=0)
    amplitude = np.sqrt(np.median(np.stack([s[:highest_order] for s in spectra]), axis=0))
    found = np.flatnonzero((share >= MIN_SHARE) & (amplitude >= MIN_AMPLITUDE_SHARE * amplitude[1:].max(initial=0.0)))
    found = found[np.argsort(-amplitude[found])]
    return tuple(
        Proposal(int(f), float(amplitude[f]), float(share[f]), part_of(float(f), gearbox, notch_orders), int(f) in used)
        for f in found
    )


def nuisance_orders(
    proposals: Sequence[Proposal], notch_orders: Sequence[int], highest_order: int, used: Sequence[float] = ()
) -> tuple[int, ...]:
    """Return the orders that stand out and are not asked for, to ``highest_order``: they are fitted with the others.

    A whole order within one of a ``used`` one that is no whole number stands out because of that one.
    """
    broken = fractions(used)
    return tuple(
        sorted(
            p.order
            for p in proposals
            if not p.used
            and p.order not in notch_orders
            and p.order <= highest_order
            and not (np.abs(broken - p.order) < 1.0).any()
        )
    )
