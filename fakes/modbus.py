"""A PT100 transmitter on Modbus, RTU or TCP, built on pymodbus' server.

Input registers (function 4), 16 a channel: 0 status (bit 0 open, 1 short, 2 not valid), 1-2 temperature in °C and 3-4
resistance in Ω as float32 with the high word first, 5 a number that counts conversions. Channel 2 (surroundings)
follows at 16. An unknown device on the line is silent, as a real one is.
"""

from __future__ import annotations

import asyncio
import math
import struct
import threading
from collections.abc import Callable
from enum import Enum

from pymodbus import FramerType
from pymodbus.constants import ExcCodes
from pymodbus.pdu import ModbusPDU
from pymodbus.server import ModbusSerialServer, ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

from fakes.pt100 import Wiring
from fakes.thermometer import Reading, Source, Transmitter

REGISTERS_A_CHANNEL = 16
CHANNELS = 2
START_TIMEOUT_S = 5.0

_STATUS = {Wiring.GOOD: 0b000, Wiring.OPEN: 0b101, Wiring.SHORT: 0b110}


class LineFault(Enum):
    """What can be wrong with answers (``CRC`` on RTU only: TCP has none)."""

    NONE = "none"
    CRC = "crc"
    SILENCE = "silence"
    WRONG_DEVICE = "wrong_device"
    EXCEPTION = "exception"


def registers(reading: Reading) -> list[int]:
    """Return the registers of one channel; an open or short element gives NaN."""
    good = reading.wiring is Wiring.GOOD
    celsius, ohm = (reading.celsius, reading.ohm) if good else (math.nan, math.nan)
    words = struct.unpack(">4H", struct.pack(">2f", celsius, ohm))
    return [_STATUS[reading.wiring], *words, reading.conversion]


class ModbusTransmitter:
    """The transmitter; serving starts with construction and ends with :meth:`close`.

    ``fault`` and the wiring of ``transmitters`` may be changed while it serves.
    """

    def __init__(self, source: Source, device_id: int = 1, fault: LineFault = LineFault.NONE) -> None:
        self.fault = fault
        self.transmitters = tuple(Transmitter(source, channel) for channel in range(CHANNELS))
        self._device_id = device_id
        self._foreign = False
        self._loop = asyncio.new_event_loop()
        self._server: ModbusSerialServer | ModbusTcpServer | None = None
        self._thread = threading.Thread(target=self._loop.run_forever, name="Modbus PT100", daemon=True)
        self._thread.start()

    @classmethod
    def tcp(cls, source: Source, host: str = "127.0.0.1", port: int = 0, device_id: int = 1) -> ModbusTransmitter:
        """Serve on TCP; with port 0 the system chooses one, see :attr:`port`."""
        made = cls(source, device_id)
        made._start(
            lambda devices: ModbusTcpServer(
                devices,
                address=(host, port),
                ignore_missing_devices=True,
                trace_packet=made._packet,
                trace_pdu=made._pdu,
            )
        )
        return made

    @classmethod
    def rtu(cls, source: Source, port: str, baudrate: int = 19200, device_id: int = 1) -> ModbusTransmitter:
        """Serve on a serial port, such as one end of a :class:`~fakes.serial_line.Cable`."""
        made = cls(source, device_id)
        made._start(
            lambda devices: ModbusSerialServer(
                devices,
                framer=FramerType.RTU,
                port=port,
                baudrate=baudrate,
                ignore_missing_devices=True,
                trace_packet=made._packet,
                trace_pdu=made._pdu,
            )
        )
        return made

    @property
    def port(self) -> int:
        """TCP port it listens on."""
        transport = getattr(self._server, "transport", None)
        port: int = transport.sockets[0].getsockname()[1] if transport is not None else 0
        return port

    def close(self) -> None:
        """Stop serving."""
        if self._server is not None:
            stopping = self._server.shutdown()  # type: ignore[no-untyped-call]
            asyncio.run_coroutine_threadsafe(stopping, self._loop).result(START_TIMEOUT_S)
            self._server = None
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _start(self, make: Callable[[list[SimDevice]], ModbusSerialServer | ModbusTcpServer]) -> None:
        empty = [SimData(0, values=[0] * (REGISTERS_A_CHANNEL * CHANNELS), datatype=DataType.REGISTERS)]
        unused = [SimData(0, datatype=DataType.REGISTERS)]
        bits = [SimData(0, values=[False] * 16, datatype=DataType.BITS)]
        memory = (bits, bits, unused, empty)
        # pymodbus answers for unknown devices; one that stands for all of them lets us drop those answers.
        devices = [SimDevice(self._device_id, memory, action=self._refresh), SimDevice(0, memory)]

        async def serve() -> ModbusSerialServer | ModbusTcpServer:
            server = make(devices)
            await server.serve_forever(background=True)
            return server

        self._server = asyncio.run_coroutine_threadsafe(serve(), self._loop).result(START_TIMEOUT_S)

    async def _refresh(
        self,
        function: int,
        start: int,
        address: int,
        count: int,
        memory: list[int],
        values: list[int] | list[bool] | None,
    ) -> ExcCodes | None:
        """Put the present conversions into the registers before they are read."""
        if self.fault is LineFault.EXCEPTION:
            return ExcCodes.DEVICE_FAILURE
        for channel, transmitter in enumerate(self.transmitters if function == 4 else ()):
            fresh = registers(transmitter.read())
            at = channel * REGISTERS_A_CHANNEL
            memory[at : at + len(fresh)] = fresh
        return None

    def _packet(self, sending: bool, data: bytes) -> bytes:
        """Spoil what is sent, as the fault says."""
        if sending and (self._foreign or self.fault is LineFault.SILENCE):
            return b""
        if sending and self.fault is LineFault.CRC and isinstance(self._server, ModbusSerialServer):
            return data[:-1] + bytes([data[-1] ^ 0x5A])
        return data

    def _pdu(self, sending: bool, pdu: ModbusPDU) -> ModbusPDU:
        if sending:
            self._foreign = pdu.dev_id != self._device_id
        if sending and self.fault is LineFault.WRONG_DEVICE:
            pdu.dev_id = pdu.dev_id % 247 + 1
        return pdu
