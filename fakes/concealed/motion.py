"""What the bench does at a point: angle, speed, load and segments on a common time base."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from fakes.concealed.design import Point

Floats = NDArray[np.float64]
_ACCELERATION = 0.35  # rad/s² at the load side while a point is run up
_HEAT_ACCELERATION = 0.2


@dataclass(frozen=True, slots=True)
class Motion:
    """Kinematics (N,) of one recording.

    Attributes:
        time: s since the first sample.
        theta, rate, acceleration: input angle in load-side scaling and its derivatives, SI.
        sign: −1, 0 (commanded standstill) or +1.
        command: load torque the load motor is told to exert, N·m in the torque sensor's sign.
        segments: (name, start, stop).
    """

    time: Floats
    theta: Floats
    rate: Floats
    acceleration: Floats
    sign: Floats
    command: Floats
    segments: tuple[tuple[str, int, int], ...]


@dataclass(slots=True)
class _Track:
    """Set-value pieces collected one after another: (duration s, end speed, end torque, segment name)."""

    speed: float
    torque: float
    pieces: list[tuple[float, float, float, str]]

    def go(self, duration: float, speed: float, torque: float, name: str) -> None:
        self.pieces.append((duration, speed, torque, name))
        self.speed, self.torque = speed, torque

    def to(self, speed: float, name: str, acceleration: float = _ACCELERATION) -> None:
        self.go(max(abs(speed - self.speed) / acceleration, 0.02), speed, self.torque, name)


def move(point: Point, rate_hz: float, theta_start: float, rng: np.random.Generator) -> Motion:
    """Run one point; ``theta_start`` (rad) continues the campaign's one zero."""
    track = _PLANS[point.kind](point, rng)
    start = (track.pieces[0][1], track.pieces[0][2]) if point.flying else (0.0, 0.0)
    speed, command, segments = _lay_out(track.pieces, start, rate_hz)
    time = np.arange(speed.size) / rate_hz
    sign = np.sign(np.where(np.abs(speed) < 1e-4, 0.0, speed))
    smooth = _smooth(speed, rate_hz)
    theta = theta_start + np.concatenate(([0.0], np.cumsum(0.5 * (smooth[1:] + smooth[:-1])) / rate_hz))
    ripple, ripple_rate, ripple_acceleration = _fluctuation(smooth, theta, time, rate_hz, rng)
    acceleration = np.gradient(smooth, 1.0 / rate_hz) + ripple_acceleration
    return Motion(time, theta + ripple, smooth + ripple_rate, acceleration, sign, _smooth(command, rate_hz), segments)


def _lay_out(
    pieces: list[tuple[float, float, float, str]], start: tuple[float, float], rate_hz: float
) -> tuple[Floats, Floats, tuple[tuple[str, int, int], ...]]:
    speeds: list[Floats] = []
    torques: list[Floats] = []
    segments: list[tuple[str, int, int]] = []
    speed, torque, at = *start, 0
    for duration, end_speed, end_torque, name in pieces:
        count = max(round(duration * rate_hz), 2)
        grid = np.arange(1, count + 1) / count
        speeds.append(speed + (end_speed - speed) * grid)
        torques.append(torque + (end_torque - torque) * grid)
        if segments and segments[-1][0] == name and name != "plateau":
            segments[-1] = (name, segments[-1][1], at + count)
        elif name:
            segments.append((name, at, at + count))
        speed, torque, at = end_speed, end_torque, at + count
    named = tuple(("steady" if n == "plateau" else n, a, b) for n, a, b in segments)
    return np.concatenate(speeds), np.concatenate(torques), named


def _smooth(values: Floats, rate_hz: float) -> Floats:
    """First-order drive response with 15 ms, twice: corners of the set values are never seen sharp."""
    keep = np.exp(-1.0 / (0.015 * rate_hz))
    for _ in range(2):
        values, _state = lfilter([1.0 - keep], [1.0, -keep], values, zi=np.array([values[0] * keep]))
    return np.asarray(values)


