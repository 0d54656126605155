"""What a discovery's term says by itself, from its row of the simulation file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.mismatch.discovery import Discovery
from bench.mismatch.regression.candidates import PERIODIC
from bench.mismatch.regression.regressors import Named, named
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LIBRARY


@dataclass(frozen=True, slots=True)
class Truth:
    """A term with its coefficients, taken for true."""

    term: Named
    coefficients: FloatArray

    def on(self, frame: Frame) -> FloatArray:
        """What it adds at the rows of a frame (n,)."""
        return np.asarray(self.term.columns(frame) @ self.coefficients)


def truth_of(discovery: Discovery) -> Truth | None:
    """A discovery's term with the values of its simulation row; None where it is no regressor of the library."""
    if not is_regressor(discovery.effect, discovery.channel):
        return None
    for row in discovery.simulation_rows:
        values = row.get("parameters", {})
        if row.get("effect") != discovery.effect or discovery.channel not in row.get("channels", [discovery.channel]):
            continue
        form = LIBRARY[discovery.effect].form(discovery.channel, row.get("form"))
        if form is None or any(s.symbol not in values for s in form.linear):
            continue
        term = named(discovery.effect, discovery.channel, form.name, tuple(float(v) for v in row.get("point", ())))
        return Truth(term, np.array([float(values[s.symbol]["value"]) for s in form.linear]))
    return None


def is_regressor(effect: str, channel: str) -> bool:
    """Whether an effect is a function of the rows of a channel, no wave over the angle."""
    return effect in LIBRARY and channel in LIBRARY[effect].forms and effect not in PERIODIC
