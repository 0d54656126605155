"""Where an effect is: in which ranges and in which recordings the energy of its excess lies.

The excess is what no setting of the nominal simulation absorbs (:mod:`fakes.concealed.strength`). A location is the
smallest range of a quantity that holds nine tenths of that energy, as the report's page defines it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fakes.concealed.effects.base import Floats
from fakes.concealed.strength import STATES, Excess
from fakes.concealed.truth import Location

_SHARE = 0.9
_ONE_WAY = 0.95  # energy in one direction that makes it the direction


def measured_location(location: Location, excess: Excess, named: Callable[[int], str]) -> Location:
    """A location with what is measured of it: ranges, span, direction, energy of each recording.

    ``excess`` is that of the effect alone, at its final strength; ``named`` gives a recording's id
    by its number in the excess.
    """
    energy = excess.weight * excess.values**2
    total = float(energy.sum())
    if total <= 0.0:
        return location
    quantities = {name: excess.states[:, at] for at, name in enumerate(STATES[:3])}
    forward = float(energy[excess.states[:, 3] > 0.0].sum()) / total
    direction = "positive" if forward > _ONE_WAY else "negative" if forward < 1.0 - _ONE_WAY else "both"
    numbers = np.bincount(excess.recording, weights=energy)
    return replace(
        location,
        measured={name: smallest_range(values, energy) for name, values in quantities.items()},
        span={name: (float(values.min()), float(values.max())) for name, values in quantities.items()},
        measured_direction=direction,
        recordings={named(i): float(e) for i, e in enumerate(numbers) if e > 0.0},
    )


def smallest_range(values: Floats, energy: Floats, share: float = _SHARE) -> tuple[float, float]:
    """The shortest interval of ``values`` (M,) that holds ``share`` of the energy (M,)."""
    order = np.argsort(values, kind="stable")
    x, sums = values[order], np.concatenate(([0.0], np.cumsum(energy[order])))
    stops = np.searchsorted(sums, sums[:-1] + share * sums[-1] - 1e-12 * sums[-1])
    starts = np.flatnonzero(stops <= x.size)
    widths = x[stops[starts] - 1] - x[starts]
    best = starts[int(np.argmin(widths))]
    return float(x[best]), float(x[stops[best] - 1])
