"""Checks of one table of channels; each gives sentences with file, key, what is wrong and what is likely right."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from bench.importing.channel_mapping import PartMapping
from bench.importing.motor_angle import INTEGRAL
from bench.importing.plausible.factors import CLOSE, named, reason
from bench.importing.plausible.motion import blocks
from bench.importing.plausible.torques import torques
from bench.importing.table import ChannelTable
from bench.signals import BY_NAME

FloatArray = NDArray[np.float64]
_ALIKE = 0.85
"""how much of two names is alike (:mod:`difflib`) where one is taken for a misspelling of the other"""
_TOGETHER = 0.9
_SPEEDS = 0.05
_ANGLES = 0.005
_FASTEST = 5000.0
_COLDEST, _HOTTEST = -60.0, 220.0


def implausible(
    table: ChannelTable, ratio: float, where: str, wanted: Mapping[str, PartMapping] = MappingProxyType({})
) -> list[str]:
    """Say what cannot be, one sentence each; ``where`` is the mapping file, ``wanted`` what it says of each channel."""
    found: list[str] = []
    values = {name: channel.si for name, channel in table.channels.items()}
    measured = {n for n, c in table.channels.items() if not c.spec.origin.startswith(INTEGRAL)}
    for side in ("motor", "load"):
        if {f"{side}_angle", f"{side}_velocity"} <= measured:
            found += _speeds(values, side, ratio, where, _counts(wanted, f"{side}_angle"))
    if {"motor_angle", "load_angle"} <= measured:
        found += _angles(values, ratio, where)
    found += _temperatures(values, where)
    if not table.linear:
        found += _too_fast(values, where)
    return found + torques(table, ratio, where, wanted)


def _counts(wanted: Mapping[str, PartMapping], name: str) -> float | None:
    """Counts per revolution that a mapping says of a channel; None where it says none."""
    return wanted[name].counts_per_revolution if name in wanted else None


def misspelt(table: ChannelTable, where: str) -> list[str]:
    """Say which channels have almost the name of one of the bench's that is not there, one sentence each."""
    near = {
        name: get_close_matches(name, BY_NAME, n=1, cutoff=_ALIKE)
        for name in table.channels
        if name not in BY_NAME and not name.startswith("aux/") and "setpoint" not in name
    }
    return [
        f"{where}: channels.{name} is no channel of the bench, so it is kept and not analysed; did you mean "
        f"[channels.{meant[0]}]?"
        for name, meant in near.items()
        if meant and meant[0] not in table.channels
    ]


def _slope(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Slope of y over x, and their correlation; zeros where one of them rests."""
    if float(np.std(x)) == 0.0 or float(np.std(y)) == 0.0:
        return 0.0, 0.0
    correlation = float(np.corrcoef(x, y)[0, 1])
    return correlation * float(np.std(y) / np.std(x)), correlation


def _speeds(values: dict[str, FloatArray], side: str, ratio: float, where: str, counts: float | None) -> Iterator[str]:
    """A velocity is the rate of its angle; ``counts`` per revolution that the angle was made with."""
    velocity = f"{side}_velocity"
    averaged = blocks(values["time"], values[f"{side}_angle"], {velocity: values[velocity]})
    if averaged is None:
        return
    # the difference of the angle from the block before to the next is the speed's integral over both (Simpson's rule)
    said = averaged.channels[velocity]
    x, y = averaged.speed[1:-1], (said[:-2] + 4.0 * said[1:-1] + said[2:]) / 6.0
    # a speed that hardly varies gives its factor by its mean
    steady = abs(float(np.mean(x))) > 3 * float(np.std(x))
    factor, together = (float(np.mean(y) / np.mean(x)), 1.0) if steady else _slope(x, y)
    if abs(together) > _TOGETHER and factor != 0.0 and abs(factor - 1.0) > _SPEEDS:
        said_of_both = f"{where}: channels.{velocity} is {factor:.4g} times the rate of {side}_angle, it should be 1: "
        other = "load" if side == "motor" else "motor"
        if ratio != 1.0 and abs(factor / ratio - 1.0) < CLOSE:
            wrong = f"{side}_angle" if side == "motor" else velocity
        elif ratio != 1.0 and abs(factor * ratio - 1.0) < CLOSE:
            wrong = velocity if side == "motor" else f"{side}_angle"
        elif counts is not None and factor > 0.0 and not named(factor, ratio):
            yield (
                f"{said_of_both}likely channels.{side}_angle.counts_per_revolution is not {counts:g}, "
                f"{counts / factor:.5g} would be right; or else scale times {1.0 / factor:.4g} of {velocity}."
            )
            return
        else:
            yield f"{said_of_both}{reason(factor, ratio)} (of it, or the inverse of {side}_angle)."
            return
        right = wrong.replace(side, other)
        yield (
            f"{said_of_both}likely {wrong} is of the other side of the gearbox; [channels.{right}] instead of "
            f"[channels.{wrong}] would be right."
        )


def _angles(values: dict[str, FloatArray], ratio: float, where: str) -> Iterator[str]:
    """Both ends of a gearbox turn together."""
    x, y = values["motor_angle"] / ratio, values["load_angle"]
    factor, together = _slope(x, y)
    if abs(together) < 0.999 or factor == 0.0 or abs(factor - 1.0) < _ANGLES:
        return
    yield (
        f"{where}: channels.load_angle turns {factor:.4g} times as far as motor_angle over gearbox.ratio {ratio:g}, it "
        f"should be 1: {reason(factor, ratio)} of load_angle, or gearbox.ratio = {ratio / factor:.6g}."
    )


def _temperatures(values: dict[str, FloatArray], where: str) -> Iterator[str]:
    for name in ("temperature", "ambient_temperature"):
        if name not in values:
            continue
        usual = float(np.median(values[name]))
        if not _COLDEST < usual < _HOTTEST:
            likely = "unit = 'K'" if 230.0 < usual < 420.0 else "a unit or scale that makes degrees Celsius of it"
            yield f"{where}: channels.{name} is {usual:.4g} °C, which no lubricant is; {likely} would be right."


def _too_fast(values: dict[str, FloatArray], where: str) -> Iterator[str]:
    if "motor_angle" not in values:
        return
    averaged = blocks(values["time"], values["motor_angle"], {})
    if averaged is None:
        return
    fastest = float(np.percentile(np.abs(averaged.speed), 99))
    if fastest > _FASTEST:
        yield (
            f"{where}: channels.motor_angle turns at {fastest:.4g} rad/s ({fastest * 30 / np.pi:.4g} rpm), "
            "faster than motors do; a unit such as 'deg', or another unit of channels.time, would be right."
        )
