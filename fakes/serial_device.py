"""A PT100 transmitter on a serial line: one line asked, one line answered, with a check sum.

Questions end with a carriage return: ``R?`` resistance in Ω, ``T?`` temperature in °C, ``I?`` identity. Answers are the
letter, the value, a star and the exclusive or of all characters before it as two hexadecimal digits, then CR LF:
``R 107.794*1F``. ``E OPEN``, ``E SHORT`` and ``E COMMAND`` are errors, with their check sum likewise.
"""

from __future__ import annotations

import os
import select
import threading
import tty
from collections.abc import Callable
from functools import reduce
from operator import xor

from fakes.pt100 import Wiring
from fakes.thermometer import Reading, Source, Transmitter

LONGEST_QUESTION = 64
IDENTITY = "Emulated-PT100 0004711"

_WIRING_ERRORS = {Wiring.OPEN: "E OPEN", Wiring.SHORT: "E SHORT"}

_ANSWERS: dict[bytes, Callable[[Reading], str]] = {
    b"R?": lambda reading: _WIRING_ERRORS.get(reading.wiring, f"R {reading.ohm:.3f}"),
    b"T?": lambda reading: _WIRING_ERRORS.get(reading.wiring, f"T {reading.celsius:.3f}"),
    b"I?": lambda _: f"I {IDENTITY}",
}


def frame(text: str) -> bytes:
    """Return a line as it goes over the wire: text, star, check sum, CR LF."""
    return f"{text}*{reduce(xor, text.encode('ascii')):02X}\r\n".encode("ascii")


class SerialDevice:
    """The transmitter on a pseudo-terminal; ``port`` is the name to open at 9600 8N1 (any rate will do).

    Faults: ``transmitter.wiring`` (open, short), :meth:`unplug`, ``silent``, ``garbled`` (wrong check sums).
    """

    def __init__(self, source: Source, channel: int = 0) -> None:
        self.transmitter = Transmitter(source, channel)
        self.silent = False
        self.garbled = False
        self._side, self._device = os.openpty()
        tty.setraw(self._device)
        self.port = os.ttyname(self._device)
        self._wake_read, self._wake_write = os.pipe()
        self._thread = threading.Thread(target=self._serve, name="serial PT100", daemon=True)
        self._thread.start()

    def unplug(self) -> None:
        """Pull the line for good: who holds the port open gets an error, as with a USB adapter pulled out."""
        self.close()

    def close(self) -> None:
        """Stop and hang up; closing twice is harmless."""
        if self._side < 0:
            return
        os.write(self._wake_write, b"x")
        self._thread.join()
        for descriptor in (self._side, self._device, self._wake_read, self._wake_write):
            os.close(descriptor)
        self._side = -1

    def _serve(self) -> None:
        held = b""
        while True:
            ready, _, _ = select.select([self._side, self._wake_read], [], [])
            if self._wake_read in ready:
                return
            *questions, held = (held + os.read(self._side, 256)).split(b"\r")
            held = held[-LONGEST_QUESTION:]
            for question in questions:
                answer = self._answer(question.strip())
                if not self.silent:
                    os.write(self._side, answer)

    def _answer(self, question: bytes) -> bytes:
        say = _ANSWERS.get(question)
        line = frame(say(self.transmitter.read()) if say else "E COMMAND")
        return line[:-4] + b"ZZ\r\n" if self.garbled else line
