"""The thermometers' drivers against the emulated devices: real pymodbus server, real pseudo-terminals."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from drivers.errors import SensorError
from drivers.pt100 import BackgroundReader, ModbusThermometer, modbus_rtu, modbus_tcp, serial_thermometer
from fakes.modbus import LineFault, ModbusTransmitter
from fakes.pt100 import Wiring
from fakes.serial_device import SerialDevice
from fakes.serial_line import Cable
from fakes.thermometer import FixedSource

Pair = tuple[ModbusTransmitter, ModbusThermometer]


@pytest.fixture(params=["tcp", "rtu"])
def modbus(request: pytest.FixtureRequest) -> Iterator[Pair]:
    source = FixedSource(lubricant=41.5)
    cable = Cable() if request.param == "rtu" else None
    if cable is None:
        device = ModbusTransmitter.tcp(source)
        thermometer = modbus_tcp("lubricant", {"host": "127.0.0.1", "port": device.port})
    else:
        device = ModbusTransmitter.rtu(source, cable.far)
        thermometer = modbus_rtu("lubricant", {"port": cable.near})
    yield device, thermometer
    thermometer.close()
    device.close()
    if cable is not None:
        cable.close()


@pytest.fixture
def line() -> Iterator[SerialDevice]:
    device = SerialDevice(FixedSource(lubricant=41.5))
    yield device
    device.close()


def test_temperature_over_modbus(modbus: Pair) -> None:
    _, thermometer = modbus
    found = thermometer.measure()
    assert found.temperature_c == pytest.approx(41.5, abs=0.05)
    assert found.conversion is not None


@pytest.mark.parametrize(("wiring", "what"), [(Wiring.OPEN, "open circuit"), (Wiring.SHORT, "short circuit")])
def test_broken_sensor_over_modbus(modbus: Pair, wiring: Wiring, what: str) -> None:
    device, thermometer = modbus
    device.transmitters[0].wiring = wiring
    with pytest.raises(SensorError, match=what):
        thermometer.measure()


@pytest.mark.parametrize("fault", [LineFault.SILENCE, LineFault.EXCEPTION, LineFault.WRONG_DEVICE])
def test_line_faults_over_modbus_pass_when_they_do(modbus: Pair, fault: LineFault) -> None:
    device, thermometer = modbus
    device.fault = fault
    with pytest.raises(SensorError, match="lubricant"):
        thermometer.measure()
    device.fault = LineFault.NONE
    assert thermometer.measure().temperature_c == pytest.approx(41.5, abs=0.05)


def test_reader_holds_the_last_value_while_the_line_is_silent(modbus: Pair) -> None:
    device, thermometer = modbus
    reader = BackgroundReader(thermometer)
    reader.ask()
    assert reader.latest().error is None
    device.fault = LineFault.SILENCE
    reader.ask()
    reading = reader.latest()
    assert reading.temperature_c == pytest.approx(41.5, abs=0.05)
    assert reading.age_s >= 0.3
    assert reading.error is not None


@pytest.mark.parametrize("quantity", ["resistance", "temperature"])
def test_temperature_over_the_serial_line(line: SerialDevice, quantity: str) -> None:
    thermometer = serial_thermometer("lubricant", {"port": line.port, "quantity": quantity})
    assert thermometer.measure().temperature_c == pytest.approx(41.5, abs=0.05)
    assert "Emulated-PT100" in thermometer.identity()
    thermometer.close()


def test_faults_of_the_serial_line(line: SerialDevice) -> None:
    thermometer = serial_thermometer("lubricant", {"port": line.port})
    line.transmitter.wiring = Wiring.OPEN
    with pytest.raises(SensorError, match="open circuit"):
        thermometer.measure()
    line.transmitter.wiring = Wiring.GOOD
    line.garbled = True
    with pytest.raises(SensorError, match="check sum"):
        thermometer.measure()
    line.garbled = False
    line.silent = True
    with pytest.raises(SensorError, match=r"no answer within 0\.3 s"):
        thermometer.measure()
    line.silent = False
    assert thermometer.measure().temperature_c == pytest.approx(41.5, abs=0.05)
    line.unplug()
    with pytest.raises(SensorError, match="lubricant: "):
        thermometer.measure()
    thermometer.close()
