"""The library of physics terms: one small file a term, the nominal simulation's and the vocabulary's."""

from bench.simulation.terms.base import (
    CHANNEL_UNITS,
    LOAD_TORQUE,
    MOTOR_TORQUE,
    TEMPERATURE,
    TRANSMISSION_ERROR,
    Form,
    Point,
    Symbol,
    Term,
)
from bench.simulation.terms.table import LIBRARY, for_channel, nominal_for

__all__ = [
    "CHANNEL_UNITS",
    "LIBRARY",
    "LOAD_TORQUE",
    "MOTOR_TORQUE",
    "TEMPERATURE",
    "TRANSMISSION_ERROR",
    "Form",
    "Point",
    "Symbol",
    "Term",
    "for_channel",
    "nominal_for",
]
