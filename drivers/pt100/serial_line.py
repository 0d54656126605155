"""PT100 transmitter on a serial line: one line asked, one line answered, with a check sum.

A question is ``R?`` (resistance), ``T?`` (temperature) or ``I?`` (who are you), ended by a carriage return. The answer
repeats the letter: ``R 107.794*1F``, ``T 20.000*0C``, with the exclusive or of all characters before the star in two
hexadecimal digits, ended by carriage return and line feed. ``E OPEN``, ``E SHORT`` and ``E COMMAND`` are errors.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import serial

from drivers.devices import build
from drivers.errors import DriverError, SensorError
from drivers.pt100.measurement import Measurement, Range, from_resistance, from_temperature
from drivers.pt100.ports import PORT_ERRORS

_TIMEOUT_S = 0.3
_RETRIES = 1
_ERRORS = {
    "OPEN": "open circuit; check sensor and wires",
    "SHORT": "short circuit; check sensor and wires",
    "COMMAND": "the transmitter does not know the question; check its protocol",
}


class Port(Protocol):
    """``serial.Serial`` as far as it is used here."""

    @property
    def is_open(self) -> bool:
        """Whether the port is open."""
        ...

    def open(self) -> None:
        """Open the port."""
        ...

    def write(self, data: bytes, /) -> Any:
        """Send."""
        ...

    def read_until(self, expected: bytes = ..., size: int | None = ...) -> bytes:
        """Receive up to a terminator or the timeout."""
        ...

    def reset_input_buffer(self) -> None:
        """Drop what has come in."""
        ...

    def close(self) -> None:
        """Close the port."""
        ...


def checksum(text: str) -> str:
    """Exclusive or of all characters, two hexadecimal digits."""
    return f"{functools.reduce(operator.xor, text.encode('ascii'), 0):02X}"


@dataclass(slots=True)
class SerialThermometer:
    """One transmitter.

    Parameters
    ----------
    name : what the configuration calls it.
    port : serial port with a timeout; it is opened again when asked after a failure.
    quantity : what to ask for.
    limits : what is plausible.
    r0 : resistance at 0 °C, Ω.
    """

    name: str
    port: Port
    quantity: Literal["resistance", "temperature"] = "resistance"
    limits: Range = field(default_factory=Range)
    r0: float = 100.0

    def measure(self) -> Measurement:
        """Ask the transmitter (at most two tries of 0.3 s).

        Raises
        ------
        SensorError
            If it does not answer, the check sum is wrong, or it says open or short circuit.
        """
        letter = self.quantity[0].upper()
        value = self._number(letter, self._ask(letter))
        if self.quantity == "resistance":
            return from_resistance(self.name, value, self.limits, self.r0)
        return from_temperature(self.name, value, self.limits)

    def identity(self) -> str:
        """Name and serial number the transmitter gives itself."""
        return self._ask("I")

    def close(self) -> None:
        """Close the port."""
        self.port.close()

    def _ask(self, letter: str) -> str:
        reason = ""
        for _ in range(_RETRIES + 1):
            try:
                line = self._exchange(f"{letter}?\r".encode("ascii"))
            except PORT_ERRORS as error:
                # Closed, so that the next question opens it again: the adapter may be back by then.
                self.port.close()
                raise SensorError(f"{self.name}: the serial line failed ({error}); check cable and adapter") from error
            kind, text, reason = _parse(line)
            if kind == "E":
                raise SensorError(f"{self.name}: {_ERRORS.get(text, f'unknown error {text!r}')}")
            if kind == letter and not reason:
                return text
        raise SensorError(f"{self.name}: {reason or 'the answer was to another question'}; check line and baud rate")

    def _exchange(self, question: bytes) -> bytes:
        if not self.port.is_open:
            self.port.open()
        # An answer that came too late last time would be taken for this one.
        self.port.reset_input_buffer()
        self.port.write(question)
        return self.port.read_until(b"\r\n")

    def _number(self, letter: str, text: str) -> float:
        try:
            return float(text)
        except ValueError as error:
            raise SensorError(f"{self.name}: the answer to {letter}? is {text!r}, which is no number") from error


def _parse(line: bytes) -> tuple[str, str, str]:
    """Letter, text and, where the line is not whole, the reason."""
    if not line.endswith(b"\r\n"):
        return "", "", "no answer within 0.3 s" if not line else f"the answer broke off after {len(line)} characters"
    try:
        body, star, digits = line[:-2].decode("ascii").rpartition("*")
    except UnicodeDecodeError:
        return "", "", "the answer holds characters that are no ASCII"
    if not star or digits != checksum(body):
        return "", "", "the check sum of the answer is wrong"
    letter, _, text = body.partition(" ")
    return letter, text, ""


def serial_thermometer(name: str, options: Mapping[str, Any]) -> SerialThermometer:
    """Make a transmitter on a serial line: options ``port``, ``baudrate``, ``quantity``, ``limits``, ``r0``."""
    rest = dict(options)
    path, baudrate = rest.pop("port", None), rest.pop("baudrate", 9600)
    if path is None:
        raise DriverError(f"{name}: option 'port' is missing; it should be the serial device")
    limits = build(Range, f"{name}, limits", rest.pop("limits", {}))
    try:
        port = serial.Serial(path, baudrate, timeout=_TIMEOUT_S, write_timeout=_TIMEOUT_S)
    except PORT_ERRORS as error:
        raise SensorError(
            f"{name}: serial device '{path}' cannot be opened ({error}); check its name and rights"
        ) from error
    return build(SerialThermometer, name, rest, name=name, port=port, limits=limits)
