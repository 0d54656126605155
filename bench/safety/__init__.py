"""Limits, plausibility and the stop ladder, as pure functions. They protect equipment and data, not people."""

from bench.safety.causes import Cause, Rung, describe, first_rung, is_device_fault
from bench.safety.ladder import Deadlines, LadderState, Observation, climb
from bench.safety.latch import Act, Latch, LatchFile, Standing
from bench.safety.step import Inputs, SafetySettings, SafetyState, Verdict, settings, step
from bench.safety.stop_record import StopRecord

__all__ = [
    "Act",
    "Cause",
    "Deadlines",
    "Inputs",
    "LadderState",
    "Latch",
    "LatchFile",
    "Observation",
    "Rung",
    "SafetySettings",
    "SafetyState",
    "Standing",
    "StopRecord",
    "Verdict",
    "climb",
    "describe",
    "first_rung",
    "is_device_fault",
    "settings",
    "step",
]
