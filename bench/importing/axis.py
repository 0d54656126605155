"""Whether an axis turns or is linear, by its channels' units; both at once is a mistake in one of them."""

from __future__ import annotations

from collections.abc import Mapping

from bench.importing.channel import LINEAR

_MOVES = ("motor_angle", "load_angle", "motor_velocity", "load_velocity")
_ANGULAR = {"m": "an angle's, such as 'deg'", "m/s": "that of a speed of rotation, such as 'rpm'"}


def mixture(units: Mapping[str, tuple[str, str]]) -> str | None:
    """Say what is wrong where an angle or a speed is in metres and a torque is not in newtons; None where nothing is.

    ``units`` has the SI unit of each channel, and the unit as the file or mapping has it.
    """
    lengths = [name for name in _MOVES if name in units and units[name][0] in _ANGULAR]
    turning = [name for name, (si, _) in units.items() if si in LINEAR]
    if not lengths or not turning:
        return None
    (si, unit), (other, _) = units[lengths[0]], units[turning[0]]
    return (
        f"channels.{lengths[0]}.unit is '{unit}', which becomes {si}, and channels.{turning[0]} is in {other}: the unit"
        f" should be {_ANGULAR[si]}; on a linear axis all should be of metres and newtons, 'factor' or"
        " 'torque_constant' with a unit makes them so, such as '10 mm/rev' or '80 N/A'"
    )
