"""Attributes and strings of HDF5 files by whatever library wrote them: bytes or str, scalar or one-element array."""

from __future__ import annotations

import json
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

_T = TypeVar("_T")


class AttributeProblem(ValueError):
    """An attribute that is absent or cannot be read as what it should be; the text is half a sentence."""


class AttributeMissing(AttributeProblem):
    """An attribute that is absent."""


def _scalar(value: Any) -> Any:
    """Unwrap one-element arrays, NumPy scalars and bytes."""
    if isinstance(value, np.ndarray):
        if value.size != 1:
            raise ValueError
        value = value.reshape(())[()]
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace").rstrip("\x00")
    return value.item() if isinstance(value, np.generic) else value


def text(value: Any) -> str:
    """Read an attribute as text (fixed or variable length, bytes or str)."""
    result = _scalar(value)
    if not isinstance(result, str):
        raise ValueError
    return result


def number(value: Any) -> float:
    """Read an attribute as float; integers and float32 are fine, text and booleans are not."""
    result = _scalar(value)
    if isinstance(result, bool | str) or not isinstance(result, int | float):
        raise ValueError
    return float(result)


def integer(value: Any) -> int:
    """Read an attribute as a whole number, also where a library stored it as float."""
    result = number(value)
    if result != int(result):
        raise ValueError
    return int(result)


def boolean(value: Any) -> bool:
    """Read an attribute as bool; libraries without one store 0 and 1."""
    result = _scalar(value)
    if result not in (True, False):
        raise ValueError
    return bool(result)


def moment(value: Any) -> datetime:
    """Read an ISO 8601 attribute as aware UTC datetime; a time without zone is UTC, as the format has it."""
    stamp = datetime.fromisoformat(text(value).strip())
    return stamp.replace(tzinfo=UTC) if stamp.tzinfo is None else stamp.astimezone(UTC)


def json_object(value: Any) -> dict[str, Any]:
    """Read an attribute that holds a JSON object as text."""
    parsed = json.loads(text(value))
    if not isinstance(parsed, dict):
        raise ValueError
    return parsed


_EXPECTED: dict[Callable[[Any], Any], str] = {
    text: "text",
    number: "a number",
    integer: "a whole number",
    boolean: "a bool",
    json_object: "a JSON object as text",
    moment: "a date and time in ISO 8601, such as 2026-11-21T09:00:00Z",
}


_SHOWN = 80  # characters of a wrong value in an error text


def read(attributes: Any, name: str, kind: Callable[[Any], _T]) -> _T:
    """Read attribute ``name`` as ``kind`` or raise :class:`AttributeProblem` saying what stands there instead."""
    try:
        value = attributes[name]
    except KeyError:
        raise AttributeMissing(f"attribute '{name}' is missing, it should be {_EXPECTED[kind]}") from None
    except (OSError, TypeError, ValueError) as error:
        raise AttributeProblem(
            f"attribute '{name}' cannot be read ({error}), it should be {_EXPECTED[kind]}"
        ) from error
    try:
        return kind(value)
    except (ValueError, OverflowError, TypeError):
        shown = " ".join(repr(value).split())[:_SHOWN]
        raise AttributeProblem(f"attribute '{name}' is {shown}, it should be {_EXPECTED[kind]}") from None


def strings(values: NDArray[Any]) -> list[str]:
    """Read a one-dimensional string dataset as a list of str."""
    return [text(value) for value in np.atleast_1d(values)]
