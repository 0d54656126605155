"""PT100 transmitters beside a bench that runs in real time: in a process of their own, fed through shared memory.

The process that answers EtherCAT frames runs nothing else; it stores the PT100 readings in two shared numbers, and the
transmitters read them when they are asked.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.sharedctypes import SynchronizedArray
from pathlib import Path
from typing import Any

from fakes.modbus import LineFault, ModbusTransmitter
from fakes.pt100 import Wiring
from fakes.serial_device import SerialDevice
from fakes.serial_line import Cable

PSEUDO_TERMINAL = "pty"
START_TIMEOUT_S = 20.0


@dataclass(frozen=True, slots=True)
class SlowDeviceOptions:
    """Which transmitters there are; None where there is none.

    ``modbus_rtu`` is ``pty``, the path of a real serial port, or a path that does not exist and becomes a link to a
    pseudo-terminal; ``serial`` likewise without real ports; ``modbus_tcp`` a port number (0: any).
    """

    modbus_rtu: str | None = None
    modbus_tcp: int | None = None
    serial: str | None = None

    @property
    def any(self) -> bool:
        """Whether there is one at all."""
        return (self.modbus_rtu, self.modbus_tcp, self.serial) != (None, None, None)


class SharedSource:
    """Readings from the shared numbers, °C by channel."""

    def __init__(self, numbers: Any) -> None:
        self._numbers = numbers

    def celsius(self, channel: int) -> float:
        """Return the reading of a channel in °C."""
        return float(self._numbers[channel])


_LINE_FAULTS: dict[str, LineFault] = {
    "modbus_crc": LineFault.CRC,
    "modbus_silence": LineFault.SILENCE,
    "modbus_wrong_device": LineFault.WRONG_DEVICE,
    "modbus_exception": LineFault.EXCEPTION,
}
NAMES: tuple[str, ...] = (*_LINE_FAULTS, "serial_unplugged", "serial_silent", "transmitter_open", "transmitter_short")
"""Faults of the transmitters."""


class SlowDevices:
    """The transmitters of one process."""

    def __init__(self, options: SlowDeviceOptions, source: SharedSource, closing: ExitStack) -> None:
        self.modbus: list[ModbusTransmitter] = []
        self.serial: SerialDevice | None = None
        self.places: dict[str, str | int] = {}
        if options.modbus_rtu is not None:
            port = options.modbus_rtu
            if port == PSEUDO_TERMINAL or not Path(port).exists():
                cable = Cable()
                closing.callback(cable.close)
                self.places["modbus_rtu"] = _name(cable.far, port, closing)
                port = cable.near
            else:
                self.places["modbus_rtu"] = port
            self.modbus.append(ModbusTransmitter.rtu(source, port))
        if options.modbus_tcp is not None:
            self.modbus.append(ModbusTransmitter.tcp(source, port=options.modbus_tcp))
            self.places["modbus_tcp"] = self.modbus[-1].port
        for server in self.modbus:
            closing.callback(server.close)
        if options.serial is not None:
            self.serial = SerialDevice(source)
            closing.callback(self.serial.close)
            self.places["serial"] = _name(self.serial.port, options.serial, closing)

    def switch(self, name: str, on: bool) -> None:
        """Switch a fault of :data:`NAMES`."""
        if name in _LINE_FAULTS:
            for server in self.modbus:
                server.fault = _LINE_FAULTS[name] if on else LineFault.NONE
        elif name.startswith("transmitter_"):
            wiring = Wiring(name.removeprefix("transmitter_")) if on else Wiring.GOOD
            for transmitter in (t for server in self.modbus for t in server.transmitters[:1]):
                transmitter.wiring = wiring
            if self.serial is not None:
                self.serial.transmitter.wiring = wiring
        elif self.serial is not None and name == "serial_silent":
            self.serial.silent = on
        elif self.serial is not None and on:
            self.serial.unplug()


def _name(device: str, wanted: str, closing: ExitStack) -> str:
    """Return the name to open: the device itself, or the link that was asked for."""
    if wanted == PSEUDO_TERMINAL:
        return device
    os.symlink(device, wanted)
    closing.callback(os.unlink, wanted)
    return wanted


def _serve(options: SlowDeviceOptions, numbers: Any, pipe: Connection) -> None:
    """Serve until the other end of the pipe closes."""
    with ExitStack() as closing:
        devices = SlowDevices(options, SharedSource(numbers), closing)
        pipe.send(devices.places)
        while True:
            try:
                name, on = pipe.recv()
            except EOFError:
                return
            devices.switch(name, on)


@dataclass(frozen=True, slots=True)
class SlowDeviceProcess:
    """Handle on the process: where the transmitters are, the shared readings, and the switch of their faults."""

    places: Mapping[str, str | int]
    readings: SynchronizedArray[float]
    switch: Callable[[str, bool], None]


@contextmanager
def slow_devices(options: SlowDeviceOptions) -> Iterator[SlowDeviceProcess]:
    """Run transmitters in a process of their own as long as the context lasts."""
    context = multiprocessing.get_context("spawn")
    numbers = context.Array("d", [20.0, 20.0])
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(options, numbers, there), name="slow devices", daemon=True)
    process.start()
    there.close()
    try:
        if not here.poll(START_TIMEOUT_S):
            raise TimeoutError(f"the PT100 transmitters did not start within {START_TIMEOUT_S:g} s")
        places = here.recv()
        yield SlowDeviceProcess(places, numbers, lambda name, on: here.send((name, on)))
    finally:
        here.close()
        process.join(START_TIMEOUT_S)


def transmitters(**options: Any) -> Any:
    """Return the context of :func:`slow_devices` for these options (entry point of ``bench.emulators``)."""
    return slow_devices(SlowDeviceOptions(**options))
