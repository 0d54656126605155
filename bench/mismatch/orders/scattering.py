"""Orders of the series whose vectors scatter more than noise about all that the model says of them: something moves
them that nothing recorded tells.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import f as fisher

from bench.mismatch import criteria
from bench.mismatch.orders.law_scores import PRIOR_REVOLUTIONS, amplitudes, whitened
from bench.mismatch.orders.model import TransmissionModel
from bench.mismatch.orders.revolutions import passed
from bench.mismatch.regression.windows import strongest


def scattering(model: TransmissionModel) -> tuple[tuple[float, ...], float]:
    """Orders that scatter, those with nine tenths of it, the strongest first; and the mean square of all such, rad².

    The noise of an order is known from its neighbours as well as so many revolutions would tell it, which leaves the
    ratio of what is seen to it an F distribution.
    """
    data = amplitudes(model)
    if data is None:
        return (), 0.0
    left = whitened(data)[1]
    ratio = np.mean(left**2, axis=1)
    chance = fisher.sf(ratio, left.shape[1], 2.0 * PRIOR_REVOLUTIONS)
    rare = data.regular & (chance < criteria.ERROR_RATE_OF_A_CHANNEL / len(data.orders))
    # a wave b*sin + a*cos has half of |b + j*a|² as its mean square: the variance of a component
    assert model.periodic is not None
    response = passed(model.periodic.laws, model.training_revolutions, data.orders)
    sigma = np.median(data.sigma * np.abs(response), axis=0)
    square = np.where(rare, (ratio - 1.0) * sigma**2, 0.0)
    return tuple(float(data.orders[k]) for k in strongest(square)), float(square.sum())
