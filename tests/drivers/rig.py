"""The devices of the emulated bench behind their drivers, as tests of several kinds need them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drivers.cia402 import CST, CSV, DriveLimits, QuickStopOption, ServoDrive, ServoDriveConfig
from drivers.devices import Place
from drivers.digital_input import DigitalInput
from drivers.ethercat import EtherCatBus, Exchange
from drivers.pt100 import Pt100Terminal
from drivers.torque_sensor import AnalogInput

VENDOR = 0xE0000B3C
WATCHDOG_S = 0.02
INPUT = ServoDriveConfig(
    "input_drive",
    1,
    VENDOR,
    0x04020D01,
    CSV,
    DriveLimits(40.0, 300.0, quick_stop=QuickStopOption.QUICK_STOP_RAMP_AND_STAY),
    counts_per_turn=8192.0,
    rated_torque_nm=17.5,
    watchdog_s=WATCHDOG_S,
)
LOAD = ServoDriveConfig(
    "load_drive",
    2,
    VENDOR,
    0x04021902,
    CST,
    DriveLimits(1400.0, 10.0),
    polarity=-1,
    torque_polarity=1,
    counts_per_turn=float(1 << 25),
    rated_torque_nm=1650.0,
    watchdog_s=WATCHDOG_S,
)


@dataclass
class Rig:
    """Drivers on a bus."""

    bus: EtherCatBus
    input_drive: ServoDrive
    load_drive: ServoDrive
    torque: AnalogInput
    thermometer: Pt100Terminal
    safety: DigitalInput

    @property
    def drives(self) -> list[ServoDrive]:
        return [self.input_drive, self.load_drive]

    def start(self) -> None:
        """From closed to OP, drives still without voltage."""
        self.bus.open()
        self.bus.configure()
        for device in (*self.drives, self.torque, self.thermometer, self.safety):
            name = device.spec.name
            device.attach(self.bus.outputs.get(name), self.bus.inputs.get(name))
        self.bus.to_operational()

    def run(self, velocity: float, torque: float, n: int) -> Exchange:
        """One block at constant set values."""
        self.input_drive.set_velocity(velocity, n)
        self.load_drive.set_torque(torque, n)
        for drive in self.drives:
            drive.prepare(n)
        exchange = self.bus.exchange(n)
        for drive in self.drives:
            drive.digest(n)
        return exchange

    def images(self, n: int) -> dict[str, np.ndarray[Any, Any]]:
        """Copies of the inputs of the block just exchanged."""
        return {name: rows[:n].copy() for name, rows in self.bus.inputs.items()}


def make_devices(
    watchdog_s: float = WATCHDOG_S, sync0_shift_ns: int | None = None
) -> tuple[ServoDrive, ServoDrive, AnalogInput, Pt100Terminal, DigitalInput]:
    """Drivers of the emulated bench, in the order of its bus."""
    return (
        ServoDrive(replace(INPUT, watchdog_s=watchdog_s, sync0_shift_ns=sync0_shift_ns)),
        ServoDrive(replace(LOAD, watchdog_s=watchdog_s, sync0_shift_ns=sync0_shift_ns)),
        AnalogInput(Place("torque_terminal", 3, VENDOR, 0x0A160102)),
        Pt100Terminal(Place("temperature_terminal", 4, VENDOR, 0x52540202), channels=2),
        DigitalInput(Place("safety_terminal", 5, VENDOR, 0x0D160802), ("emergency_stop", "safe_torque_off"), coe=True),
    )


def make_rig(
    master: Any,
    interface: str = "emulated",
    watchdog_s: float = WATCHDOG_S,
    sync0_shift_ns: int | None = None,
    **options: Any,
) -> Rig:
    """Drivers of the emulated bench on a master of pysoem's API."""
    devices = make_devices(watchdog_s, sync0_shift_ns)
    bus = EtherCatBus(master, interface, [device.spec for device in devices], **options)
    return Rig(bus, *devices)
