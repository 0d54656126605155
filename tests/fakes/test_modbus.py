"""The Modbus transmitter seen by pymodbus' own client: readings and every fault."""

from __future__ import annotations

import math
import struct

import pytest
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.exceptions import ModbusIOException

from fakes.modbus import LineFault, ModbusTransmitter
from fakes.pt100 import Wiring, resistance
from fakes.serial_line import Cable
from fakes.thermometer import FixedSource

TIMEOUT_S = 0.2


@pytest.fixture
def source():
    return FixedSource(lubricant=43.25, ambient=21.5)


@pytest.fixture(params=["tcp", "rtu"])
def pair(request, source):
    """(server, client) on TCP, and on RTU over two joined pseudo-terminals."""
    if request.param == "tcp":
        server = ModbusTransmitter.tcp(source)
        client = ModbusTcpClient("127.0.0.1", port=server.port, timeout=TIMEOUT_S, retries=0)
        cable = None
    else:
        cable = Cable()
        server = ModbusTransmitter.rtu(source, cable.near)
        client = ModbusSerialClient(cable.far, baudrate=19200, timeout=TIMEOUT_S, retries=0)
    assert client.connect()
    yield server, client
    client.close()
    server.close()
    if cable is not None:
        cable.close()


def read(client, address=0, count=6, device_id=1):
    if not client.connected:
        client.connect()
    return client.read_input_registers(address, count=count, device_id=device_id)


def values(answer):
    return struct.unpack(">2f", struct.pack(">4H", *answer.registers[1:5]))


def test_temperature_resistance_and_conversions(pair, source):
    _, client = pair
    answer = read(client)
    assert answer.registers[0] == 0
    assert values(answer) == pytest.approx((43.25, resistance(43.25)), rel=1e-6)
    assert values(read(client, 16))[0] == pytest.approx(21.5)
    source.lubricant = 60.0
    assert values(read(client))[0] == pytest.approx(60.0)


@pytest.mark.parametrize(("wiring", "status"), [(Wiring.OPEN, 0b101), (Wiring.SHORT, 0b110)])
def test_open_and_short(pair, wiring, status):
    server, client = pair
    server.transmitters[0].wiring = wiring
    answer = read(client)
    assert answer.registers[0] == status
    assert all(map(math.isnan, values(answer)))
    server.transmitters[0].wiring = Wiring.GOOD
    assert read(client).registers[0] == 0


def test_open_comes_from_the_plant_too(pair, source):
    source.lubricant = 10_000.0
    assert read(pair[1]).registers[0] == 0b101


@pytest.mark.parametrize("fault", [LineFault.SILENCE, LineFault.WRONG_DEVICE])
def test_no_usable_answer(pair, fault):
    server, client = pair
    server.fault = fault
    with pytest.raises(ModbusIOException):
        read(client)
    server.fault = LineFault.NONE
    assert not read(client).isError()


def test_wrong_check_sum_is_no_answer_on_rtu(pair):
    server, client = pair
    server.fault = LineFault.CRC
    if isinstance(client, ModbusTcpClient):
        assert not read(client).isError()
    else:
        with pytest.raises(ModbusIOException):
            read(client)


def test_exception(pair):
    server, client = pair
    server.fault = LineFault.EXCEPTION
    answer = read(client)
    assert answer.isError()
    assert answer.exception_code == 4


def test_unknown_device_is_silent_and_unknown_register_an_exception(pair):
    _, client = pair
    with pytest.raises(ModbusIOException):
        read(client, device_id=9)
    assert read(client, 500).exception_code == 2


def test_an_unplugged_cable_is_silence():
    cable = Cable()
    server = ModbusTransmitter.rtu(FixedSource(), cable.near)
    client = ModbusSerialClient(cable.far, baudrate=19200, timeout=TIMEOUT_S, retries=0)
    client.connect()
    cable.unplug()
    with pytest.raises(ModbusIOException):
        read(client)
    cable.unplug(False)
    assert not read(client).isError()
    client.close()
    server.close()
    cable.close()
