"""The motor's angle where none was measured: everything that is compared over an angle or a speed needs it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from bench.importing.channel import LINEAR, Channel
from bench.importing.channel_mapping import ChannelMapping
from bench.recording.header import ChannelSpec
from bench.signals import BY_NAME

INTEGRAL = "integral of "
"""begins the origin of an angle that is the integral of a speed"""
OF_OUTPUT = " of the output, times gearbox.ratio "
"""stands in the origin of an angle or a speed that is the output's, times the ratio"""
_GEARED = 10.0
"""Gear ratio from which a motor that turns less than once moves the output by less than a tenth of a revolution: few
machines are measured so."""
_WHOLE = 1e-6
"""how near to whole turns of the output a motor's angle starts again for its position to stay known (rounding)"""
FROM_OUTPUT = "the motor's angle was not measured"
"""begins the note of an angle that is the output's, times the ratio"""
SPEED_FROM_OUTPUT = "the motor's speed was not measured"
"""begins the note of a speed that is"""


def add_motor_angle(channels: dict[str, Channel], notes: list[str], *, ratio: float, linear: bool) -> None:
    """Make ``motor_angle`` of what was measured, and note it: of the output's angle if the motor's torque is there,
    else of the motor's speed, which may be the output's times the ratio too.
    """
    if "motor_angle" in channels:
        return
    if {"load_angle", "motor_torque"} <= channels.keys():
        channels["motor_angle"] = _of_output(channels, "angle", ratio, linear=linear)
        notes.append(
            f"{FROM_OUTPUT}: motor_angle is load_angle times gearbox.ratio {ratio:g}, so load_angle is not kept beside "
            "it and there is no transmission error"
        )
        return
    if {"load_velocity", "motor_torque"} <= channels.keys() and not {"motor_velocity", "load_angle"} & channels.keys():
        channels["motor_velocity"] = _of_output(channels, "velocity", ratio, linear=linear)
        notes.append(
            f"{SPEED_FROM_OUTPUT}: motor_velocity is load_velocity times gearbox.ratio {ratio:g}, so there is "
            "no load_velocity beside it"
        )
    if "motor_velocity" in channels and "load_angle" not in channels:
        speed = channels["motor_velocity"]
        step = np.diff(channels["time"].si)
        angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed.si[1:] + speed.si[:-1]) * step)))
        channels["motor_angle"] = _channel(
            "motor_angle", angle, f"{INTEGRAL}{speed.spec.origin}, from 0", speed, linear=linear
        )
        notes.append(
            "motor_angle is the integral of motor_velocity: it has no zero of its own and drifts with that of the "
            "velocity"
        )


def lost_zero(channels: Mapping[str, Channel], wanted: Mapping[str, ChannelMapping], ratio: float) -> str | None:
    """Say by how much the output's position may differ between files, where the motor's angle starts again and its
    turns are counted anew in each; None where the output's position is known.
    """
    wraps_at = wanted["motor_angle"].wraps_at if "motor_angle" in wanted else None
    if wraps_at is None or "load_angle" in channels:
        return None
    spec = channels["motor_angle"].spec
    step = abs(wraps_at * spec.scale / ratio)
    turns = step / (2 * np.pi)
    if spec.unit == "rad" and abs(turns - round(turns)) < _WHOLE:
        return None
    size = f"{360.0 * turns:.4g}°" if spec.unit == "rad" else f"{step:.4g} {spec.unit}"
    return (
        f"motor_angle starts again at wraps_at = {wraps_at:g} and its turns are counted anew in each file: from file "
        f"to file the position of the output is known up to multiples of {size} only; one file with pieces keeps it"
    )


def hardly_turns(channels: Mapping[str, Channel], ratio: float) -> str | None:
    """Say that a motor turns less than once, where the gearbox turns it many times as far as the output: the angle may
    be the output's. None where it turns more, or its side is known from other channels.
    """
    angle = channels.get("motor_angle")
    if angle is None or "load_angle" in channels or abs(ratio) < _GEARED or angle.spec.unit != "rad":
        return None
    if OF_OUTPUT in angle.spec.origin or not 0.0 < float(np.ptp(angle.si)) < 2 * np.pi:
        return None
    return (
        f"motor_angle turns less than once, so the output with gearbox.ratio {ratio:g} less than "
        f"{360.0 / abs(ratio):.2g}°: if it is the output's angle (a joint's), [channels.load_angle] instead of "
        "[channels.motor_angle] would be right"
    )


def _of_output(channels: dict[str, Channel], quantity: str, ratio: float, *, linear: bool) -> Channel:
    """The motor's angle or velocity from the output's, which is taken out of the channels: the difference of both would
    be zero, which nobody measured.
    """
    output = channels.pop(f"load_{quantity}")
    origin = f"{output.spec.origin}, the {quantity}{OF_OUTPUT}{ratio:g}"
    return _channel(f"motor_{quantity}", ratio * output.si, origin, output, linear=linear)


def _channel(name: str, values: NDArray[np.float64], origin: str, measured: Channel, *, linear: bool) -> Channel:
    signal = BY_NAME[name]
    unit = LINEAR[signal.unit] if linear else signal.unit
    spec = ChannelSpec(name, unit, description=signal.description, origin=origin)
    return Channel(values, spec, measured.source)
