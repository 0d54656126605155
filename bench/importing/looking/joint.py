"""Position, velocity and effort of one joint, as ROS names them: all three are of the output."""

from __future__ import annotations

from collections.abc import Mapping

from bench.importing.looking.column import Column
from bench.importing.looking.entries import Draft, Entry
from bench.importing.looking.names import Meaning
from bench.importing.looking.tables import GUESS
from bench.importing.looking.words import as_in_ros
from bench.importing.mapping import OPEN

_TORQUE = "motor_torque"
_MOTION = ("angle", "velocity")
_ROS_UNITS = {"load_angle": "rad", "load_velocity": "rad/s", _TORQUE: "N*m"}
"""what ROS gives them in, where the joint turns"""


def to_joint(taken: dict[str, Column], meanings: Mapping[str, Meaning]) -> bool:
    """Take angle and velocity for the output's where the three are called as in ROS and none as the motor's; gives
    whether they are.
    """
    side = next((side for side in ("motor", "load") if {f"{side}_{one}" for one in _MOTION} <= taken.keys()), None)
    if side is None or _TORQUE not in taken or not meanings[taken[_TORQUE].name].effort:
        return False
    motion = {one: taken[f"{side}_{one}"] for one in _MOTION}
    if not all(as_in_ros(column.variable.name, one) for one, column in motion.items()):
        return False
    if any(meanings[column.name].of_motor for column in (*motion.values(), taken[_TORQUE])):
        return False
    for one, column in motion.items():
        del taken[f"{side}_{one}"]
        taken[f"load_{one}"] = column
    return True


def mark_joint(out: Draft, taken: Mapping[str, Column]) -> None:
    """Write into the tables of a draft that its three channels are a joint's, and what would be right if not."""
    angle, velocity, effort = (taken[name].name for name in _ROS_UNITS)
    out.tables[f"channels.{_TORQUE}"]["at"] = Entry("output", f"{GUESS}: in ROS an effort is the joint's", sure=False)
    for name, unit in _ROS_UNITS.items():
        entry = out.tables[f"channels.{name}"]["unit"]
        if entry.value == OPEN:
            entry.why += f"; ROS gives {unit}"
    out.remarks.append(
        f"{angle}, {velocity} and {effort} were taken for those of a joint (the output), as in ROS: if they are the "
        f"motor's, [channels.motor_angle], [channels.motor_velocity] and at = 'motor' in [channels.{_TORQUE}] would be "
        "right"
    )
