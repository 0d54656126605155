"""Whether a design really cannot tell an effect from its rival, on the bench that was drawn for it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fakes.concealed.campaign import Campaign
from fakes.concealed.design import Point
from fakes.concealed.effects.base import Effect, Floats
from fakes.concealed.effects.formula import FORMS
from fakes.concealed.plant import Plant
from fakes.concealed.strength import measure

ALIKE = 0.9
"""R² of the one's excess on the other's from which nobody is asked to tell them apart."""
_RATE_HZ = 20.0
_DRAWS = 3
"""Sets of numbers tried of each of the rival's forms: the likest of them counts."""


def overlap(plant: Plant, points: Sequence[Point], seed: int, effect: Effect, rivals: Sequence[str]) -> float:
    """Greatest R² between the excess of an effect and that of its rivals' forms, after the nominal's refit."""

    def excess(of: Effect) -> Floats:
        return measure(Campaign(plant, (of,), points, seed), effect.channels[0], _RATE_HZ)

    mine = excess(effect)
    if not mine.any():
        return 0.0
    best = 0.0
    for form in (form for form in FORMS if form.effect in rivals):
        for draw in range(_DRAWS):
            other = excess(form.make(np.random.default_rng(draw)))
            if other.any():
                best = max(best, float((mine @ other) ** 2 / (mine @ mine) / (other @ other)))
            if best >= ALIKE:
                return best
    return best
