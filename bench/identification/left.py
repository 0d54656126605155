"""What a model left of the recordings it was fitted to, as it stands beside the series of a simulation file.

The key ``left_rmse`` of ``te.fourier`` has by direction the mean root mean square of the transmission error's residual
in rad, without its mean, over the recordings that the series was fitted to.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from bench.identification.validation import Score, table
from bench.simulation import Simulation

KEY = "left_rmse"


def left_entry(scores: Sequence[Score], method: str) -> dict[str, dict[str, float]]:
    """Return what the series' term says of it; nothing where no recording was scored."""
    rows = table(scores).get("identification", {})
    found = {direction: by_method[method]["rmse"] for direction, by_method in rows.items() if method in by_method}
    return {KEY: found} if found else {}


def left_rmse(simulation: Simulation, direction: str) -> float | None:
    """Residual in rad RMS of a direction (``positive``, ``negative``); None where the file does not say."""
    term = simulation.terms.get("te.fourier")
    stated: Any = term.extra.get(KEY) if term is not None else None
    value = stated.get(direction) if isinstance(stated, dict) else None
    return float(value) if isinstance(value, int | float) and math.isfinite(value) and value > 0 else None
