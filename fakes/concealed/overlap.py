"""Whether a campaign can tell an effect from another: how much of the one the other says as well."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from fakes.concealed.campaign import Campaign
from fakes.concealed.effects.base import Effect
from fakes.concealed.effects.formula import FORMS
from fakes.concealed.strength import measure

_RATE_HZ = 2.0
_DRAWS = 6  # of the numbers of each form


def overlap(campaign: Campaign, effect: Effect, others: Collection[str]) -> float:
    """Largest share (0 to 1) of the energy of an effect's excess that an excess of some other effects holds, over
    their forms and some draws of their numbers.
    """
    channel = effect.channels[0]

    def excess(one: Effect) -> np.ndarray:
        return measure(Campaign(campaign.plant, (one,), campaign.points, campaign.seed), channel, _RATE_HZ)

    first = excess(effect)
    shares = [0.0]
    for form in (f for f in FORMS if f.effect in others):
        for draw in range(_DRAWS):
            other = excess(form.make(np.random.default_rng(draw)))
            energy = float(first @ first) * float(other @ other)
            shares.append(float(first @ other) ** 2 / energy if energy > 0.0 else 0.0)
    return max(shares)
