"""PT100 transmitters on Modbus TCP and RTU; all that is known of pymodbus stands here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.exceptions import ModbusException

from drivers.devices import build
from drivers.errors import DriverError, SensorError
from drivers.pt100.measurement import Measurement, Range, from_resistance, from_temperature
from drivers.pt100.ports import PORT_ERRORS
from drivers.pt100.registers import RegisterMap

_TIMEOUT_S = 0.3
_RETRIES = 1
_EXCEPTIONS = {
    1: "illegal function",
    2: "illegal data address",
    3: "illegal data value",
    4: "device failure",
    5: "acknowledge",
    6: "device busy",
    10: "gateway path unavailable",
    11: "gateway target does not respond",
}
"""Modbus exception codes (MODBUS Application Protocol 1.1b3, chapter 7)."""

_FAILURES: tuple[type[Exception], ...] = (ModbusException, *PORT_ERRORS)
_Client = ModbusTcpClient | ModbusSerialClient


@dataclass(slots=True)
class ModbusThermometer:
    """One transmitter.

    Parameters
    ----------
    name : what the configuration calls it.
    client : pymodbus client; it is connected when first asked and again after a failure.
    device_id : address on the line.
    registers : where things are.
    limits : what is plausible.
    r0 : resistance at 0 °C, Ω.
    """

    name: str
    client: _Client
    device_id: int = 1
    registers: RegisterMap = field(default_factory=RegisterMap)
    limits: Range = field(default_factory=Range)
    r0: float = 100.0

    def measure(self) -> Measurement:
        """Ask the transmitter (at most two tries of 0.3 s).

        Raises
        ------
        SensorError
            If it does not answer, answers with an exception, or says open or short circuit.
        """
        registers = self.registers
        words: dict[int, int] = {}
        for first, count in registers.spans:
            words |= enumerate(self._read(first, count), first)
        if registers.status is not None:
            self._check_status(words[registers.status])
        value = self._value(words)
        conversion = None if registers.conversion is None else words[registers.conversion]
        if registers.quantity == "resistance":
            return from_resistance(self.name, value, self.limits, self.r0, conversion)
        return from_temperature(self.name, value, self.limits, conversion=conversion)

    def close(self) -> None:
        """Close connection or port."""
        self.client.close()  # type: ignore[no-untyped-call]

    def _value(self, words: Mapping[int, int]) -> float:
        registers = self.registers
        kind = ModbusTcpClient.DATATYPE[registers.encoding.upper()]
        value_words = [words[registers.value + i] for i in range(kind.value[1])]
        number = self.client.convert_from_registers(value_words, kind, word_order=registers.word_order)
        return float(number) * (1.0 if registers.encoding == "float32" else registers.scale)  # type: ignore[arg-type]

    def _check_status(self, status: int) -> None:
        registers = self.registers
        for bit, what in (
            (registers.open_bit, "open circuit"),
            (registers.short_bit, "short circuit"),
            (registers.invalid_bit, "the transmitter marks its value as invalid"),
        ):
            if status >> bit & 1:
                raise SensorError(f"{self.name}: {what} (status 0x{status:04X}); check sensor and wires")

    def _read(self, address: int, count: int) -> list[int]:
        try:
            # pymodbus closes a connection on errors and opens it again by itself only where it was open before.
            if not self.client.connected and not self.client.connect():
                raise SensorError(f"{self.name}: no connection to {self.client}; check address, cable and supply")
            holding = self.registers.table == "holding"
            read = self.client.read_holding_registers if holding else self.client.read_input_registers
            answer = read(address, count=count, device_id=self.device_id)
        except _FAILURES as error:
            raise SensorError(
                f"{self.name}: device {self.device_id} does not answer on {self.client} ({error}); "
                "check address and line"
            ) from error
        if answer.isError():
            code = getattr(answer, "exception_code", 0)
            raise SensorError(
                f"{self.name}: device {self.device_id} refuses register {address} with exception {code} "
                f"({_EXCEPTIONS.get(code, 'unknown')}); the register map should be that of the device"
            )
        if len(answer.registers) != count:
            raise SensorError(f"{self.name}: {len(answer.registers)} registers came where {count} were asked for")
        return list(answer.registers)


def modbus_tcp(name: str, options: Mapping[str, Any]) -> ModbusThermometer:
    """Make a transmitter on Modbus TCP: options ``host``, ``port`` and those of the thermometer and its registers."""
    rest = dict(options)
    if "host" not in rest:
        raise DriverError(f"{name}: option 'host' is missing; it should be the address of the transmitter")
    client = ModbusTcpClient(
        rest.pop("host"), port=rest.pop("port", 502), name=name, timeout=_TIMEOUT_S, retries=_RETRIES
    )
    return _thermometer(name, client, rest)


def modbus_rtu(name: str, options: Mapping[str, Any]) -> ModbusThermometer:
    """Make a transmitter on Modbus RTU: options ``port``, ``baudrate``, ``parity``, ``stopbits`` and the others."""
    rest = dict(options)
    if "port" not in rest:
        raise DriverError(f"{name}: option 'port' is missing; it should be the serial device")
    client = ModbusSerialClient(
        rest.pop("port"),
        baudrate=rest.pop("baudrate", 19200),
        parity=rest.pop("parity", "N"),
        stopbits=rest.pop("stopbits", 1),
        name=name,
        timeout=_TIMEOUT_S,
        retries=_RETRIES,
    )
    return _thermometer(name, client, rest)


def _thermometer(name: str, client: _Client, options: dict[str, Any]) -> ModbusThermometer:
    registers = build(RegisterMap, f"{name}, registers", options.pop("registers", {}))
    limits = build(Range, f"{name}, limits", options.pop("limits", {}))
    return build(ModbusThermometer, name, options, name=name, client=client, registers=registers, limits=limits)
