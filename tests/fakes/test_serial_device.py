"""The serial transmitter as pyserial sees it."""

from __future__ import annotations

import pytest
import serial

from fakes.pt100 import Wiring, resistance
from fakes.serial_device import SerialDevice, frame
from fakes.thermometer import FixedSource


@pytest.fixture
def device():
    made = SerialDevice(FixedSource(lubricant=25.5))
    yield made
    made.close()


@pytest.fixture
def port(device):
    with serial.Serial(device.port, 9600, timeout=0.3) as opened:
        yield opened


def ask(port, question):
    port.write(question)
    return port.read_until(b"\r\n")


def test_check_sum_is_the_exclusive_or():
    assert frame("T 20.000") == b"T 20.000*68\r\n"
    body, digits = frame("I Emulated")[:-2].split(b"*")
    total = 0
    for character in body:
        total ^= character
    assert int(digits, 16) == total


@pytest.mark.parametrize(
    ("question", "answer"),
    [
        (b"T?\r", frame("T 25.500")),
        (b"R?\r", frame(f"R {resistance(25.5):.3f}")),
        (b"I?\r", frame("I Emulated-PT100 0004711")),
        (b"X?\r", frame("E COMMAND")),
        (b"\r", frame("E COMMAND")),
    ],
)
def test_questions(port, question, answer):
    assert ask(port, question) == answer


def test_garbage_without_an_end_is_not_answered(port):
    assert ask(port, b"\xff\x00T?") == b""
    assert ask(port, b"\r") == frame("E COMMAND")
    assert ask(port, b"T?\r") == frame("T 25.500")


@pytest.mark.parametrize(("wiring", "text"), [(Wiring.OPEN, "E OPEN"), (Wiring.SHORT, "E SHORT")])
def test_open_and_short(device, port, wiring, text):
    device.transmitter.wiring = wiring
    assert ask(port, b"T?\r") == ask(port, b"R?\r") == frame(text)


def test_silent_and_garbled(device, port):
    device.silent = True
    assert ask(port, b"T?\r") == b""
    device.silent, device.garbled = False, True
    assert ask(port, b"T?\r") == b"T 25.500*ZZ\r\n"


def test_unplugged_the_port_fails(device):
    port = serial.Serial(device.port, 9600, timeout=0.3)
    device.unplug()
    with pytest.raises((serial.SerialException, OSError)):
        ask(port, b"T?\r")
    port.close()
    device.unplug()
