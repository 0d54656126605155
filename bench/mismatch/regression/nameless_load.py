"""A load that may never have been: what the torque channel has without a name may be an error of its sensor, or a load
where it is taken to be a segment's mean. Either changes the transmission error by the compliance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.mismatch.regression.model import ChannelModel, Chosen
from bench.mismatch.regression.problem import BaseTerm, Untold
from bench.mismatch.regression.regressors import UNKNOWN
from bench.simulation.frame import FloatArray, Frame


@dataclass(frozen=True, slots=True)
class NamelessLoad(Untold):
    """What the load torque has without a name, N·m; its coefficient is free: nothing tells an error from a load."""

    model: ChannelModel
    nameless: tuple[Chosen, ...]
    words: str = "twist of what the load torque has without a name"
    equation: str = "TE += dtau/K"

    def columns(self, frame: Frame) -> FloatArray:
        """Sum of the functions without a name at the rows of a frame (n, 1)."""
        parts = (self.model.contribution(effect, frame) for effect in self.nameless)
        return np.asarray(sum(parts, np.zeros(frame.size)))[:, None]


def nameless_load(model: ChannelModel) -> tuple[BaseTerm, ...]:
    """The base term of the transmission error for a model of the load torque; none where all that it has is named."""
    nameless = tuple(effect for effect in model.chosen if effect.effect == UNKNOWN)
    return (BaseTerm(NamelessLoad(model, nameless)),) if nameless else ()
