"""The expert's regression: least squares of the set's formulas on the samples that may be fitted, no more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from bench.proof.real.formula import evaluate
from bench.proof.real.sets import AUXILIARY, Expert
from bench.recording import Recording
from bench.simulation.frame import FloatArray


@dataclass(frozen=True, slots=True)
class Stretch:
    """Samples of a recording: ``rows`` (n,) those that count, of all its samples; ``measured`` of the channel."""

    recording: Recording
    rows: NDArray[np.int64]
    measured: FloatArray


@dataclass(frozen=True, slots=True)
class Regression:
    """Values (k,) of the terms with plain standard deviations, and the RMSE of the samples held out."""

    values: FloatArray
    std: FloatArray
    in_sample: float
    held_out: float


def quantities(recording: Recording, expert: Expert) -> dict[str, FloatArray]:
    """What formulas may name: ``t``, ``q``, ``v``, ``a`` of the motor, other channels by their names, auxiliary ones
    by theirs with a rate ``d_NAME``.
    """
    rate = float(recording.sample_rate)
    out = {"t": recording.si("time") - recording.si("time")[0]}
    for name in recording.channels:
        if name != "time":
            out[name.removeprefix(AUXILIARY)] = recording.si(name)
    angle = out.pop("motor_angle")
    out["q"] = angle
    if "motor_velocity" in out:
        out["v"] = out.pop("motor_velocity")
    else:
        out["v"] = _rate(angle, rate, expert.derivative_hz)
    out["a"] = _rate(out["v"], rate, expert.derivative_hz)
    for name in recording.channels:
        if name.startswith(AUXILIARY):
            plain = name.removeprefix(AUXILIARY)
            out[f"d_{plain}"] = _rate(out[plain], rate, expert.derivative_hz)
    return out


def _rate(signal: FloatArray, rate: float, cut: float) -> FloatArray:
    """Derivative of a signal filtered without delay."""
    if cut >= 0.45 * rate:
        return np.gradient(signal) * rate
    sos = butter(4, cut, fs=rate, output="sos")
    # three periods of the corner carry the ends over; a shorter signal has no more to give
    pad = min(signal.size - 1, round(3.0 * rate / cut))
    return np.gradient(np.asarray(sosfiltfilt(sos, signal, padlen=pad))) * rate


def regress(expert: Expert, train: Sequence[Stretch], held: Sequence[Stretch]) -> Regression:
    """Fit the terms on ``train`` and score them on ``held``."""
    x, y = _stacked(expert, train)
    scale = np.sqrt(np.mean(x**2, axis=0))
    scale[scale == 0.0] = 1.0
    values = np.linalg.lstsq(x / scale, y, rcond=None)[0] / scale
    left = y - x @ values
    variance = float(left @ left) / max(y.size - values.size, 1)
    covariance = variance * np.linalg.pinv((x / scale).T @ (x / scale)) / np.outer(scale, scale)
    others, target = _stacked(expert, held)
    rmse = float(np.sqrt(np.mean((target - others @ values) ** 2)))
    return Regression(values, np.sqrt(np.diag(covariance)), float(np.sqrt(np.mean(left**2))), rmse)


def _stacked(expert: Expert, stretches: Sequence[Stretch]) -> tuple[FloatArray, FloatArray]:
    columns: list[FloatArray] = []
    known: dict[int, FloatArray] = {}
    for stretch in stretches:
        key = id(stretch.recording)
        if key not in known:  # pieces of one recording share its rates
            found = quantities(stretch.recording, expert)
            known[key] = np.column_stack([evaluate(term.column, found) for term in expert.terms])
        columns.append(known[key][stretch.rows])
    return np.vstack(columns), np.concatenate([stretch.measured for stretch in stretches])
