"""Sensors that do not measure: an encoder that stands, an open thermometer, a torque of the other sign."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.errors import RecordingError
from bench.identification.samples.thermometer import beyond_pt100
from bench.recording import Recording
from bench.simulation.frame import FloatArray

STUCK_RAD = 0.05
"""rad at the output that one encoder turns while the other gives one and the same value: no play is so wide"""
NEARLY_ALL = 0.9
"""of a recording in which an encoder stands: it is not connected"""
WINDOWS = 3
"""of a recording, in which the two torques are compared"""
WINDOW = 256
"""samples"""
FEW = 0.25
"""of the recordings that tell their sign: where more have the other one, it is not known which is right"""
LOADED = 0.2
"""of the largest load of a folder, which a recording has to have that tells its sign: the rest is noise and friction"""
ABOUT_ONE = (0.5, 2.0)
"""load torque over the load motor's torque, in size, of a recording that tells its sign: the rest is friction"""


@dataclass(frozen=True, slots=True)
class Faulty:
    """What a sensor does that does not measure, and at which share of the samples."""

    does: str
    share: float


def stuck(angle: FloatArray, other: FloatArray) -> NDArray[np.bool_]:
    """Samples (n,) at which an encoder's ``angle`` stays at one value while the ``other`` encoder turns, both in rad at
    the output; the first of each such run may be right.
    """
    if angle.size < 2:
        return np.zeros(angle.size, dtype=bool)
    begins = np.flatnonzero(np.append(True, np.diff(angle) != 0.0))
    last = np.append(begins[1:], angle.size) - 1
    moved = np.abs(other[last] - other[begins])
    out = np.repeat(moved > STUCK_RAD, last - begins + 1)
    if float(out.mean()) < NEARLY_ALL:  # else it never says anything
        out[begins] = False
    return out


def nowhere_measured(recordings: Sequence[Recording]) -> bool:
    """Whether the thermometer of a campaign is open or shorted at every sample of each recording: it is not connected.
    Recordings are read up to the first one that says otherwise.
    """
    own = [r for r in recordings if "temperature" in r.specs]
    return bool(own) and all(_open_throughout(r) for r in own)


def _open_throughout(recording: Recording) -> bool:
    try:
        return bool(beyond_pt100(recording.si("temperature")).all())
    except (RecordingError, OSError, ValueError):
        return False  # why it cannot be read is said when it is


def of_other_sign(recordings: Sequence[Recording]) -> list[Recording]:
    """Recordings in which load torque and the load motor's torque go together the other way than in most."""
    read = [(r, together) for r in recordings if (together := _together(r)) is not None]
    largest = max((load for _, (_, load) in read), default=0.0)
    loaded = [(r, ratio) for r, (ratio, load) in read if load >= LOADED * largest]
    signed = [(r, ratio) for r, ratio in loaded if ABOUT_ONE[0] <= abs(ratio) <= ABOUT_ONE[1]]
    if not signed:
        return []
    positive = [ratio > 0.0 for _, ratio in signed]
    most = sum(positive) > 0.5 * len(positive)
    other = [r for (r, _), same in zip(signed, positive, strict=True) if same != most]
    return other if len(other) < FEW * len(signed) else []


def _together(recording: Recording) -> tuple[float, float] | None:
    """Load torque over the load motor's torque, and root mean square of that, N·m; None where one is missing."""
    names = ["load_torque", "load_motor_torque"]
    if not all(name in recording.specs for name in names):
        return None
    begins = np.unique(np.linspace(0, max(recording.size - WINDOW, 0), WINDOWS).astype(int))
    try:
        parts = [recording.read_si(names, int(a), min(int(a) + WINDOW, recording.size)) for a in begins]
    except (RecordingError, OSError, ValueError):
        return None  # why it cannot be read is said when it is
    torque, motor = (np.concatenate([p[name] for p in parts]) for name in names)
    ok = np.isfinite(torque) & np.isfinite(motor)
    squares = float(np.sum(motor[ok] ** 2))
    if squares <= 0.0:
        return None
    return float(np.sum(torque[ok] * motor[ok])) / squares, float(np.sqrt(squares / ok.sum()))
