"""What functions do in the temperature: rates of the heat balance, or what its thermometer reads beyond it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.simulation.frame import FloatArray, Frame
from bench.simulation.memory import integral
from bench.simulation.quantities import READ


def is_read(times: str) -> bool:
    """Whether a function times these factors is of a thermometer's reading, and no rate."""
    return READ in times.split("*")


def of_temperature(parts: FloatArray, times: Sequence[str], frame: Frame) -> FloatArray:
    """Columns (n, k) of the temperature: of ``parts`` (n, k), each with the factors of its ``times``, the rates
    integrated over each recording, what is read beyond the temperature as it is.
    """
    columns = [parts[:, k] if is_read(one) else integral(parts[:, k], frame) for k, one in enumerate(times)]
    return np.column_stack(columns)


def left_side(times: Sequence[str]) -> str:
    """What an equation of the temperature begins with."""
    return "temperature" if times and all(map(is_read, times)) else "dT/dt"


def as_rate(text: str, times: str, of_all: Sequence[str]) -> str:
    """A part of an equation of the temperature, whose parts have the factors ``of_all``: beside rates, what is read is
    told by its rate.
    """
    return f"d({text})/dt" if is_read(times) and left_side(of_all) == "dT/dt" else text


def unit_of_function(times: str) -> str:
    """Unit of a function in the temperature."""
    return "K" if is_read(times) else "K/s"
