"""Asking somebody for what a file does not contain."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from typing import Any

from bench.errors import BenchError, ConfigurationError
from bench.importing.looking.entries import Draft
from bench.importing.mapping import OPEN
from bench.importing.units import quantity, unit_of
from bench.signals import BY_NAME

_QUESTIONS = {
    "ratio": "revolutions of the motor per revolution of the output (1: direct drive or linear axis)",
    "unit": "unit",
    "torque_constant": "torque per ampere (N·m/A, or with a unit such as '80 N/A')",
    "factor": "factor with its unit",
    "counts_per_revolution": "counts per revolution",
    "at": "side of the gearbox at which the torque is given, 'motor' or 'output' (a joint)",
    "rate": "samples per second",
    "timezone": "time zone of the stamps",
}
_NUMBERS = ("ratio", "counts_per_revolution", "rate")


def ask(draft: Draft, prompt: Callable[[str, str | None], str], say: Callable[[str], None]) -> None:
    """Ask for every value that is open or guessed, until the answer can be right.

    Parameters
    ----------
    prompt : asks a question with the guess as default (None: there is none); gives the answer.
    say : says why an answer was of no use.
    """
    for key, entry in list(draft.entries().items()):
        if entry.sure:
            continue
        name = key.rpartition(".")[2]
        guess = None if entry.value == OPEN else str(entry.value)
        question = f"{key}: {_QUESTIONS.get(name, 'value')}" + (f" ({entry.why})" if entry.why else "")
        while True:
            try:
                value = check_answer(key, prompt(question, guess))
            except BenchError as error:
                say(str(error))
            else:
                break
        draft.set(key, value, "as answered")


def check_answer(key: str, answer: str) -> Any:
    """Read an answer as the value of a key.

    Raises
    ------
    ConfigurationError
        It cannot be one.
    """
    *_, table, name = ("", *key.split("."))
    text = answer.strip()
    try:
        value: Any = tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        value = text
    if name in _NUMBERS:
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or value == 0
            or (name != "ratio" and value < 0)
        ):
            raise ConfigurationError(f"{key}: '{text}' should be a number other than 0, such as 50.")
        return float(value)
    if name == "torque_constant":
        if isinstance(value, int | float):
            return float(value)
        quantity(text, key)
        return text
    if name == "unit":
        signal = BY_NAME.get(table)
        unit_of(str(value), key)
        if signal is not None and signal.unit == "s":
            unit_of(str(value), key, "s")
        return str(value)
    return value
