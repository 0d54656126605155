"""A servo drive's own loops, sampled at its tick: velocity estimate, PI velocity loop, torque limit, current loop."""

from __future__ import annotations

import math
from typing import Any

from numba import njit

from fakes.plant.images import MODE_TORQUE, MODE_VELOCITY


@njit(cache=True, error_model="numpy")
def _limited(value: float, limit: float) -> float:
    """Return the value within ±limit."""
    return float(min(max(value, -limit), limit))


@njit(cache=True, error_model="numpy")
def _estimate_velocity(p: Any, s: Any, counts: int, tick: float) -> None:
    """Take a new reading into the drive's velocity estimate (difference quotient behind a first-order lag)."""
    raw = (counts - s.counts) / (p.encoder_scale * tick)
    s.velocity += p.velocity_share * (raw - s.velocity)
    s.counts = counts


@njit(cache=True, error_model="numpy")
def _velocity_loop(p: Any, s: Any, reference: float) -> float:
    """Return the set torque of the PI loop; the integral stands still where the limit is reached (anti-windup)."""
    error = reference - s.velocity
    wanted = p.proportional * error + s.integral
    torque = _limited(wanted, p.maximum_torque)
    if wanted == torque or wanted * error < 0.0:
        s.integral = _limited(s.integral + p.integral_share * error, p.maximum_torque)
    return torque


@njit(cache=True, error_model="numpy")
def _set_torque(p: Any, s: Any, mode: int, quick_stop: bool, velocity: float, torque: float, tick: float) -> float:
    """Return the set torque of an enabled drive.

    A quick stop ramps the drive's own speed down and holds it at rest, in whatever mode the drive was.
    """
    if quick_stop:
        if s.stopping == 0:
            s.stopping = 1
            s.ramp = s.velocity
        change = p.deceleration * tick
        s.ramp = math.copysign(max(abs(s.ramp) - change, 0.0), s.ramp)
        return _velocity_loop(p, s, s.ramp)
    s.stopping = 0
    if mode == MODE_VELOCITY:
        return _velocity_loop(p, s, velocity)
    wanted = _limited(torque, p.maximum_torque) if mode == MODE_TORQUE else 0.0
    # a later change to the velocity loop starts from the torque there is
    s.integral = wanted
    return wanted


@njit(cache=True, error_model="numpy")
def run_drive(
    p: Any, s: Any, counts: int, enabled: bool, mode: int, quick_stop: bool, velocity: float, torque: float, tick: float
) -> None:
    """Step one drive by a tick; the motor's torque is left in ``s.torque`` (own frame, N·m, 0 with the power off)."""
    _estimate_velocity(p, s, counts, tick)
    if enabled:
        wanted = _set_torque(p, s, mode, quick_stop, velocity, torque, tick)
        s.filtered += p.torque_share * (wanted - s.filtered)
        s.torque += p.current_share * (s.filtered - s.torque)
    else:
        s.stopping = 0
        s.integral = s.filtered = s.torque = 0.0


@njit(cache=True, error_model="numpy")
def report_torque(p: Any, s: Any, noise: float) -> float:
    """Return the torque that the drive reports from its current, quantised."""
    value = s.torque + p.torque_noise * noise
    return float(math.floor(value / p.torque_resolution + 0.5) * p.torque_resolution)
