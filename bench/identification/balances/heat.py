"""Heat balance C·dT/dt = |τ_m·ω_m − τ·q̇| − (T − T_amb)/R (bench-physics, equation 3), by output error.

Zeros of the two torques that are known are taken off first: a torque that is the same in both directions does not heat.
So is what spins the rotor up: ½·J·ω² is stored, not lost.

For a given time constant RC the temperature of a recording is linear in its start T_0, in T_amb and in 1/C:

    T(t) = T_0·e + T_amb·(1 − e) + (1/C)·∫ P(s)·exp(−(t − s)/RC) ds,   e = exp(−t/RC)

so one search over RC (variable projection) and a linear fit with a free T_0 a recording remain. The power is measured,
so it has an error of its own: each recording's is wrong by a factor of its own, with the standard deviation of a torque
sensor of class 0.05. The thermometer's noise remembers itself by its first autocorrelation, seen in the residuals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from bench.identification.samples.reduction import Reduction

FloatArray = NDArray[np.float64]

STEP_S = 2.0
POWER_CLASS = 5e-4
"""Standard deviation of a recording's power, of itself: accuracy class 0.05 of a torque sensor."""
MOST_MEMORY = 0.9
"""Highest autocorrelation from one step to the next that is believed."""
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
    """One recording: blocks (B,) of time s and power W; temperatures °C (n,) averaged over ``width`` blocks each."""

    time: FloatArray
    power: FloatArray
    temperature: FloatArray
    width: int

    def averaged(self, x: FloatArray) -> FloatArray:
        """Means (n,) of a block's quantity (B,), as the temperatures are."""
        count = self.temperature.size
        return np.asarray(x[: count * self.width].reshape(count, self.width).mean(axis=1))


@njit(cache=True)
def _response(time: FloatArray, power: FloatArray, tau: float) -> FloatArray:
    """∫ P(s)·exp(−(t − s)/τ) ds for power held over each step."""
    out = np.zeros(time.size)
    for n in range(1, time.size):
        decay = np.exp(-(time[n] - time[n - 1]) / tau)
        out[n] = out[n - 1] * decay + 0.5 * (power[n] + power[n - 1]) * tau * (1.0 - decay)
    return out


def _series(r: Reduction, motor_zero: float, inertia: float) -> _Series | None:
    b = r.blocks
    rate = np.where(np.isfinite(b.acceleration), b.acceleration, 0.0)
    input_power = (b.motor_torque - motor_zero - inertia * rate) * b.motor_velocity
    power = np.abs(input_power - b.load_torque * b.load_velocity)
    if b.size < 4 or not (np.isfinite(power).all() and np.isfinite(b.temperature).all()):
        return None
    step = float(np.median(np.diff(b.time)))
    width = max(1, round(STEP_S / step)) if b.size * step > 4 * STEP_S else 1
    count = b.size // width
    temperature = b.temperature[: count * width].reshape(count, width).mean(axis=1)
    return _Series(b.time, power, temperature, width) if count >= 3 else None


def _parts(s: _Series, tau: float) -> tuple[FloatArray, FloatArray]:
    """Columns [T_amb, 1/C] (n, 2) and temperatures (n,) with the recording's own T_0 projected out."""
    decay = np.exp(-(s.time - s.time[0]) / tau)
    warming = s.averaged(_response(s.time, s.power, tau))
    start = s.averaged(decay)
    unit = start / np.linalg.norm(start)
    x = np.column_stack([1.0 - start, warming])
    return x - unit[:, None] * (unit @ x), s.temperature - unit * (unit @ s.temperature)


def _design(series: Sequence[_Series], tau: float) -> tuple[list[FloatArray], list[FloatArray]]:
    columns, targets = zip(*(_parts(s, tau) for s in series), strict=True)
    return list(columns), list(targets)


def _weights(columns: Sequence[FloatArray], inverse_c: float, noise: float) -> list[FloatArray]:
    """Of each recording the vector h (n,) with weight matrix 1 − h·hᵀ (in units of the thermometer's noise variance).

    An error of the power by a factor is a vector along the warming: its variance is taken off by Woodbury's identity.
    """
    out = []
    for x in columns:
        along = x[:, 1] * (inverse_c * POWER_CLASS / noise)
        out.append(along / np.sqrt(1.0 + along @ along))
    return out


def _solve(
    columns: Sequence[FloatArray], targets: Sequence[FloatArray], weights: Sequence[FloatArray]
) -> tuple[FloatArray, FloatArray, float]:
    """Weighted least squares: solution (P,), inverse of the normal matrix (P, P), weighted cost."""
    size = columns[0].shape[1]
    normal, right, square = np.zeros((size, size)), np.zeros(size), 0.0
    for x, y, h in zip(columns, targets, weights, strict=True):
        hx, hy = h @ x, float(h @ y)
        normal += x.T @ x - np.outer(hx, hx)
        right += x.T @ y - hx * hy
        square += float(y @ y) - hy**2
    scale = np.sqrt(np.diag(normal)) + 1e-300
    inverse = np.linalg.pinv(normal / np.outer(scale, scale), rcond=1e-12, hermitian=True) / np.outer(scale, scale)
    solution = inverse @ right
    return solution, inverse, square - float(right @ solution)


