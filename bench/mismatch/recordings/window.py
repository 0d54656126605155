"""Over how long rates are smoothed, where a motion is nobody's set speed: as the torque asks for.

A long window takes the noise of an acceleration and the acceleration: a rotor that is shaken by its cogging sixty times
a second has none left over 60 ms. A short one leaves noise in it, and a regression takes that for motion. Either way
the torque is followed worse. So the window is the one with which inertia and plain friction leave least of the torque.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.mismatch.recordings.smoothing import WINDOWS_S, local_quadratic, repaired
from bench.recording import Recording
from bench.simulation.frame import FloatArray

SHORT_S = (0.004, 0.008, *WINDOWS_S)
"""lengths of the window that are asked, the shortest first"""
MOST_RECORDINGS = 6
"""recordings that are asked, spread over the folder"""
AS_GOOD = 1.02
"""what a longer window may leave, over the least: the noise in a rate falls with the power 2.5 of its window"""


def telling_span(recordings: Sequence[Recording], standstill: float) -> float | None:
    """Window in s with which inertia and friction leave least of the motor torque; None where that cannot be told.

    ``standstill``: speed in rad/s (a linear axis: m/s) below which the direction of motion is not told.
    """
    asked = [r for r in recordings if {"motor_angle", "motor_torque"} <= set(r.specs) and r.size > 1]
    chosen = asked[:: max(1, -(-len(asked) // MOST_RECORDINGS))]
    if not chosen:
        return None
    left = {span: _left([_columns(r, span, standstill) for r in chosen]) for span in SHORT_S}
    least = min(left.values())
    if not np.isfinite(least) or least <= 0.0:
        return None
    return max(span for span, own in left.items() if own <= AS_GOOD * least)


def _columns(recording: Recording, span: float, standstill: float) -> FloatArray:
    """Samples of a recording (n, k): direction, speed, acceleration, one, load where there is one; last the torque."""
    names = [n for n in ("motor_angle", "motor_torque", "load_torque") if n in recording.specs]
    signals = {n: repaired(own, ~np.isfinite(own)) for n, own in recording.read_si(names).items()}
    _, speed, acceleration = local_quadratic(signals["motor_angle"], float(recording.sample_rate), span)
    direction = np.where(np.abs(speed) > standstill, np.sign(speed), 0.0)
    load = signals.get("load_torque", np.zeros(speed.size))
    return np.column_stack([direction, speed, acceleration, np.ones(speed.size), load, signals["motor_torque"]])


def _left(parts: Sequence[FloatArray]) -> float:
    """Root mean square of what least squares leave of the last column."""
    data = np.vstack(parts)
    scale = np.maximum(np.sqrt(np.mean(data**2, axis=0)), 1e-300)
    x, y = data[:, :-1] / scale[:-1], data[:, -1]
    return float(np.sqrt(np.mean((y - x @ np.linalg.lstsq(x, y, rcond=1e-9)[0]) ** 2)))
