"""Faults as one word: ``name[:slave][=value][@seconds]``, such as ``drive_fault:input_drive=0x2310@5``."""

from __future__ import annotations

import re
from dataclasses import dataclass

_PATTERN = re.compile(r"(?P<name>[a-z0-9_]+)(:(?P<role>[a-z_]+))?(=(?P<value>[-+.0-9a-fA-FxX]+))?(@(?P<at>[0-9.]+))?\Z")


@dataclass(frozen=True, slots=True)
class FaultRequest:
    """A fault by name, the slave it strikes, its parameter, and when it comes (s from now, None at once)."""

    name: str
    role: str | None = None
    value: float | None = None
    at_s: float | None = None


def parse_fault(text: str) -> FaultRequest:
    """Return the request a text stands for.

    Raises
    ------
    ValueError : the text is not of the form.
    """
    found = _PATTERN.match(text)
    if found is None:
        raise ValueError(
            f"fault {text!r} must be name[:slave][=value][@seconds], such as drive_fault:input_drive=0x2310@5"
        )
    value = found["value"]
    try:
        number = None if value is None else float(int(value, 16)) if value.lower().startswith("0x") else float(value)
        at = None if found["at"] is None else float(found["at"])
    except ValueError:
        raise ValueError(f"fault {text!r}: {value!r} is no number") from None
    return FaultRequest(found["name"], found["role"], number, at)
