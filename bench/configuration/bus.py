"""The bus of a bench: its master, its cycle, and its slaves in their order."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from bench.configuration.parts import Section
from bench.configuration.quantities import Time

Role = Literal["input_drive", "load_drive", "torque_terminal", "temperature_terminal", "safety_terminal"]
REQUIRED_ROLES: tuple[Role, ...] = ("input_drive", "load_drive", "torque_terminal")
OPTIONAL_ROLES: tuple[Role, ...] = ("temperature_terminal", "safety_terminal")


class Slave(Section):
    """One slave: which part of the bench it is, which driver serves it, and the identity it must show (0x1018)."""

    role: Role
    driver: str
    position: Annotated[int, Field(ge=1)]
    vendor: Annotated[int, Field(ge=0, le=0xFFFFFFFF)]
    product: Annotated[int, Field(ge=0, le=0xFFFFFFFF)]
    revision: Annotated[int, Field(ge=0, le=0xFFFFFFFF)] | None = None
    """Required revision; absent: any."""
    polarity: Literal[-1, 1] = 1
    """Sign of motion in the drive's own frame against the bench's; the two motors face each other."""
    torque_polarity: Literal[-1, 1] | None = None
    """The same for torque; absent: as motion. The bench counts the load motor's torque against motion."""
    options: dict[str, Any] = Field(default_factory=dict)
    """Handed to the driver as they are; the driver refuses what it does not know."""


class SlowSensor(Section):
    """A sensor beside the bus, read now and then (Modbus or serial)."""

    role: Literal["temperature", "ambient_temperature"]
    driver: str
    period: Annotated[Time, Field(gt=0)]
    options: dict[str, Any] = Field(default_factory=dict)


class Bus(Section):
    """EtherCAT segment. ``master`` names an entry point of the group ``bench.masters``."""

    master: str
    interface: str
    plant: str | None = None
    """For an emulated bench, the name of the plant that plays it; never its parameters."""
    cycle_time: Annotated[Time, Field(ge=1e-4, le=0.1)]
    watchdog: Annotated[Time, Field(gt=0, le=1.0)] = 0.1
    """Without process data for so long a slave leaves OPERATIONAL by itself (register 0x0420); set and read back."""
    block: Annotated[int, Field(ge=1, le=100_000)]
    """Cycles between two looks of the safety step on a master that takes blocks and can go back to replay."""
    cycles_at_once: Annotated[int, Field(ge=1, le=100)] = 1
    """The same on hardware, which cannot go back: one reacts fastest, a few leave the processor time."""
    ahead: Annotated[Time, Field(gt=0, le=1.0)] = 0.1
    """On hardware: set values for so long are with the bus process already; a stop drops them at once."""
    hold: Annotated[Time, Field(gt=0, le=0.5)] = 0.05
    """On hardware: without new set values the last ones are held for so long, then the bus process stops the drives."""
    make_up: Annotated[Time, Field(ge=0, le=0.05)] = 0.0
    """Cycles that could not begin in their slot are begun up to so much later; 0: left out. For slaves that wait."""
    priority: Annotated[int, Field(ge=1, le=98)] = 80
    """Real-time priority (SCHED_FIFO) of the bus process."""
    processor: Annotated[int, Field(ge=0)] | None = None
    """Processor the bus process is pinned to; absent: an isolated one, if there is any."""
    slaves: tuple[Slave, ...]
    slow_sensors: tuple[SlowSensor, ...] = ()

    @model_validator(mode="after")
    def _check_roles(self) -> Bus:
        roles = [slave.role for slave in self.slaves]
        for role in REQUIRED_ROLES:
            if roles.count(role) != 1:
                raise ValueError(f"slaves must hold exactly one {role}, there are {roles.count(role)}")
        has_temperature = roles.count("temperature_terminal") + sum(s.role == "temperature" for s in self.slow_sensors)
        if has_temperature != 1:
            raise ValueError(
                "the lubricant needs exactly one sensor: a slave with role temperature_terminal or a slow sensor with"
                f" role temperature, there are {has_temperature}"
            )
        for role in OPTIONAL_ROLES:
            if roles.count(role) > 1:
                raise ValueError(f"slaves may hold one {role}, there are {roles.count(role)}")
        positions = [slave.position for slave in self.slaves]
        if positions != list(range(1, len(positions) + 1)):
            raise ValueError(f"slaves must stand in the order of the bus, positions 1 to {len(positions)}")
        if self.master == "emulated" and self.plant is None:
            raise ValueError("an emulated master needs the name of its plant (key plant)")
        return self

    @property
    def in_process(self) -> bool:
        """Whether the bench is emulated in the program's own process, and so ends with it."""
        return self.master == "emulated"

    def slave(self, role: Role) -> Slave | None:
        """Return the slave of a role, or None where the bench has none."""
        return next((slave for slave in self.slaves if slave.role == role), None)
