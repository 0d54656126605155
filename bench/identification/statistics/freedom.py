"""Degrees of freedom of standard deviations, as they stand beside the terms of a simulation file.

A standard deviation that rests on few recordings is itself uncertain: differences over it follow Student's t. The key
``freedom`` of a term says with how many degrees: by symbol for parameters, by direction for the series. A file without
it counts as having infinitely many.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from bench.simulation import Simulation, Term

KEY = "freedom"


def _degrees(term: Term | None, name: str) -> float:
    stated: Any = term.extra.get(KEY) if term is not None else None
    value = stated.get(name) if isinstance(stated, dict) else None
    return float(value) if isinstance(value, int | float) and value > 0 else math.inf


def parameter_freedom(term: Term | None, symbol: str) -> float:
    """Degrees of freedom of a parameter's standard deviation; infinite where the file says nothing."""
    return _degrees(term, symbol)


def series_freedom(simulation: Simulation, direction: str) -> float:
    """Degrees of freedom of the standard deviations of ``te.fourier`` in a direction; infinite where not said."""
    return _degrees(simulation.terms.get("te.fourier"), direction)


def freedom_entry(freedom: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Return what a term says of its degrees of freedom: finite ones only, nothing where there are none."""
    finite = {name: round(value, 2) for name, value in freedom.items() if math.isfinite(value)}
    return {KEY: finite} if finite else {}
