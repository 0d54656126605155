"""Trying a bench out before it may run: slaves, limits, safety circuits, signs, brakes, tare, the encoders' zero."""

from bench.commissioning.record import Commissioned, StepRecord, Zero, require_commissioned
from bench.commissioning.session import commission

__all__ = ["Commissioned", "StepRecord", "Zero", "commission", "require_commissioned"]
