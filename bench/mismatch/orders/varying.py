"""What an order gains whose amplitude and phase follow the state by polynomials, as those of the simulation do.

A few vectors in proportion to load, speed and temperature do not say an order whose phase turns far with the state. Of
such an order they say more at many places beside it, where the phase runs away with the angle, than where it is: so a
place is asked with polynomials as well.
"""

from __future__ import annotations

import numpy as np

from bench.mismatch.orders.revolutions import directions, states
from bench.mismatch.orders.series import Scaling, first_prior, fit_order
from bench.mismatch.orders.weak import Stage, gain_of
from bench.simulation.sines import phasors


def varying_gain(one: Stage) -> float:
    """Gain of log-likelihood of a stage's one order by polynomials of amplitude and phase, less what their freedom
    costs.

    The coefficients are integrated out about the best ones (Laplace's approximation): those that the revolutions do not
    tell cost nothing.
    """
    x, side = states(one.revolutions), directions(one.revolutions)
    vectors, sigma, prior = one.vectors[:, 0] * one.scale, one.shape[0] * one.scale, first_prior()
    held, squares, freedom = [*range(9), *range(10, 19)], 0.0, 0.0
    for rows in (side > 0, side <= 0):
        if not rows.any():
            continue
        basis = Scaling.of(x[rows], x[:0]).monomials(x[rows])
        fit = fit_order(basis, vectors[rows], sigma[rows], prior)
        spread = np.concatenate([prior[:9] * fit.size, prior[9:]])
        inner = fit.covariance[np.ix_(held, held)] / np.outer(spread, spread)
        freedom -= 0.5 * float(np.linalg.slogdet(inner)[1])
        left = vectors[rows] - (basis @ fit.amplitude) * phasors(basis @ fit.phase)
        coefficients = np.concatenate([fit.amplitude, fit.phase])[held]
        # by the noise alone: what the fit allows beyond it (RELATIVE_NOISE) is no gain of the polynomials
        squares += float(np.sum(np.abs(left / sigma[rows]) ** 2) + np.sum((coefficients / spread) ** 2))
    # a vector for each direction, as any model of two directions has
    freedom += float(np.log(len(one.revolutions))) * (np.unique(side > 0).size - 1)
    before = np.array([float(np.sum(np.abs(one.vectors) ** 2))])
    after = squares * one.shape[:1] ** 2
    return float(gain_of(before, after, len(one.revolutions), one.shape[:1])[0]) - freedom
