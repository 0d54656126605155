"""How long an effect's description is: what each of its numbers costs before it is believed.

Where every operating point was run apart, points left out show what a number is worth: the search needs no other
price. Recordings of somebody else's machine are mostly one motion, repeated or cut into pieces. A function that fits
one piece fits the others, whatever it is of. There a number costs half the logarithm of the samples that tell it
(Rissanen, Automatica 14 (1978) 465; Schwarz, Ann. Stat. 6 (1978) 461), for names and free functions alike.
"""

from __future__ import annotations

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.regression.model import ChannelModel, Chosen
from bench.mismatch.regression.regressors import UNKNOWN
from bench.mismatch.regression.spells import changing_of


def description(model: ChannelModel, chosen: Chosen) -> float:
    """Log density that an effect has to gain for its numbers; 0 where the points left out tell it."""
    independent_rows = model.noise.independent_rows
    if independent_rows is None:
        return 0.0
    changing = changing_of(chosen.main.regressor)
    paid = 0 if changing is None else changing.changes  # by the price of a change, each with its level
    return 0.5 * (chosen.main.regressor.numbers - paid) * float(np.log(max(independent_rows, 2.0)))


def prior_of(chosen: Chosen) -> float:
    """Probability of an effect before anything is measured, over that of nothing: a free function is less likely than a
    name.
    """
    return float(np.exp(-criteria.RICHER)) if chosen.effect == UNKNOWN else 1.0
