"""The table of channels: what a recording may hold, in which SI unit, and where on a bench each comes from.

Drivers return entries by object index, in the integers the device gave; this table is the one place that says which
entry is which channel. Scale, offset and sign are not here: they follow from the bench configuration
(:mod:`bench.cycle.channels`). Sign conventions are those of the recording format.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Presence(Enum):
    """How a channel belongs to a recording."""

    REQUIRED = "required"
    """The bench records it always; only an import may lack it."""
    OPTIONAL = "optional"
    """Recorded where the bench has it."""


@dataclass(frozen=True, slots=True)
class Signal:
    """One channel of a recording.

    Attributes
    ----------
    name : dataset name in the group ``channels``.
    unit : SI unit of raw · scale + offset (temperatures in °C, as the format has them).
    description : one line for people.
    dtype : NumPy name of the integers as they stand in the file.
    presence : whether the bench always records it.
    quantity : kind of value, ``angle``, ``velocity``, ``torque``, ``temperature``, ``time``, ``count`` or ``word``.
    """

    name: str
    unit: str
    description: str
    dtype: str
    presence: Presence
    quantity: str


_R, _O = Presence.REQUIRED, Presence.OPTIONAL

SIGNALS: tuple[Signal, ...] = (
    Signal("time", "s", "time since the first sample", "int64", _R, "time"),
    Signal("motor_angle", "rad", "input motor shaft angle, unwrapped", "int64", _R, "angle"),
    Signal("load_angle", "rad", "load-side angle q, unwrapped", "int64", _R, "angle"),
    Signal("motor_velocity", "rad/s", "input motor shaft velocity, as its drive reports it", "int32", _R, "velocity"),
    Signal("motor_torque", "N·m", "input motor torque at its shaft, as its drive reports it", "int16", _R, "torque"),
    Signal(
        "load_torque",
        "N·m",
        "torque sensor: gearbox output on the load side, positive towards +q",
        "int16",
        _R,
        "torque",
    ),
    Signal(
        "load_motor_torque",
        "N·m",
        "load motor torque, as its drive reports it; positive where it opposes motion towards +q",
        "int16",
        _R,
        "torque",
    ),
    Signal("temperature", "°C", "gearbox lubricant (PT100), the last reading held", "int16", _R, "temperature"),
    Signal("cycle", "1", "bus cycle counter; a lost cycle leaves no row", "int64", _R, "count"),
    Signal("ambient_temperature", "°C", "surrounding air, the last reading held", "int16", _O, "temperature"),
    Signal("load_velocity", "rad/s", "load-side velocity, as the load drive reports it", "int32", _O, "velocity"),
    Signal("motor_velocity_setpoint", "rad/s", "commanded input motor shaft velocity", "int32", _O, "velocity"),
    Signal("load_motor_torque_setpoint", "N·m", "commanded load motor torque", "int16", _O, "torque"),
    Signal("temperature_age", "s", "age of the held lubricant reading", "uint32", _O, "time"),
    Signal("motor_status", "1", "status word of the input drive (0x6041)", "uint16", _O, "word"),
    Signal("load_status", "1", "status word of the load drive (0x6041)", "uint16", _O, "word"),
    Signal(
        "safety_inputs",
        "1",
        "safety inputs as they are; as shipped bit 0 emergency stop and bit 1 safe torque off, 1 closed",
        "uint8",
        _O,
        "word",
    ),
    Signal("working_counter", "1", "working counter of the cycle", "uint16", _O, "count"),
)
"""Every channel the bench knows, in the order in which it stands in a recording."""

BY_NAME: dict[str, Signal] = {signal.name: signal for signal in SIGNALS}
REQUIRED: tuple[str, ...] = tuple(signal.name for signal in SIGNALS if signal.presence is Presence.REQUIRED)


@dataclass(frozen=True, slots=True)
class Source:
    """Where a channel comes from: a part's role on the bench and an entry of its process data.

    ``entry`` is the object as ``index:subindex`` in hexadecimal, as the drivers name it.
    """

    role: str
    entry: str


SOURCES: dict[str, Source] = {
    "motor_angle": Source("input_drive", "6064:00"),
    "motor_velocity": Source("input_drive", "606C:00"),
    "motor_torque": Source("input_drive", "6077:00"),
    "motor_status": Source("input_drive", "6041:00"),
    "load_angle": Source("load_drive", "6064:00"),
    "load_velocity": Source("load_drive", "606C:00"),
    "load_motor_torque": Source("load_drive", "6077:00"),
    "load_status": Source("load_drive", "6041:00"),
    "load_torque": Source("torque_terminal", "6000:11"),
    "motor_velocity_setpoint": Source("input_drive", "60FF:00"),
    "load_motor_torque_setpoint": Source("load_drive", "6071:00"),
}
"""Channels read cycle by cycle from the process image; time, cycle and slow readings come from the rig itself."""
