"""Which monomials of (τ, θ̇, T) a set of operating points determines, and the standardised regressors of those."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.simulation.polynomial import CONSTANT, EXPONENTS, TERM_COUNT, TERM_NAMES, Standardisation

FloatArray = NDArray[np.float64]

ENTRY_ORDER = (CONSTANT, 3, 4, 5, 0, 1, 2, 6, 7, 8)
"""Constant, linear, quadratic, interactions: simpler monomials are kept first."""
MIN_INDEPENDENT_SHARE = 0.08
"""A monomial is kept if at least this share of its (standardised) norm is not made up of those kept before."""
INPUT_NAMES = ("load torque", "velocity", "temperature")
INPUT_UNITS = ("N·m", "rad/s", "°C")


@dataclass(frozen=True, slots=True)
class Design:
    """Operating points of one direction: inputs (R, 3), standardised regressors (R, P) of the monomials ``kept``."""

    inputs: FloatArray
    standardisation: Standardisation
    kept: NDArray[np.int64]
    regressors: FloatArray

    @property
    def dropped(self) -> tuple[str, ...]:
        """Names of the monomials the points do not determine."""
        return tuple(TERM_NAMES[i] for i in range(TERM_COUNT) if i not in self.kept)

    def columns(self, inputs: FloatArray) -> FloatArray:
        """Return the kept regressors (..., P) at other points (..., 3)."""
        return self.standardisation.basis(inputs[..., 0], inputs[..., 1], inputs[..., 2])[..., self.kept]

    def to_raw(self, coefficients: FloatArray) -> FloatArray:
        """Scale (..., P) coefficients back to all ten monomials of the raw inputs."""
        return self.standardisation.to_raw(coefficients @ self._embedding())

    def raw_matrix(self) -> FloatArray:
        """Matrix E (P, 10) with ``raw coefficients = coefficients @ E``."""
        return np.asarray(self._embedding() @ self.standardisation.matrix())

    def _embedding(self) -> FloatArray:
        return np.eye(TERM_COUNT)[self.kept]


def _varies(values: FloatArray, index: int) -> bool:
    """Whether an input varies by more than its noise: 2 K, 3 % of the mean speed, 1 % of the torque."""
    spread = float(values.std())
    floors = (max(1.0, 0.01 * float(np.abs(values).max(initial=0.0))), 0.03 * float(np.abs(values).mean()) + 1e-9, 2.0)
    return spread > floors[index]


def make_design(inputs: FloatArray) -> Design:
    """Choose the monomials that points (R, 3) determine; inputs that are NaN throughout count as not varying.

    One point less than there are, so that the scatter between them is seen; a single one determines the constant.
    """
    clean = np.where(np.isfinite(inputs), inputs, 0.0)
    standardisation = Standardisation.of(clean[:, 0], clean[:, 1], clean[:, 2])
    full = standardisation.basis(clean[:, 0], clean[:, 1], clean[:, 2])
    alive = [_varies(clean[:, j], j) for j in range(3)]
    kept: list[int] = []
    most = max(inputs.shape[0] - 1, 1)
    basis = np.empty((inputs.shape[0], 0))
    for index in ENTRY_ORDER:
        if not all(alive[j] or power == 0 for j, power in enumerate(EXPONENTS[index])):
            continue
        column = full[:, index]
        rest = column - basis @ (basis.T @ column)
        norm = float(np.linalg.norm(rest))
        if len(kept) < most and norm > MIN_INDEPENDENT_SHARE * max(float(np.linalg.norm(column)), 1e-12):
            kept.append(index)
            basis = np.column_stack([basis, rest / norm])
    chosen = np.asarray(sorted(kept), dtype=np.int64)
    return Design(clean, standardisation, chosen, full[:, chosen])


def undetermined(design: Design, direction: str) -> list[str]:
    """One sentence for each input that the points do not let the polynomials depend on as they should."""
    sentences = []
    for j, name in enumerate(INPUT_NAMES):
        missing = [TERM_NAMES[i] for i in range(TERM_COUNT) if EXPONENTS[i][j] and i not in design.kept]
        if missing:
            low, high = float(design.inputs[:, j].min()), float(design.inputs[:, j].max())
            sentences.append(
                f"In {direction} direction the {name} covers {low:.4g} to {high:.4g} {INPUT_UNITS[j]} in too few "
                f"levels: the polynomial terms {', '.join(missing)} are not determined and are left at 0."
            )
    return sentences
