"""Limits, plausibility and the stop ladder, as pure functions. They protect equipment and data, not people."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bench.safety.causes import Cause, Rung, describe, first_rung, is_device_fault
    from bench.safety.judge import Inputs, SafetySettings, SafetyState, Verdict, settings, step
    from bench.safety.ladder import Deadlines, LadderState, Observation, climb
    from bench.safety.latch import Act, Latch, Standing
    from bench.safety.latch_file import LatchFile
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

_WHERE = {
    "Cause": "causes",
    "Rung": "causes",
    "describe": "causes",
    "first_rung": "causes",
    "is_device_fault": "causes",
    "Deadlines": "ladder",
    "LadderState": "ladder",
    "Observation": "ladder",
    "climb": "ladder",
    "Act": "latch",
    "Latch": "latch",
    "Standing": "latch",
    "LatchFile": "latch_file",
    "Inputs": "judge",
    "SafetySettings": "judge",
    "SafetyState": "judge",
    "Verdict": "judge",
    "settings": "judge",
    "step": "judge",
    "StopRecord": "stop_record",
}


def __getattr__(name: str) -> Any:
    """Load what is asked for: a shell that stops the bench waits for no compiler."""
    if name in _WHERE:
        return getattr(import_module(f"bench.safety.{_WHERE[name]}"), name)
    raise AttributeError(f"module 'bench.safety' has no attribute '{name}'")
