"""Whether the load torque follows the waves of the transmission error, which shake the load's inertia.

By the simulation it does: the inertia goes with the output's acceleration. A torque sensor with a slow filter, or a
load behind a soft coupling, shows the inertia where the speed changes and no waves; and a coarse encoder shows waves
that are none. With which of two accelerations an inertia follows the torque better is asked of the recordings that may
be fitted, and stands in the simulation file.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.errors import RecordingError
from bench.mismatch.recordings.prepared import Folder, of_both_shafts, prepare, runs_of
from bench.mismatch.recordings.window import spread_over
from bench.recording import Recording
from bench.simulation.frame import FloatArray

ASKED = 16
"""recordings that are asked, spread over the folder"""
FEWEST = 6
"""recordings that show something, below which the simulation is believed"""
LONGEST_S = 300.0
"""of a recording that is asked: what lasts longer warms up or cools down, with few starts"""
LEAST = 0.005
"""share of the squares of the torque that has to be gained without the waves: less matters to nothing"""
ERRORS = 2.0
"""root sums of squares of what single recordings gain, by which all together have to gain: were their signs drawn, one
sum in forty would reach it
"""
NEEDED = {"motor_angle", "load_angle", "load_torque", "load_motor_torque"}
NOTE = (
    "load_torque: it does not follow the waves of the transmission error: the load's inertia is taken with the"
    " acceleration of both shafts together, which a key of load.inertia in the simulation file says"
)


def follows_waves(recordings: Sequence[Recording], folder: Folder) -> bool:
    """Whether an inertia follows the load torque of some recordings of a ``folder`` as well with the acceleration of
    the output, waves in it, as with that of both shafts together. Few recordings do not refute the simulation.
    """
    usable = [
        r
        for r in recordings
        if set(r.specs) >= NEEDED and r.gearbox.ratio is not None and r.size <= LONGEST_S * float(r.sample_rate)
    ]
    if len(usable) < FEWEST:
        return True
    # without a simulation from elsewhere: its result is kept for the acceleration that it is given first
    alone = replace(folder, base=None)
    asked = [_moving(recording, alone) for recording in spread_over(usable, ASKED)]
    shown = [each for each in asked if each is not None]
    return len(shown) < FEWEST or are_followed(shown)


def _moving(recording: Recording, folder: Folder) -> tuple[FloatArray, ...] | None:
    """Torque beyond what the load motor reports, the acceleration of the output and that of both shafts together (n,)
    where a recording moves, starts and stops among it: without those an inertia is not told. Each beyond friction and a
    straight line; None where there is too little of it.
    """
    try:
        part = prepare(recording, 0, folder)
    except RecordingError:
        return None  # who reads the folder says why this one cannot be read
    frame, measured = part.frame, part.measured["load_torque"]
    rows = (measured.number > 0) & (frame.direction != 0) & ~part.corner
    known = np.column_stack([np.ones(frame.size), frame.direction, frame.elapsed])[rows]
    if len(known) <= 2 * known.shape[1]:
        return None
    runs = runs_of(frame.elapsed, part.sample_rate, folder.manner.smoothing, frame.steady, part.label)
    columns = (measured.mean - frame.load_motor_torque, frame.load_acceleration, of_both_shafts(frame.theta, runs))
    return tuple(c[rows] - known @ np.linalg.lstsq(known, c[rows], rcond=None)[0] for c in columns)


def are_followed(shown: Sequence[Sequence[FloatArray]]) -> bool:
    """Whether an inertia times a first acceleration follows the torques of some recordings as well as one times a
    second. ``shown``: torque and the two accelerations (n,) of each.
    """
    losses = []
    for number in (1, 2):
        products = np.array([each[number] @ each[0] for each in shown])
        squares = np.array([each[number] @ each[number] for each in shown])
        inertia = max(float(products.sum()), 0.0) / max(float(squares.sum()), 1e-300)
        losses.append(np.array([each[0] @ each[0] for each in shown]) - 2.0 * inertia * products + inertia**2 * squares)
    gained = losses[0] - losses[1]
    # recordings that hardly turn, or so slowly that nothing shakes, say nothing and count as nothing
    spread = float(np.sqrt(np.sum(gained**2)))
    return not float(gained.sum()) > max(LEAST * float(losses[0].sum()), ERRORS * spread)
