"""A servo drive's own loops, sampled at the drive's tick: velocity estimate, PI velocity loop, torque limit, current loop."""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from fakes.plant.images import MODE_TORQUE, MODE_VELOCITY


@njit(cache=True)
def read_encoder(p: Any, angle: float, noise: float) -> int:
    """Return the encoder's counts at an angle in the drive's frame, rounded down."""
    return int(math.floor(angle * p.encoder_scale + p.encoder_zero + noise))


@njit(cache=True)
def estimate_velocity(p: Any, s: Any, counts: int, tick: float) -> None:
    """Take a new reading into the drive's velocity estimate (difference quotient behind a first-order lag)."""
    raw = (counts - s.counts) / (p.encoder_scale * tick)
    s.velocity += p.velocity_share * (raw - s.velocity)
    s.counts = counts


@njit(cache=True)
def _limited(value: float, limit: float) -> float:
    """Return the value within ±limit."""
    return min(max(value, -limit), limit)


@njit(cache=True)
def _velocity_loop(p: Any, s: Any, reference: float) -> float:
    """Return the set torque of the PI loop; the integral stands still where the limit is reached (anti-windup)."""
    error = reference - s.velocity
    wanted = p.proportional * error + s.integral
    torque = _limited(wanted, p.maximum_torque)
    if wanted == torque or wanted * error < 0.0:
        s.integral = _limited(s.integral + p.integral_share * error, p.maximum_torque)
    return torque


@njit(cache=True)
def run_loops(p: Any, s: Any, mode: int, quick_stop: bool, velocity: float, torque: float, tick: float) -> None:
    """Step the loops of an enabled drive; the motor's torque is left in ``s.torque`` (own frame, N·m).

    A quick stop ramps the drive's own speed down and holds it at rest, in whatever mode the drive was.
    """
    if quick_stop:
        if s.stopping == 0:
            s.stopping = 1
            s.ramp = s.velocity
        change = p.deceleration * tick
        s.ramp = s.ramp - change if s.ramp > change else (s.ramp + change if s.ramp < -change else 0.0)
        wanted = _velocity_loop(p, s, s.ramp)
    else:
        s.stopping = 0
        if mode == MODE_VELOCITY:
            wanted = _velocity_loop(p, s, velocity)
        else:
            wanted = _limited(torque, p.maximum_torque) if mode == MODE_TORQUE else 0.0
            # a later change to the velocity loop starts from the torque there is
            s.integral = wanted
    s.filtered += p.torque_share * (wanted - s.filtered)
    s.torque += p.current_share * (s.filtered - s.torque)


@njit(cache=True)
def rest_loops(s: Any) -> None:
    """Hold the loops of a drive without power at zero."""
    s.stopping = 0
    s.integral = 0.0
    s.filtered = 0.0
    s.torque = 0.0


@njit(cache=True)
def report_torque(p: Any, s: Any, noise: float) -> float:
    """Return the torque that the drive reports from its current, quantised."""
    value = s.torque + p.torque_noise * noise
    return math.floor(value / p.torque_resolution + 0.5) * p.torque_resolution
