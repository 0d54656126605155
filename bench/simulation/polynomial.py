"""Quadratic polynomial with two-factor interactions in load torque, velocity and temperature.

Source: C. J. E. Bauer et al., "Modeling Load-, Velocity-, and Temperature-Dependent Transmission Errors of Cycloidal
Drives for Industrial Robots Using Fourier Series", ICIT 2025, equation of A_k(τ, θ̇, T).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

TERM_COUNT = 10
EXPONENTS: tuple[tuple[int, int, int], ...] = (
    (2, 0, 0),
    (0, 2, 0),
    (0, 0, 2),
    (1, 0, 0),
    (0, 1, 0),
    (0, 0, 1),
    (1, 1, 0),
    (1, 0, 1),
    (0, 1, 1),
    (0, 0, 0),
)
"""Powers of (τ, θ̇, T) in the paper's order of terms i = 1 … 10."""
TERM_NAMES: tuple[str, ...] = ("τ²", "θ̇²", "T²", "τ", "θ̇", "T", "τ·θ̇", "τ·T", "θ̇·T", "1")
CONSTANT = 9


def basis(torque: ArrayLike, velocity: ArrayLike, temperature: ArrayLike) -> FloatArray:
    """Return the ten monomials, shape (..., 10), for load torque N·m, θ̇ rad/s and temperature °C of one shape (...)."""
    tau, rate, temp = np.broadcast_arrays(
        np.asarray(torque, dtype=np.float64),
        np.asarray(velocity, dtype=np.float64),
        np.asarray(temperature, dtype=np.float64),
    )
    out = np.empty((*tau.shape, TERM_COUNT))
    for i, column in enumerate(
        (tau * tau, rate * rate, temp * temp, tau, rate, temp, tau * rate, tau * temp, rate * temp, 1.0)
    ):
        out[..., i] = column
    return out


@dataclass(frozen=True, slots=True)
class Standardisation:
    """Inputs less their ``mean``, divided by their standard deviation ``std`` (both (3,), in τ, θ̇, T)."""

    mean: FloatArray
    std: FloatArray

    @classmethod
    def of(cls, torque: ArrayLike, velocity: ArrayLike, temperature: ArrayLike) -> Standardisation:
        """Take mean and standard deviation of the inputs (n,); an input that does not vary keeps the scale 1."""
        inputs = np.stack([np.asarray(x, dtype=np.float64) for x in (torque, velocity, temperature)])
        std = inputs.std(axis=1)
        return cls(inputs.mean(axis=1), np.where(std > 1e-9 * (1.0 + np.abs(inputs.mean(axis=1))), std, 1.0))

    def basis(self, torque: ArrayLike, velocity: ArrayLike, temperature: ArrayLike) -> FloatArray:
        """Return the ten monomials of the standardised inputs, shape (..., 10)."""
        scaled = [
            (np.asarray(x, dtype=np.float64) - self.mean[i]) / self.std[i]
            for i, x in enumerate((torque, velocity, temperature))
        ]
        return basis(*scaled)

    def matrix(self) -> FloatArray:
        """Matrix M (10, 10) with ``standardised basis = raw basis @ M.T``."""
        rows = np.zeros((TERM_COUNT, TERM_COUNT))
        index = {powers: i for i, powers in enumerate(EXPONENTS)}
        for i, powers in enumerate(EXPONENTS):
            # Expand Π ((x_j − m_j) / s_j)^p_j into monomials of the raw inputs.
            expansion: dict[tuple[int, int, int], float] = {(0, 0, 0): 1.0}
            for j, power in enumerate(powers):
                for _ in range(power):
                    grown: dict[tuple[int, int, int], float] = {}
                    for exponents, value in expansion.items():
                        raised = (exponents[0] + (j == 0), exponents[1] + (j == 1), exponents[2] + (j == 2))
                        grown[raised] = grown.get(raised, 0.0) + value / self.std[j]
                        grown[exponents] = grown.get(exponents, 0.0) - value * self.mean[j] / self.std[j]
                    expansion = grown
            for exponents, value in expansion.items():
                rows[i, index[exponents]] += value
        return rows

    def to_raw(self, coefficients: ArrayLike) -> FloatArray:
        """Scale coefficients (..., 10) of the standardised inputs back to the raw inputs."""
        return np.asarray(coefficients, dtype=np.float64) @ self.matrix()

    def covariance_to_raw(self, covariance: ArrayLike) -> FloatArray:
        """Scale a covariance (..., 10, 10) of standardised coefficients back to the raw inputs."""
        matrix = self.matrix()
        return np.asarray(matrix.T @ np.asarray(covariance, dtype=np.float64) @ matrix)
