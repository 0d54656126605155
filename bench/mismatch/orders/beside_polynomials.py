"""What the polynomials leave of the vectors of the series' orders, and how much of that a course over the revolutions
says.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from bench.mismatch.orders.law_scores import (
    RANK,
    Amplitudes,
    amplitudes,
    is_beyond_polynomials,
    misfit,
    stacked,
    whitened,
)
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.revolutions import Complex, Revolution, passed
from bench.simulation.frame import FloatArray
from bench.simulation.laws import MODES

SURROGATES = 60
WIDE = 3.0
"""times the spread that the orders have shown which the polynomials of one are given: what they could say by more than
that is no evidence of a course either
"""
RIDGE = 1e-9
"""keeps a course that the polynomials say wholly from breaking a solve"""


def _straight(data: Amplitudes) -> FloatArray:
    """Orthonormal basis (revolutions, k) of straight lines over the state in either direction, as far as revolutions
    tell them apart.
    """
    lines = np.column_stack([np.ones(len(data.x)), data.x])
    sides = [np.where((data.direction * side > 0)[:, None], lines, 0.0) for side in data.series.scaling]
    columns = np.hstack(sides)
    left, values, _ = np.linalg.svd(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300), full_matrices=False)
    return np.asarray(left[:, values > RANK * values.max()])


@dataclass(frozen=True, slots=True)
class Sight:
    """What the polynomials leave of ``orders`` of the series in the training ``revolutions``: ``left`` (orders,
    2*revolutions), whitened by Cholesky factors ``lowers`` of their freedom and the noise ``sigma`` (orders,
    2*revolutions), behind the ``response`` (revolutions, orders) of modes. ``of_laws``: what other laws gain, without
    which all this is seen. An order pays for being chosen among ``many``. ``data``: all orders as they are seen;
    ``straight`` (revolutions, k): orthonormal basis of straight lines over load, speed and temperature in either
    direction.
    """

    revolutions: tuple[Revolution, ...]
    orders: tuple[float, ...]
    left: FloatArray
    lowers: tuple[FloatArray, ...]
    sigma: FloatArray
    response: Complex
    of_laws: float
    many: int
    data: Amplitudes
    straight: FloatArray

    @classmethod
    def of(cls, model: TransmissionModel) -> Sight | None:
        """The orders of a model into which no others leak; None where there are none, or too few revolutions."""
        if model.periodic is None:
            return None
        given = {id(law) for law in model.given.laws}
        kept = tuple(law for law in model.periodic.laws if id(law) in given or law.form in MODES)
        data = amplitudes(replace(model, periodic=replace(model.periodic, laws=kept)))
        if data is None or not data.regular.any():
            return None
        chosen = np.flatnonzero(data.regular)
        lowers, left = whitened(data, WIDE)
        held = {id(law) for law in kept}
        return cls(
            tuple(model.training_revolutions),
            tuple(data.orders[k] for k in chosen),
            left[chosen],
            tuple(lowers[k] for k in chosen),
            np.vstack([data.sigma[:, chosen]] * 2).T,
            passed(kept, model.training_revolutions, data.orders)[:, chosen],
            sum(law.gain for law in model.periodic.laws if id(law) not in held),
            chosen.size,
            data,
            _straight(data),
        )

    def beyond_polynomials(self, course: FloatArray) -> bool:
        """Whether a ``course`` (revolutions,) says what no polynomial of the series can."""
        return is_beyond_polynomials(course, self.data)

    def less(self, chosen: Sequence[int]) -> Sight:
        """The same with some of the orders."""
        return replace(
            self,
            orders=tuple(self.orders[k] for k in chosen),
            left=self.left[chosen],
            lowers=tuple(self.lowers[k] for k in chosen),
            sigma=self.sigma[chosen],
            response=self.response[:, chosen],
        )

    def scored(self, courses: FloatArray, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """Gain (courses, orders) of each of some ``courses`` (courses, revolutions), and what the best of them gains in
        draws of noise as large as what is left, or as it should be (SURROGATES,).
        """
        seen, drawn = [], np.zeros((len(courses), SURROGATES))
        for k in range(len(self.orders)):
            noise = self._drawn(k, rng)
            gains = self._gains(self._columns(k, courses), np.vstack([self.left[k], noise]))
            seen.append(gains[:, 0])
            drawn += gains[:, 1:]
        return np.array(seen).T, drawn.max(axis=0)

    def _drawn(self, k: int, rng: np.random.Generator) -> FloatArray:
        """Draws (SURROGATES, 2*revolutions) of what an order has if it follows nothing: what the polynomials leave of
        its vectors, over their noise, in other revolutions and with signs of their own, as large as it is seen, or as
        it should be. What the polynomials take of it is missing in the draws as well.
        """
        lower, sigma, number = self.lowers[k], self.sigma[k], len(self.revolutions)
        shaped = solve_triangular(lower, np.diag(sigma), lower=True)
        usual = max(float(np.sum(self.left[k] ** 2) / np.sum(shaped**2)), 1.0)
        over = sigma * solve_triangular(lower, self.left[k], lower=True, trans=1)
        over *= np.sqrt(usual / max(float(np.mean(over**2)), 1e-300))
        draws = np.empty((SURROGATES, 2 * number))
        for row in draws:
            at, sign = rng.permutation(number), rng.choice([-1.0, 1.0], number)
            row[:] = np.concatenate([over[at] * sign, over[number + at] * sign])
        return np.asarray(draws @ shaped.T)

    def gains(self, course: FloatArray) -> FloatArray:
        """Gain of log-likelihood (orders,) by a ``course`` (revolutions,), 0 where it does not pay for its numbers."""
        parts = ((self._columns(k, course[None]), self.left[k][None]) for k in range(len(self.orders)))
        return np.array([float(self._gains(z, left)[0, 0]) for z, left in parts])

    def estimated(self, course: FloatArray) -> tuple[tuple[float, ...], Complex, FloatArray]:
        """Orders that gain by a ``course`` (revolutions,), their vectors, the standard deviation of a component."""
        orders, vectors, std = [], [], []
        for k in np.flatnonzero(self.gains(course) > 0.0).tolist():
            z, r = self._columns(k, course[None])[0], self.left[k]
            inverse = np.linalg.inv(z.T @ z)
            found = inverse @ (z.T @ r)
            noise = max(float(np.mean((r - z @ found) ** 2)), 1.0)
            orders.append(self.orders[k])
            vectors.append(complex(found[0], found[1]))
            std.append(float(np.sqrt(0.5 * noise * np.trace(inverse))))
        return tuple(orders), np.array(vectors), np.array(std)

    def _columns(self, k: int, courses: FloatArray) -> FloatArray:
        """What a vector times each course does to an order, whitened (courses, 2*revolutions, 2)."""
        # straight lines over the state are the polynomials', however large: only what is beyond them counts
        curved = courses - courses @ self.straight @ self.straight.T
        moved = (curved / self.response[:, k]).T
        whole = np.hstack([stacked(moved), stacked(1j * moved)])
        white = solve_triangular(self.lowers[k], whole, lower=True)
        return np.stack([white[:, : len(courses)].T, white[:, len(courses) :].T], axis=2)

    def _gains(self, columns: FloatArray, left: FloatArray) -> FloatArray:
        """Gain (courses, draws) of an order by whitened ``columns`` (courses, 2*revolutions, 2), fitted to each of some
        draws of what is ``left`` (draws, 2*revolutions).
        """
        number = len(self.revolutions)
        product_of = np.swapaxes(columns, 1, 2) @ left.T
        gram = np.swapaxes(columns, 1, 2) @ columns
        size = np.trace(gram, axis1=1, axis2=2)[:, None, None]
        solved = np.linalg.solve(gram + (RIDGE * size + 1e-300) * np.eye(2), product_of)
        before = np.sum(left**2, axis=1)[None, :]
        after = np.maximum(before - np.sum(product_of * solved, axis=1), 0.0)
        # two numbers an order (BIC), and any of the orders
        price = float(np.log(2.0 * number) + np.log(self.many))
        return np.asarray(np.maximum(misfit(before, number) - misfit(after, number) - price, 0.0))
