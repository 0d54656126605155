"""Range of load torques that a series was fitted to, as it stands beside it in a simulation file.

The key ``torques`` of ``te.fourier`` has by direction the least and the greatest mean torque of a recording, N·m. A
gearbox's stiffness depends on its load, so the mean slope over one range is not that over another.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bench.identification.series.refined import RefinedDirection
from bench.simulation import Simulation

KEY = "torques"
SAME_ENDS = 0.1
"""share of the wider of two ranges by which their ends may differ: setpoints that are kept to a few percent"""


def loads_entry(refined: Mapping[str, RefinedDirection]) -> dict[str, dict[str, list[float]]]:
    """Return what the series' term says of it; nothing where no direction was fitted."""
    found = {}
    for direction, result in refined.items():
        torque = result.design.inputs[:, 0]
        found[direction] = [round(float(torque.min()), 3), round(float(torque.max()), 3)]
    return {KEY: found} if found else {}


def torque_range(simulation: Simulation, direction: str) -> tuple[float, float] | None:
    """Least and greatest load torque in N·m of a direction; None where the file does not say."""
    term = simulation.terms.get("te.fourier")
    stated: Any = term.extra.get(KEY) if term is not None else None
    pair = stated.get(direction) if isinstance(stated, dict) else None
    if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(end, int | float) for end in pair):
        return None
    return float(pair[0]), float(pair[1])


def same_loads(first: Simulation, second: Simulation, direction: str) -> bool:
    """Whether both series were fitted over one range of torques; False where a file does not say."""
    a, b = torque_range(first, direction), torque_range(second, direction)
    if a is None or b is None:
        return False
    allowed = SAME_ENDS * max(a[1] - a[0], b[1] - b[0])
    return abs(a[0] - b[0]) <= allowed and abs(a[1] - b[1]) <= allowed
