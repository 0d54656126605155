"""A law's numbers without the changes of it that were found beside it.

A change of a law is the law's neighbour: drag that bends over with speed is mostly a straight line over it. Fitted
together each number answers for the form of the other: f_c beside churning is what a parabola leaves at standstill,
where a machine hardly ever is. So a law's numbers are those that it has beside everything but its changes (marginality:
Nelder, J. R. Stat. Soc. A 140 (1977) 48), and the changes shift them by something, which is no less uncertain than the
form of a change is. Where operating points were run apart, on purpose at low speeds too, both are reported together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.mismatch.regression.heredity import laws
from bench.mismatch.regression.model import ChannelModel, Chosen
from bench.mismatch.regression.regressors import Named
from bench.simulation.frame import FloatArray


@dataclass(frozen=True, slots=True)
class Alone:
    """Coefficients (k,) of a law beside all but its changes; its ``std`` (k,) and, with ``shift`` (k,), what the
    changes take of them.
    """

    coefficients: FloatArray
    std: FloatArray
    shift: FloatArray

    def widened(self, std: FloatArray) -> FloatArray:
        """Standard deviations (k,) with what the changes shift."""
        return np.hypot(std, self.shift)


def alone(model: ChannelModel, effect: Chosen) -> Alone | None:
    """What an effect is without the named changes of it in the model; None where there are none, or where points left
    out tell both.
    """
    if not model.problem.free or not isinstance(effect.main.regressor, Named):
        return None
    left = [c for c in model.chosen if c is effect or not _changes(c, effect)]
    if len(left) == len(model.chosen):
        return None
    fitted = model.refitted(left)
    coefficients, _ = fitted.of(effect.main.indices)
    beside, _ = model.fit.of(effect.main.indices)
    return Alone(coefficients, model.std(effect.main.indices, fitted), beside - coefficients)


def _changes(one: Chosen, law: Chosen) -> bool:
    """Whether an effect is a named change of a law: a table is made to say nothing of laws."""
    return isinstance(one.main.regressor, Named) and law.effect in laws(one.main.regressor)
