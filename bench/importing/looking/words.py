"""What a quantity is called in the names of columns and files."""

from __future__ import annotations

import re

from bench.importing.headings import split_heading

_EFFORT = r"^(?!.*(contr|ctrl)).*effort|^(j(oint)?_?\d*_)?eff_?\d*$"
_ROUNDS = r"zyklus|zyklen|cycles?|lastspiele?|lastwechsel|runs?|trials?|versuch"
"""what a test does again and again"""
_NUMBERED = r"n|nr|no|num|number|nummer|count|counter|index|idx|id|zahl|zaehler|zähler"
_QUANTITIES: tuple[tuple[str, str], ...] = (
    ("time", r"^t$|time|zeit|stamp|^date|datum|^x_value$|sekunden|seconds"),
    ("velocity", r"vel|speed|omega|drehz|rpm|upm|u_min|geschw|^n$|^n_|^w$|^w_|^v$|^qd\d*$|^dq\d*$|qdot|thetadot"),
    ("current", r"curr(?!ent_?(pos|ang|vel|speed|torq|temp|time))|^cur\d*$|_cur\d*$|strom|^i$|^i_|_i$|(^|_)iq|ampere"),
    ("torque", r"torq|trq|moment|^m$|^m_(?!enc|pos|ang)|tau|force|kraft|^f$|^f_|^tq|^mot_?m$"),
    ("torque", _EFFORT),
    ("temperature", r"temp|thermo|pt100|^t_?oil|^t_?oel"),
    ("number", rf"(^|_)({_ROUNDS})(_?({_NUMBERED}))?$"),
    (
        "angle",
        r"pos|angle|winkel|theta|phi|lage|enc|(^|_)ang(_|$)|^q\d*$|^q_|^qm$|weg|displ|^x$|stroke|count|rotat"
        r"|umdreh|inkr|geber|(^|_)stellung|(^|_)hub(_|$)|(^|_)az\d*(_|$)|azimut|^el\d*$|elevation",
    ),
)
"""Quantities by what their names look like, the likelier first. A "current position" is the present one."""

SIGNALS = {
    "angle in %": "what 100 % is, such as '90 deg'",
    "angle in V": "such as '36 deg/V'",
    "torque in V": "such as '120 N*m/V'",
}
"""quantities by their names, in per cent of a travel or in a sensor's volts, with the ``factor`` they need"""

SET_VALUE = re.compile(
    r"set|ref(?!er)|cmd|command|soll|desired|_des\d*$|target|goal|^control_(pos|ang|vel|speed)|^qg$|demand"
)
"""in the name, in small letters, of what was asked for and not measured"""

_ROS = {
    "angle": re.compile(r"(?<![a-z])pos(itions?)?(?![a-z])"),
    "velocity": re.compile(r"(?<![a-z])vel(ocit(y|ies))?(?![a-z])"),
}
"""names of a joint's motion in ROS (sensor_msgs/JointState), in small letters"""


def quantity_of(name: str) -> str:
    """The quantity that a name in small letters, with ``_`` between its words, seems to be of; empty where none."""
    return next((quantity for quantity, form in _QUANTITIES if re.search(form, name)), "")


def is_effort(heading: str) -> bool:
    """Whether a torque is called as ROS calls that of a joint (sensor_msgs/JointState)."""
    name = re.split(r"[/.]", split_heading(heading)[0])[-1]
    return re.search(_EFFORT, name.strip().lower().replace(" ", "_")) is not None


def as_in_ros(heading: str, quantity: str) -> bool:
    """Whether an angle or a velocity is called as ROS calls that of a joint."""
    return _ROS[quantity].search(heading.lower()) is not None
