"""What the simulation's own terms can say of some values, weighted as a fit weighs rows: asked of every candidate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.mismatch.regression.problem import ChannelProblem
from bench.mismatch.regression.regressors import Regressor
from bench.simulation.frame import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """The terms' ``columns`` (n, k) on the training rows in units of their own size, the ``weight`` (n,) of a row, the
    ``normal`` matrix (k, k) with the prior.
    """

    columns: FloatArray
    weight: FloatArray
    normal: FloatArray

    @classmethod
    def of(
        cls, problem: ChannelProblem, terms: Sequence[Regressor], precision: FloatArray, sigma: FloatArray
    ) -> Calibration:
        """``precision`` (k,) of the terms' coefficients, ``sigma`` (n,) of the training rows."""
        train = problem.train
        columns = [np.zeros((sigma.size, 0)), *(t.columns(problem.rows.frame)[train] for t in terms)]
        x, weight = np.hstack(columns), 1.0 / sigma
        scale = np.maximum(np.sqrt(np.mean((x * weight[:, None]) ** 2, axis=0)), 1e-100)
        x /= scale
        weighted = x * weight[:, None]
        normal = weighted.T @ weighted
        share = 1e-9 * float(np.trace(normal)) / max(normal.shape[0], 1)
        normal[np.diag_indices_from(normal)] += precision / scale**2 + share
        return cls(x, weight, normal)

    def projected(self, values: FloatArray) -> FloatArray:
        """The part of ``values`` that the terms explain, (n,) on the training rows."""
        if not self.normal.size:
            return np.zeros(values.size)
        return np.asarray(self.columns @ np.linalg.solve(self.normal, self.columns.T @ (values * self.weight**2)))

    def beyond(self, values: FloatArray) -> FloatArray:
        """The part of ``values`` (n,) that the terms cannot explain."""
        return np.asarray(values - self.projected(values))