def _noise(residuals: Sequence[FloatArray]) -> tuple[float, float]:
    """Standard deviation of the thermometer's noise at a step, and by how much memory widens variances.

    Both from differences of neighbours, so that a slow error of the power does not count as noise.
    """
    one = np.concatenate([np.diff(r) for r in residuals])
    two = np.concatenate([r[2:] - r[:-2] for r in residuals])
    near, far = 0.5 * float(np.mean(one**2)), 0.5 * float(np.mean(two**2)) if two.size else 0.0
    # of noise with autocorrelation ρ, ρ²: near = σ²(1 − ρ), far = σ²(1 − ρ²)
    memory = float(np.clip(far / max(near, 1e-300) - 1.0, 0.0, MOST_MEMORY))
    return float(np.sqrt(near / (1.0 - memory))) + 1e-12, (1.0 + memory) / (1.0 - memory)


def identify_heat(reductions: Sequence[Reduction], motor_zero: float = 0.0, inertia: float = 0.0) -> HeatFit:
    """Fit the heat balance to all recordings that measured power and temperature; says what they do not determine.

    ``motor_zero`` is τ_0 in N·m, ``inertia`` J in kg·m², as identified: at the speed of the load side τ_0 takes off the
    power that both torques' zeros make.
    """
    series = [s for r in reductions if (s := _series(r, motor_zero, inertia)) is not None]
    if not series:
        return HeatFit({}, {}, float("nan"), ("The heat balance is not identified: temperature or power is missing.",))
    span = max(float(np.ptp(s.temperature)) for s in series)
    if span < MIN_CHANGE_K:
        why = f"the lubricant warms or cools by {span:.2g} K at most within a recording, {MIN_CHANGE_K:g} K are needed"
        return HeatFit({}, {}, float("nan"), (f"C, R and T_amb (heat balance) are not determined: {why}.",))
    weights = [np.zeros(s.temperature.size) for s in series]
    noise = memory = tau = 1.0
    solution = np.zeros(2)
    for _ in range(2):
        # first without weights, then with those that the noise and capacity found imply
        found = minimize_scalar(
            lambda log_tau, w=weights: _solve(*_design(series, float(np.exp(log_tau))), w)[2],
            bounds=(np.log(60.0), np.log(1e6)),
            method="bounded",
            options={"xatol": 1e-5},
        )
        tau = float(np.exp(found.x))
        columns, targets = _design(series, tau)
        solution = _solve(columns, targets, weights)[0]
        if solution[1] <= 0:
            return HeatFit({}, {}, float("nan"), ("The heat balance is not identified: warming follows no power.",))
        residuals = [y - x @ solution for x, y in zip(columns, targets, strict=True)]
        noise, memory = _noise(residuals)
        weights = _weights(columns, float(solution[1]), noise)
    capacity = 1.0 / float(solution[1])
    values = {"C": capacity, "R": tau / capacity, "T_amb": float(solution[0])}
    std = _deviations(series, tau, solution, weights, noise * np.sqrt(memory))
    sentences = []
    for symbol, limit, what in (
        ("C", 0.5 * capacity, "heating with known power"),
        ("R", 0.5 * values["R"], "cooling, or heating up to a steady temperature"),
        ("T_amb", 10.0, "cooling towards the surroundings"),
    ):
        if not np.isfinite(std[symbol]) or std[symbol] > limit:
            sentences.append(f"{symbol} (heat balance) is not determined: it takes {what}.")
            del values[symbol], std[symbol]
    cost = sum(float(r @ r) for r in residuals)
    rows = sum(s.temperature.size for s in series)
    return HeatFit(values, std, float(np.sqrt(cost / rows)), tuple(sentences))


def _deviations(
    series: Sequence[_Series], tau: float, solution: FloatArray, weights: Sequence[FloatArray], noise: float
) -> dict[str, float]:
    """Standard deviations of C, R and T_amb by the delta method, from the noise and the error of the power."""
    log_step = 1e-4
    upper, lower = _design(series, tau * np.exp(log_step)), _design(series, tau * np.exp(-log_step))
    columns, _ = _design(series, tau)
    jacobian = [
        # T_0 is projected out at each time constant, so the temperature's own projection moves as well
        np.column_stack([x, ((u - v) @ solution - (p - q)) / (2.0 * log_step)])
        for x, u, v, p, q in zip(columns, upper[0], lower[0], upper[1], lower[1], strict=True)
    ]
    _, inverse, _ = _solve(jacobian, [np.zeros(x.shape[0]) for x in jacobian], weights)
    covariance = inverse * noise**2
    inverse_c = solution[1]
    # C = 1/s, R = τ·s with s = 1/C.
    gradients = {
        "C": np.array([0.0, -1.0 / inverse_c**2, 0.0]),
        "R": np.array([0.0, tau, tau * inverse_c]),
        "T_amb": np.array([1.0, 0.0, 0.0]),
    }
    return {symbol: float(np.sqrt(max(g @ covariance @ g, 0.0))) for symbol, g in gradients.items()}
