"""Whose the orders of the motor's shaft are in the transmission error: its encoder's, or the gearbox's.

What the encoder misreads has derivatives as well, which are no motion of the rotor: taken off, the inertia follows the
motor's torque better. What the gearbox makes stands in the output alone: taken off the motor's motion, it would put an
acceleration there that no torque made. A drive whose loop follows its encoder makes no difference: then the rotor moves
by what was misread, and the torque shows it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm, t

from bench.mismatch import criteria
from bench.mismatch.discovery import NAMED, Discovery
from bench.mismatch.orders.misread import ENCODER, HARMONIC
from bench.mismatch.problems import usable
from bench.mismatch.read_motion import without_misread_motion
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.recordings.read_again import finely
from bench.mismatch.recordings.rows import error_of_mean
from bench.mismatch.recordings.window import spread_over
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.terms import LIBRARY, MOTOR_TORQUE
from bench.simulation.waves import Wave, from_json

MOST = 12
"""recordings that are asked, spread over those that may be fitted"""
FEWEST_ROWS = 50
"""of a recording that is asked"""
STEP_S = 0.004
"""of a row, in which what an encoder misreads is not averaged out"""


def waves_of(found: Discovery) -> list[Wave]:
    """The waves of a discovery of orders."""
    return [w for row in found.simulation_rows for w in from_json(row.get("waves", ()), found.effect)]


def told(found: Discovery, data: Dataset, decided: Collection[float] = ()) -> Discovery:
    """A discovery that may be an error of the motor's encoder, under the name that the motor's torque gives it; as it
    is where that says nothing, and where the load's reaction has ``decided`` of one of its orders.
    """
    names = {found.effect, *(a.effect for a in found.alternatives if a.as_good)}
    if ENCODER not in names or not names <= {ENCODER, HARMONIC} or MOTOR_TORQUE not in data.rows:
        return found
    waves = waves_of(found)
    orders = {w.order for w in waves}
    # an order that is not told by one vector has no one motion that was misread
    if not orders or orders != set(found.orders) or orders & set(decided):
        return found
    gain = gained(waves, data)
    if gain is None:
        return found
    # as sure as so many standard errors make a normal number, of so few recordings
    chance = 2.0 * float(t.sf(abs(gain.better) / max(gain.error, 1e-300), gain.recordings - 1))
    if chance > 2.0 * float(norm.sf(criteria.BESIDE_UNKNOWN_ERRORS)):
        return found
    effect = ENCODER if gain.better > 0.0 else HARMONIC
    followed = f"is followed {'better' if effect == ENCODER else 'worse'} without their derivatives in its motion"
    return replace(
        found,
        effect=effect,
        status=NAMED,
        confidence=None if found.confidence is None else found.confidence * (1.0 - chance),
        words=f"{LIBRARY[effect].name}: the torque of the motor {followed}",
        alternatives=tuple(a for a in found.alternatives if a.effect not in (ENCODER, HARMONIC)),
        simulation_rows=tuple({**row, "effect": effect} for row in found.simulation_rows),
    )


@dataclass(frozen=True, slots=True)
class Gained:
    """By how much ``better`` the motor torque is followed, in mean squares, and the standard ``error`` of that from one
    of the ``recordings`` to another.
    """

    better: float
    error: float
    recordings: int


def gained(waves: Sequence[Wave], data: Dataset) -> Gained | None:
    """By how much less of the motor torque is left where the derivatives of ``waves`` of the transmission error are
    taken off the motor's motion; None where fewer than two recordings tell.

    Cogging, or friction once a turn, stands at the same orders and keeps its size at all speeds: waves of the torque
    at these orders are fitted on both sides, so that only what goes with the square of the speed decides.
    """
    fitted = [k for k, fold in enumerate(data.folds()) if fold >= 0]
    chosen = spread_over(fitted, MOST)
    parts: list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]] = []
    slowest = min((float(data.parts[k].recording.sample_rate) for k in chosen), default=1.0)
    orders = [w.order for w in waves]
    for _, rows in finely(data, MOTOR_TORQUE, chosen, max(STEP_S, 1.0 / slowest)):
        some = rows.take(np.flatnonzero(usable(MOTOR_TORQUE, rows)))
        if some.size < FEWEST_ROWS:
            continue
        moved = without_misread_motion(some.frame, waves, data.folder.manner.smoothing)
        parts.append((_columns(some.frame, orders), _columns(moved, orders), some.y, some.number))
    if len(parts) < 2:
        return None
    y, number = np.concatenate([p[2] for p in parts]), np.concatenate([p[3] for p in parts])
    recording = np.concatenate([np.full(p[2].size, k) for k, p in enumerate(parts)])
    squares = [_left(np.vstack([p[side] for p in parts]), y, number) ** 2 for side in (0, 1)]
    change = squares[0] - squares[1]
    error = error_of_mean(change, recording, number)
    return None if error is None else Gained(float(np.average(change, weights=number)), error, len(parts))


def _columns(frame: Frame, orders: Sequence[float]) -> FloatArray:
    """What the motor torque mostly consists of (n, k): friction, inertia, the load, gravity, a zero; and what it has at
    some orders at any speed, the same in both directions or not.
    """
    angles = [f * frame.theta for f in orders]
    waves = [w for angle in angles for w in (np.cos(angle), np.sin(angle))]
    return np.column_stack(
        [
            frame.direction,
            frame.omega,
            frame.acceleration,
            frame.torque / frame.ratio,
            frame.direction * np.abs(frame.torque) / frame.ratio,
            np.sin(frame.q),
            np.cos(frame.q),
            np.ones(frame.size),
            *waves,
            *(frame.direction * w for w in waves),
        ]
    )


def _left(columns: FloatArray, y: FloatArray, number: FloatArray) -> FloatArray:
    """What least squares leave of ``y`` (n,)."""
    root = np.sqrt(number)
    scale = np.maximum(np.linalg.norm(columns * root[:, None], axis=0), 1e-300)
    x = columns / scale
    return np.asarray(y - x @ np.linalg.lstsq(x * root[:, None], y * root, rcond=1e-9)[0])
