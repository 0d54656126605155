"""Faults of the PT100 lines of a running emulator, on order: seen through Modbus and the serial line."""

from __future__ import annotations

import struct
import time

import pytest
import serial
from pymodbus.client import ModbusSerialClient, ModbusTcpClient
from pymodbus.exceptions import ModbusIOException

from fakes.ethercat.bench import ROLES
from tests.veth import Emulator


@pytest.fixture(scope="module")
def emulator(veth, tmp_path_factory):
    folder = tmp_path_factory.mktemp("lines")
    made = Emulator(veth.far, folder, modbus_rtu="pty", modbus_tcp=0, serial=str(folder / "serial"))
    yield made
    made.stop()


@pytest.fixture(params=["tcp", "rtu"])
def client(request, emulator):
    if request.param == "tcp":
        made = ModbusTcpClient("127.0.0.1", port=emulator.places["modbus_tcp"], timeout=1.5, retries=0)
    else:
        made = ModbusSerialClient(emulator.places["modbus_rtu"], baudrate=19200, timeout=1.5, retries=0)
    assert made.connect()
    yield made
    made.close()


def read(client):
    if not client.connected:
        client.connect()
    return client.read_input_registers(0, count=6, device_id=1)


def celsius(answer):
    return struct.unpack(">f", struct.pack(">2H", *answer.registers[1:3]))[0]


def test_readings_are_the_plants(client):
    assert celsius(read(client)) == pytest.approx(21.0, abs=2.0)


@pytest.mark.parametrize("fault", ["modbus_silence", "modbus_wrong_device"])
def test_lines_without_a_usable_answer(client, emulator, fault):
    emulator.order(f"fault {fault}")
    time.sleep(0.05)
    with pytest.raises(ModbusIOException):
        read(client)
    emulator.order(f"clear {fault}")
    time.sleep(0.05)
    assert not read(client).isError()


def test_wrong_check_sum_and_exception(client, emulator):
    emulator.order("fault modbus_crc")
    time.sleep(0.05)
    if isinstance(client, ModbusSerialClient):
        with pytest.raises(ModbusIOException):
            read(client)
    emulator.order("fault modbus_exception")
    time.sleep(0.05)
    assert read(client).exception_code == 4
    emulator.order("clear modbus_exception")
    time.sleep(0.05)
    assert not read(client).isError()


def test_open_at_the_transmitter_and_at_the_element(client, emulator):
    emulator.order("fault transmitter_open")
    time.sleep(0.05)
    assert read(client).registers[0] & 0b001
    emulator.order("clear transmitter_open")
    emulator.order("fault pt100_short")
    time.sleep(0.3)
    assert read(client).registers[0] & 0b010
    emulator.order("clear pt100_short")
    time.sleep(0.3)
    assert read(client).registers[0] == 0


def test_orders_that_make_no_sense_are_refused(emulator):
    for order in ("fault nothing", "fault drive_fault:torque_terminal", "dance", "fault sto:input_drive=x"):
        with pytest.raises(ValueError, match=r"fault|order"):
            emulator.order(order)


def test_status_tells_states_and_counters(emulator):
    status = emulator.order("status")
    assert set(status["al_status"]) == set(ROLES)
    assert status["counters"]["cycles"] > 0


def test_a_fault_comes_at_its_time(emulator):
    emulator.order("fault sto:load_drive@0.2")
    emulator.order("fault drive_fault:load_drive=0x4310@0.4")
    assert emulator.order("status")["drives"]["load_drive"] == "SWITCH_ON_DISABLED"
    time.sleep(0.6)
    assert emulator.order("status")["drives"]["load_drive"] == "FAULT"


def test_serial_line_silent_and_unplugged(emulator):
    """Comes last: an unplugged line stays away."""
    port = serial.Serial(emulator.places["serial"], 9600, timeout=0.3)
    port.write(b"T?\r")
    assert port.read_until(b"\r\n").startswith(b"T ")
    emulator.order("fault serial_silent")
    time.sleep(0.05)
    port.write(b"T?\r")
    assert port.read_until(b"\r\n") == b""
    emulator.order("fault serial_unplugged")
    time.sleep(0.2)
    with pytest.raises((serial.SerialException, OSError)):
        port.write(b"T?\r")
    port.close()
