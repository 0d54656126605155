"""Put a bench together: master, bus and drivers by the names in the bench file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from bench.configuration import BenchConfiguration
from bench.configuration.bus import Slave
from bench.cycle.plugins import DRIVERS, MASTERS, plugin
from bench.cycle.slow import SlowThermometer
from bench.errors import ConfigurationError, DeviceError

Device = Any
"""A driver found by entry point; what is used of it stands in docs/drivers (its class is not ours to import)."""


@dataclass(frozen=True, slots=True)
class Assembly:
    """The devices of a bench, not yet talking."""

    master: Device
    bus: Device
    input_drive: Device
    load_drive: Device
    torque_terminal: Device
    thermometer: Device
    block: int
    """Most cycles that are exchanged at once."""
    can_replay: bool
    """Whether the master can be put back to a snapshot."""


@contextmanager
def device_errors() -> Iterator[None]:
    """Turn what drivers raise into the bench's own error, sentence and all."""
    error_base: Any = plugin(DRIVERS, "error")
    try:
        yield
    except error_base as error:
        raise DeviceError(str(error)) from error


def assemble(bench: BenchConfiguration, *, seed: int, real_time: bool) -> Assembly:
    """Create master, drivers and bus of a bench file.

    ``seed`` drives the noise of an emulated plant; ``real_time`` paces an emulated bench like a real one.

    Raises
    ------
    ConfigurationError
        If a master or driver is not installed or an option is wrong.
    """
    with device_errors():
        devices = {slave.role: _device(bench, slave) for slave in bench.bus.slaves}
        thermometer = devices.get("temperature_terminal") or _slow_thermometer(bench)
    master = _master(bench, seed)
    takes_blocks = hasattr(master, "exchange_block")
    block = bench.bus.block if takes_blocks else bench.bus.cycles_at_once
    if takes_blocks and real_time:
        # a twentieth of a second: short enough for an operator, long enough for the clock of a desktop machine
        block = min(block, max(1, round(0.05 / bench.bus.cycle_time)))
    pacing = None if takes_blocks else plugin(DRIVERS, "absolute_deadlines")(bench.bus.cycle_time)
    bus = plugin(DRIVERS, "ethercat")(
        master,
        bench.bus.interface,
        [devices[slave.role].spec for slave in bench.bus.slaves],
        cycle_time_s=bench.bus.cycle_time,
        block_capacity=block,
        pacing=pacing,
    )
    return Assembly(
        master,
        bus,
        devices["input_drive"],
        devices["load_drive"],
        devices["torque_terminal"],
        thermometer,
        block,
        takes_blocks,
    )


def _master(bench: BenchConfiguration, seed: int) -> Device:
    factory = plugin(MASTERS, bench.bus.master)
    if bench.bus.master == "soem" or bench.bus.plant is None:
        return factory()
    try:
        return factory(bench.bus.plant, seed=seed, cycle_time_s=bench.bus.cycle_time)
    except (FileNotFoundError, ValueError) as error:
        raise ConfigurationError(f"bus.plant = {bench.bus.plant}: {error}") from error


def _slow_thermometer(bench: BenchConfiguration) -> SlowThermometer:
    make_reader = plugin(DRIVERS, "background_reader")
    wanted = sorted(bench.bus.slow_sensors, key=lambda sensor: sensor.role != "temperature")
    readers = [
        make_reader(plugin(DRIVERS, sensor.driver)(sensor.role, sensor.options), sensor.period) for sensor in wanted
    ]
    return SlowThermometer(readers, bench.bus.cycle_time)


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a device is and what it must be, as driver factories expect it."""

    name: str
    position: int
    vendor: int
    product: int
    revision: int | None
    cycle_time_s: float


def _device(bench: BenchConfiguration, slave: Slave) -> Device:
    place = _Place(slave.role, slave.position, slave.vendor, slave.product, slave.revision, bench.bus.cycle_time)
    options: dict[str, Any] = dict(slave.options)
    if slave.role in ("input_drive", "load_drive"):
        options |= _drive_options(bench, slave)
    return plugin(DRIVERS, slave.driver)(place, options)


def _drive_options(bench: BenchConfiguration, slave: Slave) -> dict[str, Any]:
    is_input = slave.role == "input_drive"
    motor = bench.input_motor if is_input else bench.load_motor
    encoder = bench.input_encoder if is_input else bench.load_encoder
    limits = bench.limits
    speed = limits.motor_speed if is_input else limits.motor_speed / bench.gearbox.ratio
    return {
        "polarity": slave.polarity,
        "torque_polarity": slave.torque_polarity or slave.polarity,
        "counts_per_turn": float(2**encoder.bits),
        "rated_torque_nm": motor.nominal_torque,
        "limits": {
            "torque_nm": limits.motor_torque if is_input else limits.load_motor_torque,
            # the drive's own limit acts a little above ours, so that ours is the one that explains itself
            "speed_rad_s": min(motor.maximum_speed, 1.1 * speed),
            "quick_stop_deceleration_rad_s2": bench.motion.quick_stop_deceleration
            / (1.0 if is_input else bench.gearbox.ratio),
        },
    }
