"""What a recording cannot be used for, because a channel is missing."""

from __future__ import annotations

from collections.abc import Collection

from bench.recording.reader import Recording

_RULES_OUT: dict[str, str] = {
    "motor_angle": "no transmission error and no position-dependent effect",
    "load_angle": "no transmission error",
    "motor_velocity": "no friction and no inertia",
    "motor_torque": "no input torque balance: no friction, no inertia, no heating by losses",
    "load_torque": "no dependence on load and no load side",
    "load_motor_torque": "no load side",
    "temperature": "no dependence on temperature and no heat balance",
    "cycle": "no count of lost samples other than by time",
}


def consequences(recording: Recording, told: Collection[str] = ()) -> tuple[str, ...]:
    """Say for each missing channel, in one sentence, what it rules out; derived velocities are not missing.

    ``told`` names channels of which it was said already.
    """
    return tuple(
        f"{recording.path}: there is no channel '{name}', so there is {effect}."
        for name, effect in _RULES_OUT.items()
        if name not in recording and name not in told
    )
