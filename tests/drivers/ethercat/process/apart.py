"""The drivers on a bus process, whose master is the stand-in on a plant of one line."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from drivers.cia402 import Goal
from drivers.cia402.protection import protection
from drivers.ethercat.process import RealTime, RemoteBus
from fakes.ethercat.master import EmulatedMaster
from tests.drivers.rig import make_devices
from tests.fakes.ethercat.simple_plant import simple_bench

ROOT = Path(__file__).parents[4]
ORDINARY = RealTime(priority=None, lock_memory=False)
"""Tests are not worth delaying anything else for."""
PATIENCE_S = 20.0


def simple_master() -> EmulatedMaster:
    """What the bus process calls for its master."""
    return EmulatedMaster(simple_bench())


MASTER = f"{__name__}:{simple_master.__name__}"


class Apart:
    """Drives, terminals, and the process that has the bus."""

    def __init__(self, bus: RemoteBus, devices: Any) -> None:
        self.bus, self.devices, self.drives = bus, devices, devices[:2]

    def start(self) -> None:
        """From closed to OP; the process knows how to stop the drives."""
        self.bus.open()
        self.bus.configure()
        for device in self.devices:
            name = device.spec.name
            device.attach(self.bus.outputs.get(name), self.bus.inputs.get(name))
        self.bus.protect(protection(self.bus, self.drives, 2.0, 1.0, 0.01, 200))
        self.bus.to_operational()

    def fresh(self) -> Apart:
        """The same, following set values again with the drives off, whatever a test before did."""
        self.bus.arm(0)
        self.bus.protect(protection(self.bus, self.drives, 2.0, 1.0, 0.01, 200))
        self.bus.flush()
        if self.bus.stopped is not None:
            self.until(lambda _: not self.status() & 0x04)
            self.bus.resume()
            self.until(lambda _: self.bus.stopped is None)
        return self

    def give(self, velocity: float, n: int) -> int:
        """Hand over n cycles at a speed."""
        self.drives[0].set_velocity(velocity, n)
        self.drives[1].set_torque(0.0, n)
        for drive in self.drives:
            drive.prepare(n)
        return self.bus.submit(n)

    def take(self, least: int = 1) -> Any:
        """Collect, with the drives looking."""
        exchange = self.bus.collect(least)
        for drive in self.drives:
            drive.digest(exchange.n_done)
        return exchange

    def enable(self) -> None:
        """Both drives to operation enabled, and the process armed."""
        for drive in self.drives:
            drive.request(Goal.ENABLED, 10.0)
        end = time.monotonic() + PATIENCE_S
        while any(drive.sequence.outcome.name != "REACHED" for drive in self.drives):
            self.give(0.0, 10)
            self.take(10)
            for drive in self.drives:
                drive.check()
            assert time.monotonic() < end

    def until(self, wanted: Any) -> Any:
        """Collect until something holds of an exchange; return that."""
        end = time.monotonic() + PATIENCE_S
        while True:
            exchange = self.take()
            assert exchange.n_done, self.bus.ended
            if wanted(exchange):
                return exchange
            assert time.monotonic() < end

    def status(self) -> int:
        """Status word of the input drive in the cycle collected last."""
        return int(self.bus.inputs["input_drive"]["6041:00"][len(self.bus.meta) - 1])


@contextmanager
def apart(master: str = MASTER, interface: str = "emulated", **options: Any) -> Iterator[Apart]:
    """A bus process for a while; four slaves unless devices are said."""
    devices = make_devices(0.1)[: options.pop("slaves", 4)]
    before = Path.cwd()
    os.chdir(ROOT)  # the process finds this module from there
    try:
        bus = RemoteBus(
            master,
            interface,
            [device.spec for device in devices],
            block_capacity=options.pop("block_capacity", 1000),
            real_time=ORDINARY,
            **options,
        )
        made = Apart(bus, devices)
        try:
            made.start()
            yield made
        finally:
            bus.close()
    finally:
        os.chdir(before)
