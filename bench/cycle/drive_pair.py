"""Both drives of a bench as one: their set values, the goals of their state machines, their moment in a replay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.cycle.channels import DriveScales
from bench.devices import Drive

FloatArray = NDArray[np.float64]
DRIVES = ("input_drive", "load_drive")


@dataclass(frozen=True, slots=True)
class DrivePair:
    """The input drive, which turns the motor, and the load drive, which brakes the output."""

    input_drive: Drive
    load_drive: Drive

    @property
    def both(self) -> tuple[Drive, Drive]:
        """Both, input first."""
        return self.input_drive, self.load_drive

    @property
    def scales(self) -> tuple[DriveScales, DriveScales]:
        """What one count of each is; known once the bus has configured them."""
        first, second = (
            DriveScales(drive.units.position_rad, drive.units.velocity_rad_s, drive.units.torque_nm)
            for drive in self.both
        )
        return first, second

    def attach(self, outputs: Mapping[str, NDArray[Any]], inputs: Mapping[str, NDArray[Any]]) -> None:
        """Take the drives' process data, by role."""
        for role, drive in zip(DRIVES, self.both, strict=True):
            drive.attach(outputs[role], inputs[role])

    def prepare(self, motor_velocity: FloatArray, torque: FloatArray) -> None:
        """Write set values (n,), rad/s at the motor and N·m of load, and control words into the next n cycles."""
        n = motor_velocity.size
        self.input_drive.set_velocity(motor_velocity, n)
        self.load_drive.set_torque(torque, n)
        for drive in self.both:
            drive.prepare(n)

    def digest(self, n: int) -> None:
        """Follow the drives' state machines over the n cycles just exchanged."""
        for drive in self.both:
            drive.digest(n)

    def snapshot(self) -> tuple[Any, ...]:
        """Return what :meth:`restore` takes."""
        return tuple(drive.snapshot() for drive in self.both)

    def restore(self, tokens: Sequence[Any]) -> None:
        """Return both to an earlier moment."""
        for drive, token in zip(self.both, tokens, strict=True):
            drive.restore(token)

    def request(self, goal: str, only: str | None = None) -> None:
        """Ask both, or the ``only`` one named, for a goal of their state machine, by its name."""
        for drive in self._selected_drives(only):
            drive.request(goal)

    def reached(self, goal: str | None = None, only: str | None = None) -> bool:
        """Whether both are where they were asked to go (and that is ``goal``)."""
        return all(drive.reached(goal) for drive in self._selected_drives(only))

    def asked_for(self, goal: str) -> bool:
        """Whether both were asked for a goal last, wherever they are by now."""
        return all(drive.goal_name == goal for drive in self.both)

    def check(self, n: int, only: str | None = None) -> None:
        """Raise a driver error unless both are on their way to their goal or there, after a block of n cycles."""
        for drive in self._selected_drives(only):
            drive.check(n)

    def states(self) -> dict[str, str]:
        """Return the state of each state machine as of the last cycle."""
        return {name: drive.state_name for name, drive in zip(DRIVES, self.both, strict=True)}

    def _selected_drives(self, only: str | None) -> tuple[Drive, ...]:
        return tuple(drive for name, drive in zip(DRIVES, self.both, strict=True) if only in (None, name))
