"""From raw entries to channels: scale, offset and sign of each, by the bench file and the drives' own units."""

from __future__ import annotations

from dataclasses import dataclass

from bench.configuration import BenchConfiguration
from bench.recording import ChannelSpec
from bench.signals import SOURCES


@dataclass(frozen=True, slots=True)
class DriveScales:
    """One count of a drive at its shaft, in its own frame: rad, rad/s, N·m."""

    position: float
    velocity: float
    torque: float


@dataclass(frozen=True, slots=True)
class Zeros:
    """What is subtracted from a channel: the encoders' common zero (rad) and the torque sensor's tare (N·m)."""

    motor_angle: float = 0.0
    load_angle: float = 0.0
    load_torque: float = 0.0


@dataclass(frozen=True, slots=True)
class Scaling:
    """SI = raw · scale + offset of every channel the bench records."""

    specs: dict[str, ChannelSpec]

    def scale(self, name: str) -> float:
        """Return the factor of a channel."""
        return self.specs[name].scale

    def offset(self, name: str) -> float:
        """Return the offset of a channel."""
        return self.specs[name].offset


def origin(channel: str) -> str:
    """Return where a channel comes from, such as ``input_drive/0x6064``."""
    source = SOURCES[channel]
    index, subindex = source.entry.split(":")
    return f"{source.role}/0x{index}" + (f":{subindex}" if subindex != "00" else "")


def make_scaling(
    bench: BenchConfiguration,
    input_drive: DriveScales,
    load_drive: DriveScales,
    volts_per_count: float,
    celsius_per_count: float,
    temperature_dtype: str,
    has_ambient: bool,
    zeros: Zeros,
) -> Scaling:
    """Return the scaling of every channel of a bench."""
    slaves = {slave.role: slave for slave in bench.bus.slaves}
    motion_in, motion_load = slaves["input_drive"].polarity, slaves["load_drive"].polarity
    torque_in = slaves["input_drive"].torque_polarity or motion_in
    torque_load = slaves["load_drive"].torque_polarity or motion_load
    sensor = bench.torque_sensor
    torque_scale = volts_per_count * sensor.polarity * sensor.rated_torque / sensor.rated_voltage
    dt = bench.bus.cycle_time
    of = ChannelSpec.of
    on_bus = "temperature_terminal" in slaves
    lubricant = "temperature_terminal/0x6000:11" if on_bus else "temperature"
    ambient = "temperature_terminal/0x6010:11" if on_bus else "ambient_temperature"
    specs = [
        of("time", scale=dt, origin="bus/cycle"),
        of(
            "motor_angle",
            scale=motion_in * input_drive.position,
            offset=-zeros.motor_angle,
            origin=origin("motor_angle"),
        ),
        of(
            "load_angle",
            scale=motion_load * load_drive.position,
            offset=-zeros.load_angle,
            origin=origin("load_angle"),
        ),
        of("motor_velocity", scale=motion_in * input_drive.velocity, origin=origin("motor_velocity")),
        of("motor_torque", scale=torque_in * input_drive.torque, origin=origin("motor_torque")),
        of("load_torque", scale=torque_scale, offset=-zeros.load_torque, origin=origin("load_torque")),
        of("load_motor_torque", scale=torque_load * load_drive.torque, origin=origin("load_motor_torque")),
        of("temperature", dtype=temperature_dtype, scale=celsius_per_count, origin=lubricant),
        of("cycle", origin="bus/cycle"),
        of("load_velocity", scale=motion_load * load_drive.velocity, origin=origin("load_velocity")),
        of("motor_velocity_setpoint", scale=motion_in * input_drive.velocity, origin=origin("motor_velocity_setpoint")),
        of(
            "load_motor_torque_setpoint",
            scale=torque_load * load_drive.torque,
            origin=origin("load_motor_torque_setpoint"),
        ),
        of("temperature_age", scale=1e-3, origin=lubricant),
        of("motor_status", origin=origin("motor_status")),
        of("load_status", origin=origin("load_status")),
        of("working_counter", origin="bus/working_counter"),
    ]
    if "safety_terminal" in slaves:
        specs.insert(-1, of("safety_inputs", origin="safety_terminal/0x6000:01"))
    if has_ambient:
        specs.insert(9, of("ambient_temperature", dtype=temperature_dtype, scale=celsius_per_count, origin=ambient))
    return Scaling({spec.name: spec for spec in specs})
