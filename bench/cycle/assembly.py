"""Put a bench together: master, bus and drivers by the names in the bench file."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from bench.configuration import BenchConfiguration
from bench.configuration.bus import OPTIONAL_ROLES, Slave
from bench.cycle.plugins import DRIVERS, MASTERS, plugin
from bench.cycle.slow import SlowThermometer
from bench.devices import (
    AnalogInput,
    BlockBus,
    Bus,
    Drive,
    Master,
    ProcessBus,
    SafetyInputs,
    SlaveSpec,
    Thermometer,
)
from bench.errors import ConfigurationError, DeviceError

_CATCH_UP_S = 0.5


@dataclass(frozen=True, slots=True)
class Assembly:
    """The devices of a bench, not yet talking."""

    master: Master
    block_bus: BlockBus | None
    """The bus, where it cycles only while it is asked to."""
    process_bus: ProcessBus | None
    """The bus, where it has a process of its own."""
    input_drive: Drive
    load_drive: Drive
    torque_terminal: AnalogInput
    thermometer: Thermometer
    safety: SafetyInputs | None
    """Digital inputs of emergency stop and safe torque off, where the bench has them."""
    block: int
    """Most cycles that are exchanged at once."""
    can_replay: bool
    """Whether the master can be put back to a snapshot."""
    ahead: int = 0
    """Cycles for which set values are kept ahead of the bus, where it has a process of its own; else 0."""

    @property
    def bus(self) -> Bus:
        """The one bus, whoever cycles it."""
        bus = self.block_bus if self.process_bus is None else self.process_bus
        if bus is None:
            raise DeviceError("the bench was put together without a bus; it should have one")
        return bus


@contextmanager
def device_errors() -> Iterator[None]:
    """Turn what drivers raise into the bench's own error, sentence and all."""
    error_base: Any = plugin(DRIVERS, "error")
    try:
        yield
    except error_base as error:
        raise DeviceError(str(error)) from error


def assemble(bench: BenchConfiguration, *, seed: int, real_time: bool, own_process: bool | None = None) -> Assembly:
    """Create master, drivers and bus of a bench file.

    ``seed`` drives the noise of an emulated plant; ``real_time`` paces an emulated bench like a real one.
    ``own_process`` runs the bus in a process of its own; None: whenever its master runs by the clock.

    Raises
    ------
    ConfigurationError
        If a master or driver is not installed or an option is wrong.
    """
    with device_errors():
        devices = {slave.role: _device(bench, slave) for slave in bench.bus.slaves}
        thermometer = devices.get("temperature_terminal") or _slow_thermometer(bench)
    factory, arguments = _master(bench, seed)
    master = _make_master(bench, factory, arguments)
    takes_blocks = hasattr(master, "exchange_block")
    apart = not takes_blocks if own_process is None else own_process
    specs: list[SlaveSpec] = [devices[slave.role].spec for slave in bench.bus.slaves]
    block_bus: BlockBus | None = None
    process_bus: ProcessBus | None = None
    if apart:
        block, process_bus = bench.bus.cycles_at_once, _bus_process(bench, factory, arguments, specs)
    else:
        block = bench.bus.block
        if real_time:
            # a twentieth of a second: short enough for an operator, long enough for the clock of a desktop machine
            block = min(block, max(1, round(0.05 / bench.bus.cycle_time)))
        block_bus = plugin(DRIVERS, "ethercat")(
            master, bench.bus.interface, specs, cycle_time_s=bench.bus.cycle_time, block_capacity=block
        )
    return Assembly(
        master,
        block_bus,
        process_bus,
        devices["input_drive"],
        devices["load_drive"],
        devices["torque_terminal"],
        thermometer,
        devices.get("safety_terminal"),
        block,
        can_replay=not apart,
        ahead=max(block, round(bench.bus.ahead / bench.bus.cycle_time)) if apart else 0,
    )


def _bus_process(
    bench: BenchConfiguration, factory: Any, arguments: dict[str, Any], specs: Sequence[SlaveSpec]
) -> ProcessBus:
    bus: ProcessBus = plugin(DRIVERS, "ethercat_process")(
        f"{factory.__module__}:{factory.__qualname__}",
        bench.bus.interface,
        specs,
        cycle_time_s=bench.bus.cycle_time,
        # a rig that was late catches up in one go
        block_capacity=max(bench.bus.cycles_at_once, round(_CATCH_UP_S / bench.bus.cycle_time)),
        real_time=plugin(DRIVERS, "real_time")(bench.bus.priority, bench.bus.processor),
        arguments=arguments,
        make_up_s=bench.bus.make_up,
    )
    return bus


def _master(bench: BenchConfiguration, seed: int) -> tuple[Any, dict[str, Any]]:
    """Return the factory of the master and what it is called with."""
    factory = plugin(MASTERS, bench.bus.master)
    if bench.bus.master == "soem" or bench.bus.plant is None:
        return factory, {}
    without = [role for role in OPTIONAL_ROLES if bench.bus.slave(role) is None]
    return factory, {
        "plant": bench.bus.plant,
        "seed": seed,
        "cycle_time_s": bench.bus.cycle_time,
        **({"without": without} if without else {}),
    }


def _make_master(bench: BenchConfiguration, factory: Callable[..., Any], arguments: dict[str, Any]) -> Master:
    try:
        master: Master = factory(**arguments)
    except (FileNotFoundError, ValueError) as error:
        raise ConfigurationError(f"bus.plant = {bench.bus.plant}: {error}") from error
    return master


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


def _device(bench: BenchConfiguration, slave: Slave) -> Any:
    """Return the driver of a slave: of its class nothing is known here, its role says what is used of it."""
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
        "watchdog_s": bench.bus.watchdog,
        "limits": {
            "torque_nm": limits.motor_torque if is_input else limits.load_motor_torque,
            # the drive's own limit acts a little above ours, so that ours is the one that explains itself
            "speed_rad_s": min(motor.maximum_speed, 1.1 * speed),
            "following_error_rad": None
            if limits.following_error is None
            else limits.following_error / (1.0 if is_input else bench.gearbox.ratio),
            # a fault may be the encoder's, and then a drive that ramps down runs away: friction brakes instead
            "fault_reaction": "disable",
            "quick_stop_deceleration_rad_s2": bench.motion.quick_stop_deceleration
            / (1.0 if is_input else bench.gearbox.ratio),
        },
    }
