"""Recordings as the arrays that the examiner of plants takes: every so many bus cycles, SI units."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from bench.proof.recompute import steady
from bench.recording import Recording, RecordingFolder

CHANNELS = ("load_angle", "load_torque", "load_motor_torque", "motor_torque", "temperature")
_WITHIN_S = 0.05
"""time over which a rate is taken, and the load motor's torque is averaged: its steps of resolution are no noise of the
channel that is predicted from it"""


def samples_of(folder: Path, every: int) -> list[dict[str, Any]]:
    """Every ``every``-th bus cycle of each recording of a folder, in their order."""
    return [_samples(recording, every) for recording in _recordings(folder)]


def _recordings(folder: Path) -> Sequence[Recording]:
    return RecordingFolder.open(folder).recordings


def _samples(recording: Recording, every: int) -> dict[str, Any]:
    cycle = np.asarray(recording.si("cycle")).astype(np.int64)
    picked = np.flatnonzero(cycle % every == 0)
    time = np.asarray(recording.si("time"))
    ratio = float(recording.gearbox.ratio or 1.0)
    theta = np.asarray(recording.si("motor_angle")) / ratio
    half_width = max(round(_WITHIN_S * recording.sample_rate / 2.0), 1)
    width = max(round(_WITHIN_S * recording.sample_rate), 1)
    before, after = np.maximum(picked - half_width, 0), np.minimum(picked + half_width, cycle.size - 1)
    rate = (theta[after] - theta[before]) / (time[after] - time[before])
    # at rest the last direction holds; before any motion it is positive
    signs = np.where(np.abs(rate) * ratio > 0.5, np.sign(rate), 0.0)
    last = np.maximum.accumulate(np.where(signs != 0.0, np.arange(signs.size), -1))
    return {
        "id": recording.recording_id,
        "cycle": cycle[picked],
        "steady": steady(recording)[picked],
        "step_s": every / recording.sample_rate,
        "ratio": ratio,
        "theta": theta[picked],
        "rate": rate,
        "torque": np.asarray(recording.si("load_torque"))[picked],
        "side": np.where(last >= 0, signs[last], 1.0),
        **{name: np.asarray(recording.si(name))[picked] for name in CHANNELS},
        "load_motor_torque": uniform_filter1d(np.asarray(recording.si("load_motor_torque")), width)[picked],
    }
