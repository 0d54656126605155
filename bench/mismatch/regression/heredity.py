"""A change of a law is reported beside the law: Stribeck friction beside Coulomb friction, churning beside viscous one.

A model that has a law's change and not the law itself is no simpler than one that has the law (marginality: Nelder,
J. R. Stat. Soc. A 140 (1977) 48; heredity: Chipman, Can. J. Stat. 24 (1996) 17). A table holds laws as well: one over
anything times the direction of motion holds Coulomb friction. This is said of laws that the simulation is known to
lack: one from elsewhere may have them under another name.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from bench.mismatch.regression.model import Chosen
from bench.mismatch.regression.regressors import Free, Named, Regressor
from bench.simulation.frame import Frame
from bench.simulation.quantities import AUXILIARY
from bench.simulation.tables import Grid
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE

_ALIVE = 1e-6
"""size of a direction of a table's values, over the table's, below which it is none"""

_HELD: dict[tuple[str, str], str] = {
    (MOTOR_TORQUE, "1"): "motor.torque_offset",
    (MOTOR_TORQUE, "d"): "friction.coulomb",
    (MOTOR_TORQUE, "w"): "friction.viscous",
    (MOTOR_TORQUE, "d*abs_tau"): "friction.load_dependent",
    (LOAD_TORQUE, "1"): "load.torque_offset",
    (LOAD_TORQUE, "d"): "load.bearing_friction",
}
"""law that a table times a factor holds: all of its values alike"""
_OF_INERTIA = f"{AUXILIARY}momentum("
"""begins the name of what an inertia that changes gives: where the angles hardly change, inertia"""
_NEAR: dict[tuple[str, str, str], tuple[str, ...]] = {
    (MOTOR_TORQUE, "velocity", "1"): ("friction.viscous", "friction.coulomb"),
    (MOTOR_TORQUE, "speed", "d"): ("friction.viscous",),
    (MOTOR_TORQUE, "speeding_up", "d"): ("motor.inertia",),
    (LOAD_TORQUE, "speeding_up", "d"): ("load.inertia",),
}
"""laws that a table of a quantity times a factor holds, or comes near: its values on a straight line, or a step"""


def laws(regressor: Regressor) -> tuple[str, ...]:
    """Laws that a regressor is a change of, or holds."""
    if isinstance(regressor, Named):
        return regressor.term.modifies
    if not isinstance(regressor, Free):
        return ()
    found = [law for grid in regressor.grids for law in _held(regressor.channel, grid)]
    return tuple(dict.fromkeys(found))


def _held(channel: str, grid: Grid) -> list[str]:
    if not grid.over or grid.size == 1:
        return []
    found = [_HELD.get((channel, grid.times))]
    if any(name.startswith(_OF_INERTIA) for name in grid.over):
        found.append("motor.inertia")
    found += [law for name in grid.over for law in _NEAR.get((channel, name, grid.times), ())]
    return [law for law in found if law is not None]


def without_laws(free: Free, frame: Frame) -> Free:
    """A free function that says nothing of what laws say, over the rows of a frame.

    What of a table is a law, or comes near one, is said by the law: its coefficient is then that of the recordings,
    whatever else the table follows.
    """
    found = laws(free)
    if not found:
        return free
    columns = np.hstack([LIBRARY[law].forms[free.channel][0].columns(frame, ()) for law in found])
    table = free.columns(frame)
    size = max(float(np.sqrt(np.sum(table**2))), 1e-300)
    unit = columns / np.maximum(np.sqrt(np.sum(columns**2, axis=0)), 1e-300)
    _, sizes, directions = np.linalg.svd(unit.T @ table)
    left = directions[int(np.sum(sizes > _ALIVE * size)) :].T
    if not left.size:
        return free
    _, sizes, directions = np.linalg.svd(table @ left, full_matrices=False)
    mixing = left @ directions[sizes > _ALIVE * size].T
    return replace(free, mixing=tuple(tuple(float(v) for v in row) for row in mixing)) if mixing.size else free


def orphaned(regressor: Regressor, beside: Collection[str], lacking: Collection[str]) -> bool:
    """Whether a regressor is a change of a law that is neither in the simulation nor among effects ``beside`` it."""
    return any(law in lacking and law not in beside for law in laws(regressor))


def without(chosen: Sequence[Chosen], one: Chosen, lacking: Collection[str]) -> list[Chosen]:
    """Effects without one of them, and without the names that are changes of it."""
    left = [c for c in chosen if c is not one]
    effects = {c.effect for c in left}
    return [
        c for c in left if one.effect not in laws(c.main.regressor) or not orphaned(c.main.regressor, effects, lacking)
    ]
