"""A torque that is given at the output, as ROS gives a joint's effort: over the ratio it is the motor's."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from bench.errors import ConfigurationError
from bench.importing.channel import Channel
from bench.importing.channel_mapping import ChannelMapping
from bench.importing.looking.words import is_effort

_TORQUE = "motor_torque"
AT_OUTPUT = "the motor's torque was given at the output"
"""begins the note of a torque that is the output's over the ratio"""
_DIRECT = 1e-9
"""how near to 1 a ratio (its size) is of no gearbox: both shafts have one torque"""


def to_motor(channels: dict[str, Channel], wanted: Mapping[str, ChannelMapping], ratio: float, where: str) -> list[str]:
    """Divide a torque by the ratio where its mapping says that it is given at the output; gives notes of it.

    Raises
    ------
    ConfigurationError
        Another channel says so.
    """
    others = [name for name, entry in wanted.items() if entry.at is not None and name != _TORQUE]
    if others:
        raise ConfigurationError(
            f"{where}: {others[0].replace('/', '.') if '/' in others[0] else f'channels.{others[0]}'}.at: is only for "
            f"channels.{_TORQUE}; the name of any other channel says its side, such as load_angle for the output's."
        )
    if _TORQUE not in wanted or wanted[_TORQUE].at != "output":
        return []
    measured = channels[_TORQUE]
    spec = measured.spec
    channels[_TORQUE] = replace(
        measured,
        spec=replace(
            spec,
            scale=spec.scale / ratio,
            offset=spec.offset / ratio,
            origin=f"{spec.origin}, of the output, over gearbox.ratio {ratio:g}",
        ),
    )
    return [
        f"{AT_OUTPUT} (at = 'output'): {_TORQUE} is that over gearbox.ratio {ratio:g}, without losses of the gearbox"
    ]


def may_be_of_output(wanted: Mapping[str, ChannelMapping], ratio: float) -> str | None:
    """Say that a torque is called as that of a joint is and was taken for the motor's; None where its mapping says on
    which side it is, or turns it into something by a factor.
    """
    entry = wanted.get(_TORQUE)
    if entry is None or entry.at is not None or entry.variable is None or abs(abs(ratio) - 1.0) < _DIRECT:
        return None
    plain = entry.scale == 1.0 and entry.factor is None and entry.torque_constant is None
    if not (plain and is_effort(entry.variable)):
        return None
    return (
        f"{_TORQUE} is '{entry.variable}' as it stands in the file, and ROS gives an effort at the joint: if so, at = "
        f"'output' in [channels.{_TORQUE}] would be right, which divides it by gearbox.ratio {ratio:g}; at = 'motor' "
        "says that it is the motor's"
    )
