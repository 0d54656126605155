"""Where a Modbus transmitter keeps its reading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from drivers.errors import DriverError

_CHOICES = {
    "quantity": ("temperature", "resistance"),
    "encoding": ("float32", "int16", "int32"),
    "word_order": ("big", "little"),
    "table": ("input", "holding"),
}


@dataclass(frozen=True, slots=True)
class RegisterMap:
    """Where the transmitter keeps what, counted from 0.

    Attributes
    ----------
    value : first register of the value.
    quantity : what the value is.
    encoding : how it is written; ``float32`` takes two registers, high word first unless ``word_order`` says otherwise.
    scale : °C or Ω a count, for the integer encodings.
    status : register of the status word; None where there is none.
    open_bit, short_bit, invalid_bit : its bits.
    conversion : register that counts conversions; None where there is none.
    table : ``input`` registers (function 4) or ``holding`` registers (function 3).
    at_once : ask for the whole span in one request, so that status, value and count belong together; False where the
        device refuses the registers between.
    """

    value: int = 1
    quantity: Literal["temperature", "resistance"] = "temperature"
    encoding: Literal["float32", "int16", "int32"] = "float32"
    word_order: Literal["big", "little"] = "big"
    scale: float = 1.0
    status: int | None = 0
    open_bit: int = 0
    short_bit: int = 1
    invalid_bit: int = 2
    conversion: int | None = 5
    table: Literal["input", "holding"] = "input"
    at_once: bool = True

    def __post_init__(self) -> None:
        """Refuse words that mean nothing, before a device is asked for them."""
        for key, choices in _CHOICES.items():
            if getattr(self, key) not in choices:
                raise DriverError(
                    f"registers: {key} is {getattr(self, key)!r}; it should be one of {', '.join(choices)}"
                )

    @property
    def spans(self) -> tuple[tuple[int, int], ...]:
        """Registers to ask for, as (first, count)."""
        single = [(address, 1) for address in (self.status, self.conversion) if address is not None]
        spans = [(self.value, 1 if self.encoding == "int16" else 2), *single]
        if not self.at_once:
            return tuple(spans)
        first = min(address for address, _ in spans)
        return ((first, max(address + count for address, count in spans) - first),)
