"""How the bench moves: directions, distance since a reversal, corners of the speed profile, and when it stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.mismatch.smoothing import SMOOTHING_S, repaired, smooth, span_for, window
from bench.recording import Recording
from bench.simulation.frame import FloatArray

STANDSTILL_RAD_S = 0.3
"""Motor speed below which the bench counts as standing (on the smoothed velocity)."""
STANDSTILL_SHARE = 0.02


def corners(acceleration: FloatArray, rate: float, span: float = SMOOTHING_S) -> NDArray[np.bool_]:
    """Mark the surroundings of jumps of the acceleration (the corners of a speed profile)."""
    half = max(1, window(rate, span) // 2 + 1)
    # a recording that begins or ends while the speed changes has a corner there: what was before is not known
    padded = np.pad(acceleration, half)
    jump = np.abs(padded[2 * half :] - padded[: -2 * half])
    noise = 1.4826 * float(np.median(jump))
    largest = float(np.percentile(np.abs(acceleration), 99.5))
    marked = jump > max(6.0 * noise, 0.1 * largest, 0.5)
    if marked.mean() > 0.3:  # no trapezoids here: a speed that never rests has no corners
        return np.zeros(acceleration.size, dtype=bool)
    spread = np.convolve(marked.astype(np.float64), np.ones(2 * (half // 2) + 1), mode="same")
    return np.asarray(spread > 0.5)


@dataclass(frozen=True, slots=True)
class Manner:
    """How motion is read: below which motor speed the bench stands, rad/s (a linear axis: m/s); over how many seconds
    rates are smoothed.
    """

    standstill: float = STANDSTILL_RAD_S
    smoothing: float = SMOOTHING_S

    @classmethod
    def of(cls, recordings: Sequence[Recording]) -> Manner:
        """Read it from a folder's recordings.

        The bench stands below the speed of a geared motor's crawl, unless nothing in the folder ever moves ten times
        as fast: then below a fiftieth of the fastest speed.
        """
        standstill = standstill_speed(recordings)
        for recording in recordings:
            if "motor_angle" in recording:
                angle = _angle(recording)
                return cls(standstill, span_for(angle, float(recording.sample_rate), standstill))
        return cls(standstill)


def _angle(recording: Recording) -> FloatArray:
    angle = recording.si("motor_angle")
    return repaired(angle, ~np.isfinite(angle))


def standstill_speed(recordings: Sequence[Recording]) -> float:
    """Motor speed in rad/s (a linear axis: m/s) below which the bench counts as standing."""
    fastest = 0.0
    for recording in recordings:
        velocity, ratio = recording.setpoint.velocity, float(recording.gearbox.ratio or 1.0)
        if np.isfinite(velocity) and velocity != 0.0:
            fastest = max(fastest, abs(velocity) * ratio)
        elif "motor_angle" in recording and recording.size > 1:
            speed = np.abs(smooth(_angle(recording), float(recording.sample_rate), 1))
            fastest = max(fastest, float(np.percentile(speed, 99.0)))
        if fastest > 10.0 * STANDSTILL_RAD_S:
            return STANDSTILL_RAD_S
    return max(STANDSTILL_SHARE * fastest, 1e-9) if fastest > 0.0 else STANDSTILL_RAD_S


USUAL = Manner()


def directions(omega: FloatArray, standstill: float) -> tuple[FloatArray, FloatArray]:
    """Sign of the motion, 0 at standstill; and of the last motion, which at standstill is the one before."""
    direction = np.where(np.abs(omega) > standstill, np.sign(omega), 0.0)
    moving = np.flatnonzero(direction)
    if moving.size == 0:
        return direction, direction
    before = np.maximum.accumulate(np.where(direction != 0, np.arange(direction.size), -1))
    return direction, direction[np.where(before >= 0, before, moving[0])]


def since_change(
    theta: FloatArray, time: FloatArray, direction: FloatArray, last: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Travel and time since the motion last began, and whether it went the other way before."""
    moving = direction != 0
    begins = moving & ~np.concatenate(([False], moving[:-1] & (direction[:-1] == direction[1:])))
    start = np.maximum.accumulate(np.where(begins, np.arange(theta.size), 0))
    step = np.abs(np.diff(theta, prepend=theta[0]))
    run = np.cumsum(step)
    turned = np.concatenate(([False], last[1:] != last[:-1]))
    # a start without a change of direction (after a stop) is no reversal
    reversed_at = np.cumsum(turned)
    reversed_before = (reversed_at > 0).astype(np.float64)
    return run - run[start], time - time[start], reversed_before
