"""Heat balance C·dT/dt = |τ_m·ω_m − τ·q̇| − (T − T_amb)/R (bench-physics, equation 3), by output error.

Zeros of the two torques that are known are taken off first: a torque that is the same in both directions does not heat.

For a given time constant RC the temperature of a recording is linear in its start T_0, in T_amb and in 1/C:

    T(t) = T_0·e + T_amb·(1 − e) + (1/C)·∫ P(s)·exp(−(t − s)/RC) ds,   e = exp(−t/RC)

so one search over RC (variable projection) and a linear fit with a free T_0 a recording remain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from bench.identification.reduction import Reduction

FloatArray = NDArray[np.float64]

STEP_S = 2.0
MIN_CHANGE_K = 2.0
"""Temperature must move at least this far in some recording: a terminal may resolve 0.1 K, and over less than
some twenty steps the rounding passes for a curvature."""
HEAT_UNITS = {"C": "J/K", "R": "K/W", "T_amb": "degC"}


@dataclass(frozen=True, slots=True)
class HeatFit:
    """Values and standard deviations of C J/K, R K/W and T_amb °C, as far as determined; RMSE in K."""

    values: dict[str, float]
    std: dict[str, float]
    rmse: float
    sentences: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Series:
    time: FloatArray
    power: FloatArray
    temperature: FloatArray


@njit(cache=True)
def _response(time: FloatArray, power: FloatArray, tau: float) -> FloatArray:
    """∫ P(s)·exp(−(t − s)/τ) ds for power held over each step."""
    out = np.zeros(time.size)
    for n in range(1, time.size):
        decay = np.exp(-(time[n] - time[n - 1]) / tau)
        out[n] = out[n - 1] * decay + 0.5 * (power[n] + power[n - 1]) * tau * (1.0 - decay)
    return out


def _series(r: Reduction, torque_zero: float, motor_zero: float) -> _Series | None:
    b = r.blocks
    input_power = (b.motor_torque - motor_zero) * b.motor_velocity
    power = np.abs(input_power - (b.load_torque - torque_zero) * b.load_velocity)
    if b.size < 4 or not (np.isfinite(power).all() and np.isfinite(b.temperature).all()):
        return None
    step = float(np.median(np.diff(b.time)))
    width = max(1, round(STEP_S / step)) if b.size * step > 4 * STEP_S else 1
    count = b.size // width

    def mean(x: FloatArray) -> FloatArray:
        return np.asarray(x[: count * width].reshape(count, width).mean(axis=1))

    return _Series(mean(b.time), mean(power), mean(b.temperature)) if count >= 3 else None


def _design(series: Sequence[_Series], tau: float) -> tuple[FloatArray, FloatArray]:
    """Columns [T_amb, 1/C] and temperatures with each recording's own T_0 projected out."""
    columns, targets = [], []
    for s in series:
        decay = np.exp(-(s.time - s.time[0]) / tau)
        unit = decay / np.linalg.norm(decay)
        x = np.column_stack([1.0 - decay, _response(s.time, s.power, tau)])
        columns.append(x - unit[:, None] * (unit @ x))
        targets.append(s.temperature - unit * (unit @ s.temperature))
    return np.concatenate(columns), np.concatenate(targets)


def _linear(series: Sequence[_Series], tau: float) -> tuple[FloatArray, float]:
    x, y = _design(series, tau)
    scale = np.linalg.norm(x, axis=0) + 1e-300
    solution = np.linalg.lstsq(x / scale, y, rcond=None)[0] / scale
    return solution, float(((y - x @ solution) ** 2).sum())


def identify_heat(reductions: Sequence[Reduction], torque_zero: float = 0.0, motor_zero: float = 0.0) -> HeatFit:
    """Fit the heat balance to all recordings that measured power and temperature; says what they do not determine.

    ``torque_zero`` and ``motor_zero`` are z_0 and τ_0 in N·m, as identified.
    """
    series = [s for r in reductions if (s := _series(r, torque_zero, motor_zero)) is not None]
    if not series:
        return HeatFit({}, {}, float("nan"), ("The heat balance is not identified: temperature or power is missing.",))
    span = max(float(np.ptp(s.temperature)) for s in series)
    if span < MIN_CHANGE_K:
        why = f"the lubricant warms or cools by {span:.2g} K at most within a recording, {MIN_CHANGE_K:g} K are needed"
        return HeatFit({}, {}, float("nan"), (f"C, R and T_amb (heat balance) are not determined: {why}.",))
    found = minimize_scalar(
        lambda log_tau: _linear(series, float(np.exp(log_tau)))[1],
        bounds=(np.log(60.0), np.log(1e6)),
        method="bounded",
        options={"xatol": 1e-4},
    )
    tau = float(np.exp(found.x))
    (ambient, inverse), cost = _linear(series, tau)
    if inverse <= 0:
        return HeatFit({}, {}, float("nan"), ("The heat balance is not identified: warming follows no power.",))
    capacity = 1.0 / inverse
    values = {"C": float(capacity), "R": float(tau / capacity), "T_amb": float(ambient)}
    std = _deviations(series, tau, np.array([ambient, inverse]))
    rows = sum(s.time.size for s in series)
    said = []
    for symbol, limit, what in (
        ("C", 0.5 * capacity, "heating with known power"),
        ("R", 0.5 * values["R"], "cooling, or heating up to a steady temperature"),
        ("T_amb", 10.0, "cooling towards the surroundings"),
    ):
        if not np.isfinite(std[symbol]) or std[symbol] > limit:
            said.append(f"{symbol} (heat balance) is not determined: it takes {what}.")
            del values[symbol], std[symbol]
    return HeatFit(values, std, float(np.sqrt(cost / rows)), tuple(said))


def _deviations(series: Sequence[_Series], tau: float, solution: FloatArray) -> dict[str, float]:
    """Standard deviations clustered by recording, of C, R and T_amb by the delta method."""
    log_step = 1e-4
    upper, lower = _design(series, tau * np.exp(log_step))[0], _design(series, tau * np.exp(-log_step))[0]
    x, y = _design(series, tau)
    jacobian = np.column_stack([x, (upper - lower) @ solution / (2.0 * log_step)])
    residual = y - x @ solution
    scale = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / scale
    inverse = np.linalg.pinv(scaled.T @ scaled, rcond=1e-10)
    edges = np.cumsum([0, *(s.time.size for s in series)])
    if len(series) < 4:
        edges = np.linspace(0, residual.size, 13).astype(int)
    score = np.stack([scaled[a:b].T @ residual[a:b] for a, b in pairwise(edges)])
    covariance = inverse @ (score.T @ score) @ inverse / np.outer(scale, scale)
    inverse_c = solution[1]
    # C = 1/s, R = τ·s with s = 1/C.
    gradients = {
        "C": np.array([0.0, -1.0 / inverse_c**2, 0.0]),
        "R": np.array([0.0, tau, tau * inverse_c]),
        "T_amb": np.array([1.0, 0.0, 0.0]),
    }
    return {symbol: float(np.sqrt(max(g @ covariance @ g, 0.0))) for symbol, g in gradients.items()}
