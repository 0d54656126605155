"""What the bench uses of drives and terminals on the bus."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bench.devices.bus import SlaveSpec

FloatArray = NDArray[np.float64]


class Device(Protocol):
    """A device on the bus."""

    @property
    def spec(self) -> SlaveSpec:
        """The slave as the bus should find it."""
        ...

    def attach(self, outputs: NDArray[Any] | None, inputs: NDArray[Any] | None) -> None:
        """Take the device's process data (capacity,); None for a direction it has none of."""
        ...


class DriveUnits(Protocol):
    """What one count is at the motor shaft, in the drive's own direction."""

    @property
    def position_rad(self) -> float:
        """One count of position, rad."""
        ...

    @property
    def velocity_rad_s(self) -> float:
        """One count of velocity, rad/s."""
        ...

    @property
    def torque_nm(self) -> float:
        """One count of torque, N·m."""
        ...


class Drive(Device, Protocol):
    """A servo drive.

    Its goals are DISABLED, READY, SWITCHED_ON, ENABLED, QUICK_STOP and FAULT_RESET, by these names.
    """

    @property
    def units(self) -> DriveUnits:
        """Scales of the drive; known once the bus has configured it."""
        ...

    @property
    def goal_name(self) -> str:
        """Goal asked for last."""
        ...

    @property
    def state_name(self) -> str:
        """State of the drive (CiA 402) as of the last block, for people and records."""
        ...

    def request(self, goal: str) -> None:
        """Start towards a goal."""
        ...

    def reached(self, goal: str | None = None) -> bool:
        """Whether the drive has come to the goal asked for last and is there (and it is ``goal``)."""
        ...

    def check(self, n: int) -> None:
        """Raise a driver error unless the drive is on its way to its goal or there, after a block of n cycles."""
        ...

    def set_velocity(self, velocity_rad_s: FloatArray, n: int) -> None:
        """Set target velocities (n,), rad/s at the motor shaft in the bench's direction."""
        ...

    def set_torque(self, torque_nm: FloatArray, n: int) -> None:
        """Set target torques (n,), N·m at the motor shaft in the bench's direction."""
        ...

    def prepare(self, n: int) -> None:
        """Write control word and mode into the next n cycles; without torque set values are zero."""
        ...

    def digest(self, n: int) -> int:
        """Take the n cycles just exchanged; number of cycles for which the goal held."""
        ...

    def verify(self, sdo: Any) -> Sequence[str]:
        """Read the drive's limits again by what :meth:`Bus.sdo` gave; one sentence for each that is not kept."""
        ...

    def snapshot(self) -> Any:
        """Return a token of goal and state, for a replay."""
        ...

    def restore(self, token: Any) -> None:
        """Return to a snapshot."""
        ...


class AnalogInput(Device, Protocol):
    """One channel of an analogue input terminal: the torque sensor's."""

    @property
    def volt_per_count(self) -> float:
        """Scale of a count, V."""
        ...

    def usable(self, n: int) -> NDArray[np.bool_]:
        """Mask (n,) of readings that are within range and the terminal vouches for."""
        ...


class SafetyInputs(Device, Protocol):
    """Digital inputs of emergency stop and safe torque off, in one entry of process data."""

    @property
    def entry(self) -> str:
        """Process data entry of the inputs, such as 6000:01."""
        ...

    @property
    def names(self) -> Sequence[str]:
        """Names of the inputs, from bit 0."""
        ...

    @property
    def active_low(self) -> Sequence[str]:
        """Inputs that say "on" with 0 V."""
        ...

    def read(self, name: str, n: int) -> NDArray[np.bool_]:
        """Return where an input says "on" (n,)."""
        ...
