"""Whether the load torque follows the waves of the transmission error, which shake the load's inertia.

By the simulation it does: the inertia goes with the output's acceleration. A torque sensor with a slow filter, or a
load that a soft coupling carries, shows the inertia where the speed changes and no waves. Whichever the recordings
show is what the load's acceleration is taken from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.errors import RecordingError
from bench.foreign.base import Base
from bench.mismatch.recordings.prepared import Folder, Prepared, prepare
from bench.mismatch.recordings.smoothing import WINDOWS_S, local_quadratic
from bench.recording import Recording
from bench.simulation.frame import FloatArray

ASKED = 16
"""recordings that are asked, spread over the folder"""
FEWEST = 6
"""recordings that show something, below which the simulation is believed"""
LEAST = 0.005
"""share of the squares of the torque that has to be gained without the waves: less matters to nothing"""
ERRORS = 2.0
"""root sums of squares of what single recordings gain, by which all together have to gain: were their signs drawn, one
sum in forty would reach it
"""
_NEEDED = {"motor_angle", "load_angle", "load_torque", "load_motor_torque"}


def folder_of(recordings: Sequence[Recording], base: Base | None = None) -> Folder:
    """What the recordings of a campaign share, in the order in which they began; and whether waves shake the load."""
    folder = Folder.of(recordings, base)
    usable = [r for r in recordings if set(r.specs) >= _NEEDED and r.gearbox.ratio is not None]
    if len(usable) < FEWEST:
        return folder
    spread = np.unique(np.linspace(0.0, len(usable) - 1.0, min(ASKED, len(usable))).round().astype(int))
    shown = [each for each in (_moving(usable[i], folder) for i in spread) if each is not None]
    followed = len(shown) < FEWEST or are_followed(shown)
    return folder if followed else replace(folder, manner=replace(folder.manner, waves=False))


def _moving(recording: Recording, folder: Folder) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Torque beyond what the load motor reports, acceleration of the load and of both shafts together (n,) where a
    recording moves, starts and stops among it: without those an inertia is not told. Each beyond friction and a
    straight line; None where there is too little of it.
    """
    try:
        part = prepare(recording, 0, folder, group=1)
    except RecordingError:
        return None  # who reads the folder says why this one cannot be read
    frame, measured = part.frame, part.measured["load_torque"]
    rows = measured.valid & (frame.direction != 0) & ~part.corner
    if np.count_nonzero(rows) < 2 * _lasting(part):
        return None
    together = local_quadratic(frame.theta, part.sample_rate, WINDOWS_S[-1])[2]
    columns = (measured.samples - frame.load_motor_torque, frame.load_acceleration, together)
    known = np.column_stack([np.ones(frame.size), frame.direction, frame.elapsed])[rows]
    torque, load, shafts = (c[rows] - known @ np.linalg.lstsq(known, c[rows], rcond=None)[0] for c in columns)
    return torque, load, shafts


def _lasting(part: Prepared) -> int:
    """Samples of the window that smooths an acceleration most."""
    return max(1, round(WINDOWS_S[-1] * part.sample_rate))


def are_followed(shown: Sequence[tuple[FloatArray, FloatArray, FloatArray]]) -> bool:
    """Whether an inertia times the load's acceleration, waves in it, follows the torques of some recordings as well as
    one times that of both shafts together. ``shown``: torque, acceleration of the load, of the shafts (n,) of each.
    """
    losses = []
    for number in (1, 2):
        products = np.array([each[number] @ each[0] for each in shown])
        squares = np.array([each[number] @ each[number] for each in shown])
        inertia = max(float(products.sum()), 0.0) / max(float(squares.sum()), 1e-300)
        losses.append(np.array([s @ s for s, _, _ in shown]) - 2.0 * inertia * products + inertia**2 * squares)
    gained = losses[0] - losses[1]
    # recordings that hardly turn, or so slowly that nothing shakes, say nothing and count as nothing
    spread = float(np.sqrt(np.sum(gained**2)))
    return not float(gained.sum()) > max(LEAST * float(losses[0].sum()), ERRORS * spread)
