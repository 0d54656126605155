from __future__ import annotations

import struct
from typing import Any

import pytest
from pymodbus.client import ModbusTcpClient
from pymodbus.exceptions import ConnectionException, ModbusIOException
from pymodbus.pdu import ExceptionResponse

from drivers.errors import DriverError, SensorError
from drivers.pt100 import ModbusThermometer, RegisterMap, modbus_rtu, modbus_tcp


class Registers:
    """What pymodbus answers."""

    def __init__(self, registers: list[int]) -> None:
        self.registers = registers

    def isError(self) -> bool:
        return False


class Client(ModbusTcpClient):
    """A client whose device is a list of registers."""

    def __init__(self, registers: list[int], failure: Any = None, reachable: bool = True) -> None:
        super().__init__("transmitter", timeout=0.3, retries=1)
        self.words, self.failure, self.reachable = registers, failure, reachable
        self.asked: list[tuple[int, int, int]] = []
        self.held: list[tuple[int, int, int]] = []

    def connect(self) -> bool:
        return self.reachable

    @property
    def connected(self) -> bool:
        return False

    def read_input_registers(self, address: int, *, count: int = 1, device_id: int = 1, **_: Any) -> Any:
        self.asked.append((address, count, device_id))
        if isinstance(self.failure, Exception):
            raise self.failure
        return self.failure or Registers(self.words[address : address + count])

    def read_holding_registers(self, address: int, *, count: int = 1, device_id: int = 1, **_: Any) -> Any:
        self.held.append((address, count, device_id))
        return Registers(self.words[address : address + count])


def words(value: float, status: int = 0, conversion: int = 5) -> list[int]:
    high, low = struct.unpack(">HH", struct.pack(">f", value))
    return [status, high, low, 0, 0, conversion]


def test_temperature_as_float_with_its_conversion() -> None:
    client = Client(words(41.25))
    found = ModbusThermometer("lubricant", client, device_id=3).measure()
    assert (found.temperature_c, found.conversion) == (41.25, 5)
    assert client.asked == [(0, 6, 3)]  # one request, so that all of it belongs together


def test_registers_one_by_one_and_from_the_other_table() -> None:
    client = Client(words(41.25))
    thermometer = ModbusThermometer("lubricant", client, registers=RegisterMap(at_once=False))
    assert thermometer.measure().temperature_c == 41.25
    assert sorted(client.asked) == [(0, 1, 1), (1, 2, 1), (5, 1, 1)]
    holding = ModbusThermometer("lubricant", client, registers=RegisterMap(table="holding"))
    assert holding.measure().temperature_c == 41.25
    assert client.held == [(0, 6, 1)]


def test_resistance_goes_through_the_standard() -> None:
    registers = RegisterMap(quantity="resistance")
    found = ModbusThermometer("lubricant", Client(words(119.397)), registers=registers).measure()
    assert found.temperature_c == pytest.approx(50.0, abs=0.01)


def test_integers_with_a_scale_and_little_words() -> None:
    registers = RegisterMap(value=0, encoding="int16", scale=0.1, status=None, conversion=None)
    assert ModbusThermometer("x", Client([0xFF9C]), registers=registers).measure().temperature_c == pytest.approx(-10.0)
    low_first = RegisterMap(value=0, encoding="int32", scale=0.01, word_order="little", status=None, conversion=None)
    assert ModbusThermometer("x", Client([4125, 0]), registers=low_first).measure().temperature_c == pytest.approx(
        41.25
    )


@pytest.mark.parametrize(
    ("status", "what"), [(1, "open circuit"), (2, "short circuit"), (4, "marks its value as invalid")]
)
def test_faults_are_errors_never_temperatures(status: int, what: str) -> None:
    with pytest.raises(SensorError, match=f"lubricant: .*{what}"):
        ModbusThermometer("lubricant", Client(words(20.0, status))).measure()


@pytest.mark.parametrize("value", [float("nan"), 850.0, -200.0])
def test_values_that_cannot_be(value: float) -> None:
    with pytest.raises(SensorError, match="outside the plausible"):
        ModbusThermometer("lubricant", Client(words(value))).measure()


@pytest.mark.parametrize("failure", [ConnectionException("lost"), ModbusIOException("silent"), OSError("unplugged")])
def test_silence_is_told(failure: Exception) -> None:
    with pytest.raises(SensorError, match="device 1 does not answer"):
        ModbusThermometer("lubricant", Client([], failure)).measure()


def test_no_connection_is_told() -> None:
    with pytest.raises(SensorError, match="no connection to"):
        ModbusThermometer("lubricant", Client([], reachable=False)).measure()


def test_exceptions_of_the_device_are_told_with_their_code() -> None:
    with pytest.raises(SensorError, match=r"refuses register 0 with exception 2 \(illegal data address\)"):
        ModbusThermometer("lubricant", Client([], ExceptionResponse(4, 2))).measure()


def test_too_few_registers() -> None:
    with pytest.raises(SensorError, match="2 registers came where 6 were asked for"):
        ModbusThermometer("lubricant", Client([0, 1])).measure()


def test_factories_set_short_timeouts_and_refuse_what_they_do_not_know() -> None:
    for thermometer in (
        modbus_tcp("lubricant", {"host": "127.0.0.1", "registers": {"value": 7}, "device_id": 2}),
        modbus_rtu("lubricant", {"port": "/dev/null", "registers": {"value": 7}, "device_id": 2}),
    ):
        assert (thermometer.device_id, thermometer.registers.value) == (2, 7)
        assert thermometer.client.comm_params.timeout_connect == 0.3
    with pytest.raises(DriverError, match="option 'host' is missing"):
        modbus_tcp("lubricant", {})
    with pytest.raises(DriverError, match="option 'port' is missing"):
        modbus_rtu("lubricant", {})
    with pytest.raises(DriverError, match="registers: option 'register' is not known"):
        modbus_tcp("lubricant", {"host": "x", "registers": {"register": 1}})
    with pytest.raises(DriverError, match="encoding is 'float64'; it should be one of float32, int16, int32"):
        modbus_tcp("lubricant", {"host": "x", "registers": {"encoding": "float64"}})
