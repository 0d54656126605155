"""Sums over samples at uneven angles, S_m = Σ_j c_j·exp(i·m·θ_j) for all integer orders m at once.

A non-uniform FFT of type 1 (Barnett, Magland, af Klinteberg, SIAM J. Sci. Comput. 41 (2019) C479) costs one pass over
the samples, whatever the number of orders; no samples × orders matrix is built. Its relative error is bounded by the
tolerance asked of it, here 1e-8 of Σ|c_j|: 3e-13 rad where the error is 30 µrad.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import finufft
import numpy as np
from numba import njit
from numpy.typing import NDArray

from bench.identification.samples.fractions import NO_FRACTIONS, IntArray, columns

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

TOLERANCE = 1e-8


@lru_cache(maxsize=8)
def _plan(modes: int) -> finufft.Plan:
    return finufft.Plan(1, (2 * modes + 1,), n_trans=1, eps=TOLERANCE, isign=1, nthreads=1)


def angle_sums(
    theta: FloatArray, first: FloatArray, second: FloatArray, modes: int
) -> tuple[ComplexArray, ComplexArray]:
    """Sums S_0 … S_modes of two real sequences at the same angles, by one transform.

    Parameters
    ----------
    theta : (N,) rad, any range.
    first, second : (N,) real strengths.
    modes : highest order.

    Returns
    -------
    Two arrays (modes + 1,): Σ_j first_j·exp(i·m·θ_j) and the same for ``second``.
    """
    plan = _plan(modes)
    plan.setpts(theta)
    strengths = np.empty(theta.size, dtype=np.complex128)
    strengths.real, strengths.imag = first, second
    both = plan.execute(strengths)
    positive, negative = both[modes:], np.conj(both[modes::-1])
    return 0.5 * (positive + negative), -0.5j * (positive - negative)


def gram(sums: ComplexArray, orders: FloatArray, extra: FloatArray = NO_FRACTIONS) -> FloatArray:
    """Gram matrix of the regressors [sin f_1θ … sin f_Kθ, cos f_1θ … cos f_Kθ, 1] from S_m of unit strengths.

    Parameters
    ----------
    sums : (..., M + 1 + E) with M ≥ 2·max(orders); those at ``extra`` (E,) last (:mod:`.fractions`).
    orders : (K,) orders.

    Returns
    -------
    (..., 2K + 1, 2K + 1).
    """
    size, whole = orders.size, sums.shape[-1] - extra.size
    plus = sums[..., columns(orders[:, None] + orders[None, :], whole, extra)]
    difference = orders[:, None] - orders[None, :]
    minus = sums[..., columns(np.abs(difference), whole, extra)]
    minus = np.where(difference < 0, np.conj(minus), minus)
    out = np.empty((*sums.shape[:-1], 2 * size + 1, 2 * size + 1))
    s, c = slice(0, size), slice(size, 2 * size)
    out[..., s, s] = 0.5 * (minus.real - plus.real)
    out[..., c, c] = 0.5 * (minus.real + plus.real)
    out[..., s, c] = 0.5 * (plus.imag + minus.imag)
    out[..., c, s] = np.swapaxes(out[..., s, c], -1, -2)
    single = sums[..., columns(orders, whole, extra)]
    out[..., s, -1] = out[..., -1, s] = single.imag
    out[..., c, -1] = out[..., -1, c] = single.real
    out[..., -1, -1] = sums[..., 0].real
    return out


def projections(sums: ComplexArray, orders: FloatArray, extra: FloatArray = NO_FRACTIONS) -> FloatArray:
    """Products of the regressors of :func:`gram` with a sequence whose sums are given, shape (..., 2K + 1)."""
    single = sums[..., columns(orders, sums.shape[-1] - extra.size, extra)]
    return np.concatenate([single.imag, single.real, sums[..., :1].real], axis=-1)


@dataclass(frozen=True, slots=True)
class Shifts:
    """Columns in an array of sums of unit strength that make up the sums of a series of K orders at F frequencies.

    ``unshifted`` (F,) are those of the frequencies themselves, ``above`` and ``below`` (F, K) those of each frequency
    plus and minus each order; ``mirrored`` (F, K) is true where the difference is negative.
    """

    unshifted: IntArray
    above: IntArray
    below: IntArray
    mirrored: NDArray[np.bool_]

    @classmethod
    def of(cls, frequencies: FloatArray, orders: FloatArray, whole: int, extra: FloatArray = NO_FRACTIONS) -> Shifts:
        """Return those of ``orders`` (K,) at ``frequencies`` (F,) in sums of ``whole`` orders and ``extra``."""
        difference = frequencies[:, None] - orders
        return cls(
            columns(frequencies, whole, extra),
            columns(frequencies[:, None] + orders, whole, extra),
            columns(np.abs(difference), whole, extra),
            difference < 0,
        )

    def series(self, sums: ComplexArray, coefficients: FloatArray) -> ComplexArray:
        """Sums (F,) of the series with ``coefficients`` (B, 2K + 1) in blocks, from their unit sums (B, …)."""
        return np.asarray(_series(sums, coefficients, self.unshifted, self.above, self.below, self.mirrored))


@njit(cache=True)
def _series(
    sums: ComplexArray,
    coefficients: FloatArray,
    unshifted: IntArray,
    above: IntArray,
    below: IntArray,
    mirrored: NDArray[np.bool_],
) -> ComplexArray:
    size = above.shape[1]
    out = np.zeros(unshifted.size, dtype=np.complex128)
    for b in range(sums.shape[0]):
        for i in range(unshifted.size):
            total = coefficients[b, 2 * size] * sums[b, unshifted[i]]
            for k in range(size):
                half = 0.5 * complex(coefficients[b, size + k], -coefficients[b, k])
                under = sums[b, below[i, k]]
                if mirrored[i, k]:
                    under = under.conjugate()
                total += half * sums[b, above[i, k]] + half.conjugate() * under
            out[i] += total
    return out
