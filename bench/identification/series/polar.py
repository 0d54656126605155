"""One estimator of an order's polynomials, for identification and mismatch analysis.

An order's vector z = A·exp(iφ) was seen at several operating points; A and φ are linear in the monomials of torque,
speed and temperature. Both are fitted to the vectors at once, which know no wrapping and no undefined phase where A is
small, by SciPy's Levenberg-Marquardt (MINPACK). Errors along and across a vector may have variances of their own, and
coefficients a normal prior about 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import leastsq

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

STEP, GAIN = 1e-7, 1e-8
"""Relative change of the coefficients, and of the sum of squares, at which a fit has converged."""
GRADIENT = 1e-8
"""Cosine of the angle between the residual and every column of the Jacobian at which it has, too."""


@dataclass(frozen=True, slots=True)
class Polynomials:
    """Coefficients (P,) of amplitude and phase, the weighted squares with the prior's, covariance (2P, 2P).

    ``open_share`` (2P,) is how much of each coefficient's prior variance the vectors leave: 1 where they say nothing.
    """

    amplitude: FloatArray
    phase: FloatArray
    squares: float
    covariance: FloatArray
    open_share: FloatArray


def mean_size(vector: ComplexArray) -> float:
    """Root mean square of vectors (n,); not 0."""
    return float(np.sqrt(np.mean(np.abs(vector) ** 2))) or 1e-12


def _lowest(
    residual: Callable[[FloatArray], FloatArray], jacobian: Callable[[FloatArray], FloatArray], start: FloatArray
) -> tuple[FloatArray, float]:
    """Where the squares of a residual are lowest, downhill from ``start``, and what they are there (MINPACK's lmder).

    ``leastsq`` and not ``least_squares``: the same routine, called ten thousands of times, without what the latter does
    around it, which takes as long as the routine.
    """
    found = leastsq(
        residual, start, Dfun=jacobian, ftol=GAIN, xtol=STEP, gtol=GRADIENT, diag=np.ones(start.size), full_output=True
    )
    squares = float(np.sum(found[2]["fvec"] ** 2))
    if not np.isfinite(squares):
        raise ValueError("vectors that are no numbers cannot be fitted")
    return np.asarray(found[0]), squares


def fit_polynomials(
    basis: FloatArray,
    vector: ComplexArray,
    along: FloatArray,
    across: FloatArray,
    starts: Sequence[FloatArray],
    frame: FloatArray | None = None,
    prior: FloatArray | None = None,
) -> Polynomials:
    """Fit amplitude and phase polynomials to vectors.

    Parameters
    ----------
    basis : (n, P) monomials. vector : (n,) seen.
    along, across : (n,) variances of a vector's error, along and across the direction ``frame``.
    starts : coefficients (2P,), amplitude's first, to begin with; the best end counts.
    frame : (n,) rad, directions of the vectors; 0 where both variances are the same.
    prior : (2P,) standard deviation of each coefficient about 0, infinite for none; None for none at all.
    """
    size = basis.shape[1]
    spread = np.full(2 * size, np.inf) if prior is None else prior
    # what has no prior is measured in units of the order itself: of its size, and of a radian
    unit = np.repeat([mean_size(vector), 1.0], size)
    held = np.isfinite(spread)
    scale = np.where(held, spread, unit)
    pull = np.diag(held.astype(np.float64))[held]
    back = np.exp(-1j * frame) if frame is not None else np.ones(vector.size, dtype=np.complex128)
    first, second = 1.0 / np.sqrt(along), 1.0 / np.sqrt(across)

    def parts(values: ComplexArray) -> FloatArray:
        rotated = values.T * back
        return np.concatenate([(rotated.real * first).T, (rotated.imag * second).T])

    def residual(z: FloatArray) -> FloatArray:
        x = z * scale
        left = (basis @ x[:size]) * np.exp(1j * (basis @ x[size:])) - vector
        return np.concatenate([parts(left), z[held]])

    def jacobian(z: FloatArray) -> FloatArray:
        x = z * scale
        phasor = np.exp(1j * (basis @ x[size:]))
        columns = np.hstack([phasor[:, None] * basis, (1j * (basis @ x[:size]) * phasor)[:, None] * basis])
        return np.vstack([parts(columns) * scale, pull])

    runs = [_lowest(residual, jacobian, start / scale) for start in starts]
    best, squares = min(runs, key=lambda run: run[1])
    x = best * scale
    normal = np.zeros((2 * size, 2 * size))
    # with the amplitude of the model itself: where there is none, a phase stays undetermined
    level = basis @ x[:size]
    normal[:size, :size] = (basis.T / along) @ basis
    normal[size:, size:] = (basis.T * (level**2 / across)) @ basis
    inner = np.linalg.pinv(normal * np.outer(scale, scale) + pull.T @ pull, rcond=1e-12, hermitian=True)
    return Polynomials(x[:size].copy(), x[size:].copy(), squares, inner * np.outer(scale, scale), np.diag(inner).copy())
