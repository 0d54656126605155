"""Torque sensor behind an analogue terminal: scale, taring, plausibility."""

from drivers.torque_sensor.plausibility import Findings, PlausibilityLimits, PlausibilityMonitor
from drivers.torque_sensor.scale import TorqueScale
from drivers.torque_sensor.tare import Drift, Tare, drift, take_tare
from drivers.torque_sensor.terminal import AnalogInput, analog_input

__all__ = [
    "AnalogInput",
    "Drift",
    "Findings",
    "PlausibilityLimits",
    "PlausibilityMonitor",
    "Tare",
    "TorqueScale",
    "analog_input",
    "drift",
    "take_tare",
]
