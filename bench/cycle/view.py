"""What may be asked of a bench in operation by anybody: no method here sends anything."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Protocol

from bench.configuration import BenchConfiguration
from bench.cycle.channels import Scaling, Zeros
from bench.cycle.link import Link
from bench.cycle.stop.stops import Stops
from bench.errors import DeviceError
from bench.safety import LatchFile, StopRecord


class FoundZero(Protocol):
    """The common zero of both encoders: its name, and what it takes off the motor's angle, rad."""

    @property
    def zero_id(self) -> str:
        """Its name."""
        ...

    @property
    def motor_angle(self) -> float:
        """Subtracted from the motor's angle beyond the bench file's zero, rad."""
        ...


class View:
    """The read-only side of a rig.

    Parameters
    ----------
    bench : the bench file.
    link : to the devices.
    real_time : an emulated bench is paced by the clock.
    zero_id : name of the encoders' zero.
    latch : where stops are remembered.
    """

    def __init__(
        self, bench: BenchConfiguration, link: Link, real_time: bool, zero_id: str | None, latch: LatchFile
    ) -> None:
        self.bench, self.zero_id = bench, zero_id
        self._link, self._real_time = link, real_time
        self._stops = Stops(self, latch)
        self._started = datetime.now(UTC)

    @property
    def link(self) -> Link:
        """The devices, without limits and ladder: for commissioning."""
        return self._link

    @property
    def latch(self) -> LatchFile:
        """What is remembered of stops: after one there is no torque until its three acts are done."""
        return self._stops.latch

    @property
    def stops(self) -> tuple[StopRecord, ...]:
        """Records of the stops since the bench was opened."""
        return tuple(self._stops.records)

    def report_stops_to(self, listener: Callable[[StopRecord], None]) -> None:
        """Call ``listener`` with the record of each stop as soon as it is over."""
        self._stops.on_stop = listener

    @property
    def source(self) -> str:
        """``emulator`` or ``hardware``, for the recordings."""
        return "emulator" if self.bench.bus.plant is not None else "hardware"

    @property
    def scaling(self) -> Scaling:
        """Scale and offset of every channel; known once the bench is open."""
        return self._link.scaling

    @property
    def zeros(self) -> Zeros:
        """What is subtracted from encoders and torque sensor."""
        return self._link.zeros

    @property
    def temperature(self) -> float:
        """Last lubricant temperature, °C."""
        if self._link.last is None:
            raise DeviceError("the bench has not been read yet; open it first")
        return float(self._link.last.inputs.temperature[-1])

    @property
    def elapsed_s(self) -> float:
        """Bench time since it was opened."""
        return self._link.cycle * self.bench.bus.cycle_time

    @property
    def now(self) -> datetime:
        """Time of day on the bench, UTC: bench time, which in fast emulation runs ahead of the clock."""
        return self._started + timedelta(seconds=self.elapsed_s)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the bus process was not granted, in sentences; empty where there is nothing to say."""
        process = self._link.assembly.process_bus
        return () if process is None else process.notes

    @property
    def is_real_time(self) -> bool:
        """Whether bench time is the clock's."""
        return self._real_time or not self._link.assembly.can_replay

    @property
    def set_values(self) -> tuple[float, float]:
        """Load-side velocity in rad/s and load torque in N·m as last commanded."""
        return self._link.velocity, self._link.torque

    @property
    def sent_values(self) -> tuple[float, float]:
        """Load-side velocity in rad/s and load torque in N·m as last sent; none where the bus process has stopped."""
        return self._link.sent_values if self._link.stopped() is None else (0.0, 0.0)

    @property
    def has_torque(self) -> bool:
        """Whether the drives were asked for torque last, and may have it."""
        return self._link.drives.asked_for("ENABLED")

    def drives_off(self) -> bool:
        """Whether both drives say that they have no voltage."""
        return self._link.drives.reached("DISABLED")

    @property
    def drive_states(self) -> dict[str, str]:
        """State of each drive's state machine (CiA 402) as of the last cycle, by role."""
        return self._link.drives.states()
