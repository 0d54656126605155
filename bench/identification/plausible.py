"""Identified values that cannot be, or hardly: which, and what they usually come from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

KEY = "implausible"
"""Key of a term in a simulation file: symbol → sentence, for each value that stands there and cannot be."""


@dataclass(frozen=True, slots=True)
class _Bounds:
    """Open bounds of what can be, and what a value beyond them usually comes from."""

    low: float
    high: float
    cause: str


_SIGN = "the sign of the motor torque or of an angle is turned, or the motor torque is what the drive was asked for"
_LAG = "torque and angle are not of the same instant, or the drive's feedforward is missing in its torque"
_BOUNDS: dict[str, _Bounds] = {
    "J": _Bounds(0.0, math.inf, _LAG),
    "J_L": _Bounds(0.0, math.inf, "the load accelerates too little beside the load motor's ripple (see --notch)"),
    "f_c": _Bounds(0.0, math.inf, _SIGN),
    "f_v": _Bounds(0.0, math.inf, "the speeds are too close together, or another loss falls with speed"),
    "f_l": _Bounds(0.0, math.inf, "the gear ratio or the scale of the torque sensor is wrong"),
    "f_b": _Bounds(0.0, math.inf, "the sign of the load motor's torque or of the torque sensor is turned"),
    "C": _Bounds(0.0, math.inf, "warming does not follow the power: a torque's sign is turned"),
    "R": _Bounds(0.0, math.inf, "warmth comes in beside the measured power: the motor's, or the sun's"),
    "T_amb": _Bounds(-40.0, 80.0, "the thermometer lies beside the lubricant, or another body takes up heat"),
}
_ALLOWED_SIGMA = 2.0


def implausible(values: Mapping[str, float], std: Mapping[str, float | None]) -> dict[str, str]:
    """Sentences by symbol for impossible values; they say where one is within two standard deviations of its bound."""
    out: dict[str, str] = {}
    for symbol, bounds in _BOUNDS.items():
        value = values.get(symbol)
        if value is None or bounds.low < value < bounds.high:
            continue
        limit = bounds.low if value <= bounds.low else bounds.high
        side = "above" if value <= bounds.low else "below"
        sigma = std.get(symbol)
        if sigma is not None and abs(value - limit) <= _ALLOWED_SIGMA * sigma:
            out[symbol] = (
                f"{symbol} is {value:.3g} ± {sigma:.2g} and should be {side} {limit:g}: it cannot be distinguished "
                f"from {limit:g}, the recordings say too little of it."
            )
        else:
            out[symbol] = f"{symbol} is {value:.3g} and should be {side} {limit:g}; the likely cause: {bounds.cause}."
    return out
