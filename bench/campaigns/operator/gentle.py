"""How gently a bench is moved by hand: slowly, and with little torque."""

from __future__ import annotations

from dataclasses import replace

from bench.configuration import BenchConfiguration, BenchFile

SPEED_SHARE = 0.05
"""Of the greatest motor speed: so fast, and no faster, is anything moved by hand."""
TORQUE_SHARE = 0.25
"""Of the greatest motor torque: more stops the bench."""
_SLOWER = 1.25
"""The speed limit while somebody moves it, over the greatest speed that may be asked for."""


def greatest_speed(bench: BenchConfiguration) -> float:
    """Return the greatest speed by hand in rad/s of the load side."""
    return SPEED_SHARE * bench.limits.motor_speed / bench.gearbox.ratio


def gentle(file: BenchFile) -> BenchFile:
    """Return the bench with the limits of motion by hand: lower motor torque and speed, the others as they are."""
    limits = file.configuration.limits
    lower = limits.model_copy(
        update={
            "motor_torque": TORQUE_SHARE * limits.motor_torque,
            "motor_speed": _SLOWER * SPEED_SHARE * limits.motor_speed,
        }
    )
    return replace(file, configuration=file.configuration.model_copy(update={"limits": lower}))
