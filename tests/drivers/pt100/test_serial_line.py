from __future__ import annotations

import pytest
import serial

from drivers.errors import DriverError, SensorError
from drivers.pt100 import SerialThermometer, serial_thermometer
from drivers.pt100.serial_line import checksum


class Line:
    """A port that answers each question with the next line of a script."""

    def __init__(self, *answers: bytes | Exception) -> None:
        self.answers = list(answers)
        self.asked: list[bytes] = []
        self.drained = 0
        self.is_open = True

    def write(self, data: bytes, /) -> int:
        self.asked.append(data)
        return len(data)

    def read_until(self, expected: bytes = b"\n", size: int | None = None) -> bytes:
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def reset_input_buffer(self) -> None:
        self.drained += 1

    def close(self) -> None:
        self.is_open = False

    def open(self) -> None:
        self.is_open = True


def line(text: str) -> bytes:
    return f"{text}*{checksum(text)}\r\n".encode()


def test_check_sum_is_the_exclusive_or() -> None:
    assert checksum("R 107.794") == f"{0x52 ^ 0x20 ^ 0x31 ^ 0x30 ^ 0x37 ^ 0x2E ^ 0x37 ^ 0x39 ^ 0x34:02X}"
    assert checksum("") == "00"


def test_resistance_becomes_temperature() -> None:
    port = Line(line("R 119.397"))
    found = SerialThermometer("lubricant", port).measure()
    assert found.temperature_c == pytest.approx(50.0, abs=0.01)
    assert found.resistance_ohm == 119.397
    assert port.asked == [b"R?\r"]


def test_temperature_where_the_transmitter_linearises() -> None:
    assert (
        SerialThermometer("lubricant", Line(line("T 41.250")), quantity="temperature").measure().temperature_c == 41.25
    )


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (line("E OPEN"), "lubricant: open circuit"),
        (line("E SHORT"), "lubricant: short circuit"),
        (line("E COMMAND"), "does not know the question"),
        (line("E WHATEVER"), "unknown error 'WHATEVER'"),
        (line("R 0.100"), "short circuit"),
        (line("R 2000.000"), "open circuit"),
        (line("R abc"), "'abc', which is no number"),
    ],
)
def test_faults_are_errors_never_temperatures(answer: bytes, words: str) -> None:
    with pytest.raises(SensorError, match=words):
        SerialThermometer("lubricant", Line(answer)).measure()


@pytest.mark.parametrize("noise", [b"", b"R 119.3", b"R 119.397*00\r\n", b"\xff\xfe\r\n", b"\r\n", line("T 20.000")])
def test_one_disturbed_answer_is_asked_for_again_after_draining(noise: bytes) -> None:
    port = Line(noise, line("R 119.397"))
    assert SerialThermometer("lubricant", port).measure().resistance_ohm == 119.397
    assert port.drained == 2


@pytest.mark.parametrize(
    ("noise", "words"),
    [
        (b"", "no answer within 0.3 s"),
        (b"R 119.3", "broke off after 7 characters"),
        (b"R 119.397*00\r\n", "check sum of the answer is wrong"),
        (b"\xff\xfe\r\n", "no ASCII"),
        (line("T 20.000"), "the answer was to another question"),
    ],
)
def test_two_disturbed_answers_end_in_a_sentence(noise: bytes, words: str) -> None:
    port = Line(noise, noise)
    with pytest.raises(SensorError, match=words):
        SerialThermometer("lubricant", port).measure()
    assert len(port.asked) == 2


def test_an_unplugged_adapter() -> None:
    port = Line(serial.SerialException("gone"), line("R 119.397"))
    thermometer = SerialThermometer("lubricant", port)
    with pytest.raises(SensorError, match="the serial line failed"):
        thermometer.measure()
    assert not port.is_open
    assert thermometer.measure().resistance_ohm == 119.397  # it was plugged in again


def test_identity_and_close() -> None:
    port = Line(line("I PT-100 4711"))
    thermometer = SerialThermometer("lubricant", port)
    assert thermometer.identity() == "PT-100 4711"
    thermometer.close()
    assert not port.is_open


def test_factory() -> None:
    with pytest.raises(DriverError, match="option 'port' is missing"):
        serial_thermometer("lubricant", {})
    with pytest.raises(SensorError, match="'/dev/there/is/none' cannot be opened"):
        serial_thermometer("lubricant", {"port": "/dev/there/is/none"})
