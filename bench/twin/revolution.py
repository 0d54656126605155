"""What a model says of the transmission error over one revolution at the conditions of now, and its band.

The band is where 95 % of a revolution should lie: standard deviations of the model's coefficients (their covariance,
with the Student factor of its degrees of freedom) and what the model left of the recordings it was fitted to, as
independent parts. Where either is not in the file there is no band.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm, t

from bench.identification.left import left_rmse
from bench.identification.statistics.freedom import series_freedom
from bench.mismatch.given import Given
from bench.mismatch.prediction import Predictor
from bench.simulation.fourier import FourierSet
from bench.simulation.frame import ARRAYS, FloatArray, Frame
from bench.simulation.model import Simulation
from bench.simulation.polynomial import TERM_COUNT, basis
from bench.simulation.terms import TRANSMISSION_ERROR

INSIDE = 0.95
"""share of a revolution that should lie in the band"""
_STEADY = {
    "count": 1.0,
    "steady": 1.0,
    "step": 0.0,
    "acceleration": 0.0,
    "load_acceleration": 0.0,
    "torque_rate": 0.0,
    "kept": 0.0,
    "followed": 1.0,
}


@dataclass(frozen=True, slots=True)
class Conditions:
    """Steady motion: ``torque`` in N·m, ``velocity`` of the load side in rad/s, ``temperature`` in °C.

    ``also``: further quantities of a :class:`~bench.simulation.frame.Frame` by name, where they are known; a model
    that needs one that is not there says nothing.
    """

    torque: float
    velocity: float
    temperature: float
    also: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Revolution:
    """``error`` (n,) without its mean and ``half`` (n,) of the band, rad; None where there is none, and ``why``."""

    error: FloatArray | None
    half: FloatArray | None
    why: str
    left: float | None = None
    """what the model left of the recordings it was fitted to, rad RMS"""


class RevolutionModel:
    """The transmission error of a simulation file. Raises ConfigurationError where the file is wrong."""

    def __init__(self, path: Path) -> None:
        self._simulation = Simulation.load(path)
        self._given = Given.of(self._simulation)
        self._predictor = Predictor(self._given)

    def at(self, conditions: Conditions, bins: int) -> Revolution:
        """The revolution at conditions, at the middles of ``bins`` parts of the input angle."""
        if self._simulation.extra.get("base") is not None:
            return Revolution(None, None, "the model stands on a simulation from elsewhere")
        frame = frame_of(conditions, float(self._simulation.gearbox.ratio), bins)
        lacking = self._predictor.missing(TRANSMISSION_ERROR, frame)
        if lacking:
            return Revolution(None, None, f"the model has no numbers for {', '.join(lacking)}")
        model = self._simulation.transmission_error()
        series = None if model is None else model.direction(conditions.velocity)
        if model is not None and series is None:
            return Revolution(None, None, "the model was never fitted in this direction of motion")
        error = self._predictor.channel(TRANSMISSION_ERROR, frame)
        if not np.isfinite(error).all():
            return Revolution(None, None, "the model needs a condition that is not known here")
        error = error - error.mean()
        return self._with_band(error, series, conditions)

    def _with_band(self, error: FloatArray, series: FourierSet | None, conditions: Conditions) -> Revolution:
        way = "positive" if conditions.velocity >= 0.0 else "negative"
        others = self._other_effects()
        left = left_rmse(self._simulation, way)
        if series is None or series.covariance is None:
            return Revolution(error, None, "the model's file has no covariance of its series", left)
        if others:
            return Revolution(error, None, f"the model's file has no covariance of {', '.join(others)}", left)
        if left is None:
            why = f"the model's file does not say what was left of the recordings it was fitted to ({way} direction)"
            return Revolution(error, None, why)
        freedom = series_freedom(self._simulation, way)
        two_sided = 0.5 * (1.0 + INSIDE)
        student = float(t.ppf(two_sided, freedom)) if np.isfinite(freedom) else float(norm.ppf(two_sided))
        series_variance = student**2 * variance(series, conditions, error.size)
        return Revolution(error, np.sqrt(series_variance + (float(norm.ppf(two_sided)) * left) ** 2), "", left)

    def _other_effects(self) -> list[str]:
        """Ids of what acts on the transmission error beside series and offset."""
        given = self._given
        names = [known.regressor.effect for known in given.known.get(TRANSMISSION_ERROR, ())]
        names += ["waves"] * bool(given.waves.get(TRANSMISSION_ERROR)) + ["te.local_defect"] * bool(given.pulses)
        return list(dict.fromkeys([*names, *(law.effect for law in given.laws)]))


def frame_of(conditions: Conditions, ratio: float, bins: int) -> Frame:
    """One revolution of steady motion, a row a part of the input angle; what is not known is NaN."""
    sign = 1.0 if conditions.velocity >= 0.0 else -1.0
    theta = (np.arange(bins) + 0.5) * (2.0 * np.pi / bins)
    known: dict[str, float] = {**_STEADY, **conditions.also, "velocity": conditions.velocity}
    known |= {"torque": conditions.torque, "torque_level": conditions.torque, "temperature": conditions.temperature}
    known |= {"direction": sign, "last_direction": sign}
    known["load_motor_level"] = known.get("load_motor_torque", np.nan)
    motor = known.get("motor_torque", np.nan)
    known["power"] = abs((motor * ratio - conditions.torque) * conditions.velocity)
    columns: dict[str, Any] = {name: np.full(bins, known.get(name, np.nan)) for name in ARRAYS if name != "recording"}
    columns["theta"] = columns["q"] = theta
    return Frame(ratio=ratio, recording=np.zeros(bins, dtype=np.int64), **columns)


def variance(series: FourierSet, conditions: Conditions, bins: int) -> FloatArray:
    """Variance (bins,) in rad² of a series at conditions, from the covariance of each order's amplitude and phase."""
    assert series.covariance is not None
    x = basis(conditions.torque, conditions.velocity, conditions.temperature)
    theta = (np.arange(bins) + 0.5) * (2.0 * np.pi / bins)
    amplitude, phase = series.amplitude @ x, series.phase @ x
    out = np.zeros(bins)
    for k, order in enumerate(series.orders):
        joint = series.covariance[k]
        amplitude_part, cross_part = joint[:TERM_COUNT, :TERM_COUNT], joint[:TERM_COUNT, TERM_COUNT:]
        phase_part = joint[TERM_COUNT:, TERM_COUNT:]
        sine, cosine = np.sin(order * theta + phase[k]), amplitude[k] * np.cos(order * theta + phase[k])
        out += (
            sine**2 * (x @ amplitude_part @ x)
            + 2.0 * sine * cosine * (x @ cross_part @ x)
            + cosine**2 * (x @ phase_part @ x)
        )
    return np.asarray(np.maximum(out, 0.0))
