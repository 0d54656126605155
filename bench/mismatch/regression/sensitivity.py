"""How a simulation from elsewhere changes with one of its parameters: a regressor of the simulation that is compared.

Its coefficient is by how much the parameter differs from the value at which the simulation was run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.foreign.base import BY, Base
from bench.recording import SIMULATED
from bench.simulation.frame import FloatArray, Frame

PARAMETER = "parameter"
"""effect of a finding that says which parameter of the simulation was wrong"""


def carried(channel: str, parameter: str) -> str:
    """Name among a frame's auxiliary quantities under which a sensitivity is carried."""
    return f"{SIMULATED}{channel}{BY}{parameter}"


def is_carried(name: str) -> bool:
    """Whether an auxiliary quantity is a sensitivity, and so no candidate."""
    return name.startswith(SIMULATED)


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """The derivative of a channel with respect to a parameter."""

    channel: str
    parameter: str
    unit: str = "1"
    effect: str = PARAMETER
    variables: tuple[str, ...] = ()
    numbers: int = 1

    @property
    def words(self) -> str:
        """What it is, for people."""
        return f"the simulation's parameter {self.parameter}"

    @property
    def equation(self) -> str:
        """Its equation."""
        return f"{self.channel} += d({self.channel})/d({self.parameter}) * change of {self.parameter}"

    def columns(self, frame: Frame) -> FloatArray:
        """The derivative (n, 1) on the rows of a frame; 0 where nothing was simulated."""
        values = frame.aux.get(carried(self.channel, self.parameter))
        return (np.zeros(frame.size) if values is None else values)[:, None]

    def parameters(self, coefficients: FloatArray, std: FloatArray) -> list[dict[str, Any]]:
        """By how much the parameter differs."""
        return [
            {"symbol": self.parameter, "value": float(coefficients[0]), "unit": self.unit, "std": float(std[0])},
        ]

    def row(self, coefficients: FloatArray, std: FloatArray) -> dict[str, Any]:
        """Empty: the parameter's value stands with the simulation it is of."""
        del coefficients, std
        return {}


def sensitivities(base: Base | None, channel: str, carriers: Sequence[str]) -> list[Sensitivity]:
    """Regressors of a channel: one for each free parameter on which some row depends (``carriers``: names carried)."""
    if base is None:
        return []
    return [Sensitivity(channel, p.name, p.unit) for p in base.free if carried(channel, p.name) in carriers]
