"""Limits, plausibility and the stop ladder, as pure functions. They protect equipment and data, not people."""

from bench.safety.causes import Cause, Rung, describe, first_rung, is_device_fault
from bench.safety.ladder import Deadlines, LadderState, Observation, climb
from bench.safety.step import Inputs, SafetySettings, SafetyState, Verdict, settings, step

__all__ = [
    "Cause",
    "Deadlines",
    "Inputs",
    "LadderState",
    "Observation",
    "Rung",
    "SafetySettings",
    "SafetyState",
    "Verdict",
    "climb",
    "describe",
    "first_rung",
    "is_device_fault",
    "settings",
    "step",
]
