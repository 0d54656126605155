"""What a physics term sees of a recording: one row a sample (or a block of samples), one array a quantity.

Every array of a :class:`Frame` has the same length n. Rows of one recording stand together in the order of time, so
that terms with a memory (play, lag, pre-sliding) can be simulated along them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from bench.simulation.states import Memory

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Frame:
    """Quantities of the nominal simulation (notation of the bench), SI units, one row a sample or block.

    Angles are in rad, speeds in rad/s, torques in N·m, temperatures in °C, times in s. ``ratio`` is u.
    """

    ratio: float
    recording: IntArray
    """index of the recording a row belongs to"""
    count: FloatArray
    """samples averaged in the row"""
    time: FloatArray
    """since the first sample of the campaign"""
    elapsed: FloatArray
    """since the first sample of the recording"""
    theta: FloatArray
    """input angle in load-side scaling, motor_angle / u"""
    q: FloatArray
    """load-side angle"""
    velocity: FloatArray
    """rate of theta, smoothed"""
    acceleration: FloatArray
    """rate of the motor's speed, rad/s² at the motor shaft"""
    load_acceleration: FloatArray
    """second derivative of q"""
    direction: FloatArray
    """sign of the motion; 0 at standstill"""
    last_direction: FloatArray
    """sign of the last motion (at standstill: of the motion before)"""
    torque: FloatArray
    """load_torque of the sensor, where it keeps its level smoothed: the simulation's input tau"""
    torque_level: FloatArray
    """the same, in a steady segment that keeps its load its mean: noise of the sensor is no place on a curve"""
    kept: FloatArray
    """number of the segment, from 1, in which the load is kept at a level and ``torque`` is smoothed; 0 elsewhere"""
    followed: FloatArray
    """share of what the sensor reads about the level of such a segment that ``torque`` follows"""
    torque_rate: FloatArray
    """rate of the load torque, N·m/s"""
    temperature: FloatArray
    motor_torque: FloatArray
    load_motor_torque: FloatArray
    """as the load motor's drive reports it, where it keeps its level smoothed"""
    load_motor_level: FloatArray
    """the same, in a steady segment that keeps its load its mean"""
    power: FloatArray
    """loss abs(tau_m*w_m - tau*dq/dt) in W, of smoothed factors"""
    lead: FloatArray
    """J by which the mean over a row of the loss's time integral is ahead of trapezoids through the rows' mean losses:
    what a row of many samples hides of a ramp; 0 where a row is a sample
    """
    kinetic: FloatArray
    """rate of half the square of the motor's speed, (rad/s)²/s: times an inertia the power that speeds it up"""
    travel: FloatArray
    """distance run since the campaign began, rad at the output"""
    reversal_travel: FloatArray
    """distance run since the last change of direction, rad at the output"""
    reversal_time: FloatArray
    """time since the last change of direction"""
    reversed_before: FloatArray
    """1 where the motion before the last standstill or change of direction went the other way, else 0"""
    steady: FloatArray
    """1 inside a steady segment"""
    step: FloatArray
    """time that the samples of this row take, s: of a row that is a sample, from the one before; the first sample of a
    recording counts as 0
    """
    aux: Mapping[str, FloatArray] = field(default_factory=dict)
    """quantities that are no channel of the bench, by name"""
    memory: Memory | None = None
    """states in which terms go on from the frame before; None: they begin in its first row"""
    aside: Frame | None = None
    """rows of further recordings, in which nothing is compared: states that are not recorded go on through them"""

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(self.recording.size)

    @property
    def omega(self) -> FloatArray:
        """Speed of the input motor's shaft, rad/s."""
        return self.velocity * self.ratio

    @property
    def states(self) -> FloatArray:
        """Torque, velocity and temperature of each row (n, 3): what amplitudes, phases and the offset depend on."""
        return np.column_stack([self.torque, self.velocity, self.temperature])

    def take(self, rows: NDArray[np.bool_] | IntArray | slice) -> Frame:
        """Return the frame of the rows chosen."""
        taken: dict[str, Any] = {name: getattr(self, name)[rows] for name in ARRAYS}
        return replace(self, aux={name: values[rows] for name, values in self.aux.items()}, **taken)


ARRAYS = tuple(f.name for f in fields(Frame) if f.name not in ("ratio", "aux", "memory", "aside"))


def concatenate(frames: Sequence[Frame]) -> Frame:
    """Join frames of one bench, in their order."""
    joined: dict[str, Any] = {name: np.concatenate([getattr(f, name) for f in frames]) for name in ARRAYS}
    names = [name for name in frames[0].aux if all(name in f.aux for f in frames)]
    return replace(frames[0], aux={name: np.concatenate([f.aux[name] for f in frames]) for name in names}, **joined)


def gone_through(frame: Frame) -> Frame:
    """A frame with the rows that lie aside of it, in the order of the recordings."""
    if frame.aside is None:
        return frame
    both = concatenate([replace(frame, aside=None), frame.aside])
    return both.take(np.argsort(both.recording, kind="stable"))


def recording_starts(frame: Frame) -> IntArray:
    """Indices of the first row of each recording, and n at the end."""
    change = np.flatnonzero(np.diff(frame.recording)) + 1
    return np.concatenate(([0], change, [frame.size])).astype(np.int64)
