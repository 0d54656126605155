"""Whether a finding's location is the effect's: strict, and never by what the report leaves out.

A range of speed, load or temperature is right where it shares at least half with what is true (intersection over
union). True is the range that holds nine tenths of the excess's energy; or the one the physics acts in, anywhere
between its core and its end; or, for a quantity the effect makes no claim about, all that the recordings cover. A
quantity that is not reported is wrong. Orders: half of those reported are true, and they hold half of the true ones'
energy. Recordings: those reported hold nine tenths of the energy of as many truly strongest ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

LEAST_OVERLAP = 0.5
LEAST_ENERGY = 0.9
_ORDER_TOLERANCE = 0.5
#: Half of this much is added at each end of a range, so that a single level of a quantity has a width (SI units).
_WIDTH = {"velocity": 0.004, "load_torque": 20.0, "temperature": 1.0}
#: Effects that may be reported as a window or as the orders that draw it: functions of the angle of any shape.
_EITHER_WAY = frozenset(("friction.position_dependent",))

Range = tuple[float, float]


def misplaced(concealed: Mapping[str, Any], finding: Mapping[str, Any]) -> list[str]:
    """What is wrong with a finding's location: names of its entries, empty where all is right."""
    if finding.get("channel") not in concealed["channels"]:
        return ["channel"]
    true, reported = concealed["location"], finding.get("location") or {}
    measured, conditions = true.get("measured", {}), reported.get("conditions") or {}
    compared = [name for name in _WIDTH if name in measured or name in true["conditions"]]
    wrong = [name for name in compared if not _range_right(name, true, conditions.get(name))]
    claimed = measured or "direction" in true["conditions"]
    if claimed and not _direction_right(true, conditions.get("direction")):
        wrong.append("direction")
    orders, windows = reported.get("orders") or [], reported.get("angle_windows") or []
    either = concealed["effect"] in _EITHER_WAY
    if not orders_agree(true["orders"], orders, true.get("order_sizes", ())) and not (either and windows):
        wrong.append("orders")
    if not _windows_right(true, windows) and not (either and orders):
        wrong.append("angle_windows")
    if not recordings_right(true.get("recordings", {}), reported.get("recordings") or []):
        wrong.append("recordings")
    return wrong


def overlap(a: Range, b: Range) -> float:
    """Intersection over union of two intervals; 0 where they are apart."""
    union = max(a[1], b[1]) - min(a[0], b[0])
    return max(min(a[1], b[1]) - max(a[0], b[0]), 0.0) / union if union > 0.0 else 1.0


def orders_agree(true: Sequence[float], reported: Sequence[float], sizes: Sequence[float] = ()) -> bool:
    """Half of the reported orders are true, and they hold half of the true ones' energy (of their number without
    sizes).
    """
    if not true:
        return True
    if not reported:
        return False
    near = np.abs(np.subtract.outer(np.asarray(true, float), np.asarray(reported, float))) <= _ORDER_TOLERANCE
    weights = np.square(np.asarray(sizes or [1.0] * len(true), float))
    return bool(np.average(near.any(axis=1), weights=weights) >= 0.5 and near.any(axis=0).mean() >= 0.5)


def recordings_right(true: Mapping[str, float], reported: Sequence[str]) -> bool:
    """The recordings reported hold nine tenths of the energy of as many truly strongest ones; ``true`` is by id."""
    if not true:
        return True
    if not reported:
        return False
    names = dict.fromkeys(str(name).removesuffix(".h5") for name in reported)
    best = sum(sorted(true.values(), reverse=True)[: len(names)])
    return sum(true.get(name, 0.0) for name in names) >= LEAST_ENERGY * best


def _range_right(name: str, true: Mapping[str, Any], answer: Sequence[float] | None) -> bool:
    if answer is None or len(answer) != 2:
        return False
    half = 0.5 * _WIDTH[name]
    low, high = float(answer[0]) - half, float(answer[1]) + half
    accepted = [true["measured"][name]] if name in true.get("measured", {}) else []
    accepted += _between(true, name) if name in true["conditions"] else [true["span"][name]]
    return any(overlap((low, high), (a - half, b + half)) >= LEAST_OVERLAP for a, b in accepted)


def _between(true: Mapping[str, Any], name: str) -> list[Sequence[float]]:
    """Ranges from the core to the end of where the physics acts."""
    outer = true["conditions"][name]
    inner = true.get("core", {}).get(name, outer)
    (a, b), (c, d) = outer, inner
    return [(a + s * (c - a), b + s * (d - b)) for s in np.linspace(0.0, 1.0, 9).tolist()]


def _direction_right(true: Mapping[str, Any], reported: Any) -> bool:
    claim = true["conditions"].get("direction")
    return reported in ({claim} if claim else {"both", true.get("measured_direction")})


def _windows_right(true: Mapping[str, Any], reported: Sequence[Sequence[float]]) -> bool:
    if not true["angle_windows"]:
        return True
    outer, inner = true["angle_windows"], true.get("core_windows") or true["angle_windows"]
    b = _inside(reported)
    for s in np.linspace(0.0, 1.0, 9):
        pairs = zip(outer, inner, strict=True)
        a = _inside([(o[0] + s * (i[0] - o[0]), o[1] + s * (i[1] - o[1])) for o, i in pairs])
        if (a & b).sum() >= LEAST_OVERLAP * (a | b).sum():
            return True
    return False


def _inside(windows: Sequence[Sequence[float]]) -> NDArray[np.bool_]:
    """Which points of a fine grid of the revolution lie in any window (low, high), low to high in the sense of
    rotation.
    """
    grid = np.linspace(0.0, 2.0 * np.pi, 7200, endpoint=False)
    inside = np.zeros(grid.size, dtype=bool)
    for low, high in windows:
        wide = float(high) - float(low)
        inside |= np.mod(grid - low, 2.0 * np.pi) <= (wide if wide >= 0.0 else wide + 2.0 * np.pi)
    return inside
