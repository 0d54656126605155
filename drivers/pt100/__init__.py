"""Resistance thermometers: on Modbus, on a serial line, behind an EtherCAT terminal."""

from drivers.pt100.measurement import Measurement, Range, Thermometer
from drivers.pt100.modbus import ModbusThermometer, modbus_rtu, modbus_tcp
from drivers.pt100.reader import BackgroundReader, Reading
from drivers.pt100.registers import RegisterMap
from drivers.pt100.serial_line import SerialThermometer, serial_thermometer
from drivers.pt100.terminal import ChannelBlock, Pt100Terminal, pt100_terminal

__all__ = [
    "BackgroundReader",
    "ChannelBlock",
    "Measurement",
    "ModbusThermometer",
    "Pt100Terminal",
    "Range",
    "Reading",
    "RegisterMap",
    "SerialThermometer",
    "Thermometer",
    "modbus_rtu",
    "modbus_tcp",
    "pt100_terminal",
    "serial_thermometer",
]
