"""Channels that were predicted elsewhere and lie in the recordings: ``simulated/NAME``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from bench.errors import ConfigurationError
from bench.foreign.base import PREDICTED, Channels, Values
from bench.recording import SIMULATED
from bench.simulation.frame import FloatArray

WORD = "columns"
"""names this kind on the command line"""


@dataclass(frozen=True, slots=True)
class Columns:
    """A simulator whose predictions are stored in the recording already."""

    kind: str = WORD
    source: str = WORD

    def run(self, inputs: Mapping[str, FloatArray], values: Values) -> Channels:
        """Channels of the recording that begin with ``simulated/``; the load's angle makes a transmission error.

        Raises ConfigurationError where there is none.
        """
        del values
        out = {name: inputs[SIMULATED + name] for name in PREDICTED if SIMULATED + name in inputs}
        if f"{SIMULATED}load_angle" in inputs and "theta" in inputs:
            out.setdefault("transmission_error", inputs[f"{SIMULATED}load_angle"] - inputs["theta"])
        if not out:
            raise ConfigurationError(
                f"the recording has no channel {SIMULATED}NAME, NAME one of {', '.join(PREDICTED)}, load_angle."
            )
        return out