def _fluctuation(
    speed: Floats, theta: Floats, time: Floats, rate_hz: float, rng: np.random.Generator
) -> tuple[Floats, Floats, Floats]:
    """Speed fluctuation of the velocity loop: once and thrice per output revolution plus slow wander."""
    angle = np.zeros_like(speed)
    rate = np.zeros_like(speed)
    acceleration = np.zeros_like(speed)
    for order in (1.0, 3.0):
        share = rng.uniform(0.0005, 0.003)
        phase = order * theta + rng.uniform(0.0, 2.0 * np.pi)
        sine = np.sin(phase)
        angle += share / order * sine
        rate += share * np.cos(phase) * speed
        acceleration -= share * order * sine * speed**2
    for hz in rng.uniform(0.15, 2.5, 3):
        size = rng.uniform(0.0005, 0.002) * np.abs(speed)
        phase = 2.0 * np.pi * hz * time + rng.uniform(0.0, 2.0 * np.pi)
        sine = np.sin(phase)
        angle += size / (2.0 * np.pi * hz) * sine
        rate += size * np.cos(phase)
        acceleration -= size * 2.0 * np.pi * hz * sine
    return angle, rate, acceleration


def _constant(point: Point, rng: np.random.Generator) -> _Track:
    duration = 2.0 * np.pi * rng.uniform(1.01, 1.06) / abs(point.rate)
    track = _Track(0.0, 0.0, [])
    if point.flying:
        track.go(duration, point.rate, point.torque, "steady")
        return track
    track.go(0.4, 0.0, 0.0, "ramp_up")
    track.go(0.8, 0.0, point.torque, "ramp_up")
    track.to(point.rate, "ramp_up")
    track.go(0.5, point.rate, point.torque, "ramp_up")
    track.go(duration, point.rate, point.torque, "steady")
    track.to(0.0, "ramp_down")
    track.go(0.6, 0.0, 0.0, "ramp_down")
    return track


def _heating(point: Point, rng: np.random.Generator) -> _Track:
    track = _Track(0.0, 0.0, [])
    track.to(point.rate, "ramp_up", _HEAT_ACCELERATION)
    track.go(point.span, point.rate, 0.0, "heat")
    track.to(0.0, "ramp_down", _HEAT_ACCELERATION)
    return track


def _at_standstill(point: Point, rng: np.random.Generator) -> _Track:
    track = _Track(0.0, 0.0, [])
    track.go(0.5, 0.0, point.torque, "ramp_up")
    track.go(point.span, 0.0, point.torque, "dwell")
    track.go(0.5, 0.0, 0.0, "ramp_down")
    return track


def _reversal(point: Point, rng: np.random.Generator) -> _Track:
    track = _Track(0.0, 0.0, [])
    track.go(0.6, 0.0, point.torque, "ramp_up")
    speed = point.rate
    for number in range(8):
        track.to(speed, "ramp_up", 1.5)
        track.go(point.span * rng.uniform(0.9, 1.1) / abs(speed), speed, point.torque, "plateau")
        track.to(0.0, "ramp_down", 1.5)
        if number % 2 == 0:
            track.go(0.15, 0.0, point.torque, "ramp_down")
        speed = -speed
    track.go(0.6, 0.0, 0.0, "ramp_down")
    return track


def _torque_ramp(point: Point, rng: np.random.Generator) -> _Track:
    """A staircase up, down through zero to the other side and back: both branches of any path dependence."""
    track = _Track(0.0, 0.0, [])
    track.to(point.rate, "ramp_up")
    hold, climb = rng.uniform(1.6, 2.4), rng.uniform(0.25, 0.6)
    stairs = [0.1, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.1, 0.0, -0.1, -0.25, -0.5, -1.0, -0.5, -0.25, 0.0]
    for share in [*stairs, 0.3, 0.6, 0.3, 0.0]:
        track.go(climb, point.rate, share * point.torque, "steady")
        track.go(hold, point.rate, share * point.torque, "steady")
    track.to(0.0, "ramp_down")
    return track


def _velocity_ramp(point: Point, rng: np.random.Generator) -> _Track:
    track = _Track(0.0, 0.0, [])
    track.go(0.6, 0.0, point.torque, "ramp_up")
    for sign in (1.0, -1.0):
        track.go(rng.uniform(14.0, 20.0), sign * point.rate, point.torque, "ramp_up")
        track.go(rng.uniform(14.0, 20.0), 0.0, point.torque, "ramp_down")
    track.go(0.6, 0.0, 0.0, "ramp_down")
    return track


_PLANS = {
    "constant_velocity": _constant,
    "validation": _constant,
    "heating": _heating,
    "unrecorded": _heating,
    "cooling": _at_standstill,
    "dwell": _at_standstill,
    "reversal": _reversal,
    "torque_ramp": _torque_ramp,
    "velocity_ramp": _velocity_ramp,
}
