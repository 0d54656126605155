"""Whether what a campaign and its sequences ask for is a motion at all: finite, bounded, without a step.

Looked at before anything is generated from it, and once more right before it runs: limits are compared with numbers,
and a number that is none is below every limit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from numbers import Real
from typing import Protocol

from bench.configuration import BenchConfiguration
from bench.errors import ConfigurationError, LimitError
from bench.protocols import Phase, Point

MOST_POINTS = 20_000
"""Points of one campaign."""
MOST_REPEATS = 10_000
MOST_PHASES = 100_000
"""Phases of one point."""
LONGEST_S = 48.0 * 3600.0
"""One point, and one phase of it."""
_ROUNDING = 1.0 + 1e-6
_SAME = 1e-9


class Values(Protocol):
    """A block of points to be made: lists of values in SI, and options."""

    @property
    def sequence(self) -> str:
        """Name of the sequence."""
        ...

    @property
    def load_torques(self) -> tuple[float, ...]:
        """N·m."""
        ...

    @property
    def velocities(self) -> tuple[float, ...]:
        """Load side, rad/s."""
        ...

    @property
    def temperatures(self) -> tuple[float | None, ...]:
        """°C; None for as found."""
        ...

    @property
    def repeats(self) -> int:
        """How often."""
        ...

    @property
    def options(self) -> tuple[tuple[str, float], ...]:
        """Options of the sequence."""
        ...


def check_block(block: Values, where: str) -> None:
    """Refuse a block with values that are no finite numbers, or of more points than anyone measures.

    Raises
    ------
    ConfigurationError
        With the place: stage, sequence, list and position.
    """
    lists: tuple[tuple[str, Sequence[float | None]], ...] = (
        ("load_torques", block.load_torques),
        ("velocities", block.velocities),
        ("temperatures", block.temperatures),
    )
    for name, values in lists:
        for index, value in enumerate(values, 1):
            if not (value is None and name == "temperatures"):
                _require_number(value, f"{where}: {name}[{index}]")
    for name, option in block.options:
        _require_number(option, f"{where}: option {name}")
    if isinstance(block.repeats, bool) or not isinstance(block.repeats, int) or not 1 <= block.repeats <= MOST_REPEATS:
        raise ConfigurationError(
            f"{where}: repeats = {block.repeats!r}, it must be a whole number from 1 to {MOST_REPEATS}"
        )
    count = block.repeats * math.prod(len(values) for _, values in lists)
    if count > MOST_POINTS:
        raise ConfigurationError(f"{where}: {count} points, {MOST_POINTS} are the most of a campaign")


def check_points(points: Sequence[Point], where: str) -> None:
    """Refuse points a sequence has made of values that are no finite numbers.

    Raises
    ------
    ConfigurationError
        With the place.
    """
    if len(points) > MOST_POINTS:
        raise ConfigurationError(f"{where}: {len(points)} points, {MOST_POINTS} are the most of a campaign")
    for number, point in enumerate(points, 1):
        if not isinstance(point, Point):
            raise ConfigurationError(f"{where}: point {number} is {type(point).__name__}, no bench.protocols.Point")
        for name in ("load_torque", "velocity", "temperature"):
            value = getattr(point, name)
            if not (value is None and name == "temperature"):
                _require_number(value, f"{where}: {name} of point {number}")


def check_phases(phases: Iterable[Phase], bench: BenchConfiguration, where: str) -> tuple[Phase, ...]:
    """Return the phases of a point, which begin and end at rest without load and ramp no faster than the bench does.

    Raises
    ------
    ConfigurationError
        Values that are no finite numbers, times without end, a phase with a condition that ramps.
    LimitError
        A step of speed or torque, or a ramp steeper than ``motion.motor_acceleration`` or ``motion.torque_rate``.
    """
    checked: list[Phase] = []
    velocity = torque = total = 0.0
    for number, phase in enumerate(phases, 1):
        at = f"{where}, phase {number}"
        if number > MOST_PHASES:
            raise ConfigurationError(f"{where}: more than {MOST_PHASES} phases; measure it as several points")
        _check_values(phase, at)
        total += phase.duration_s
        if total > LONGEST_S:
            raise ConfigurationError(
                f"{at}: the point takes {total / 3600.0:.4g} h until then, {LONGEST_S / 3600.0:g} h are the most;"
                " choose another speed or time"
            )
        moves = abs(phase.velocity - velocity) > _SAME or abs(phase.load_torque - torque) > _SAME
        if phase.until is not None and moves:
            raise ConfigurationError(f"{at}: it ends on a condition, so it must keep speed and load; ramp before it")
        _check_ramps(phase, velocity, torque, bench, at)
        velocity, torque = phase.velocity, phase.load_torque
        checked.append(phase)
    if abs(velocity) > _SAME or abs(torque) > _SAME:
        raise LimitError(
            f"{where}: it ends at {math.degrees(velocity):.4g} °/s under {torque:.4g} N·m; every point ends at rest"
            " without load"
        )
    return tuple(checked)


def _check_values(phase: Phase, at: str) -> None:
    if not isinstance(phase, Phase):
        raise ConfigurationError(f"{at} is {type(phase).__name__}, no bench.protocols.Phase")
    for name in ("duration_s", "velocity", "load_torque", *(("temperature",) if phase.until is not None else ())):
        _require_number(getattr(phase, name), f"{at}: {name}")
    if phase.duration_s < 0.0:
        raise ConfigurationError(f"{at}: duration_s = {phase.duration_s:g}, a time is not negative")


def _check_ramps(phase: Phase, velocity: float, torque: float, bench: BenchConfiguration, at: str) -> None:
    motion, ratio = bench.motion, bench.gearbox.ratio
    table = (
        (
            "speed",
            math.degrees(velocity),
            math.degrees(phase.velocity),
            "°/s",
            math.degrees(motion.motor_acceleration / ratio),
            "motion.motor_acceleration",
            "velocity_ramp_s",
        ),
        ("load", torque, phase.load_torque, "N·m", motion.torque_rate, "motion.torque_rate", "torque_ramp_s"),
    )
    for what, before, after, unit, rate, limit, helper in table:
        change = abs(after - before)
        needed = change / rate
        if change > _SAME and phase.duration_s * _ROUNDING < needed:
            within = "no time" if phase.duration_s == 0.0 else f"{phase.duration_s:.3g} s"
            raise LimitError(
                f"{at}: the {what} goes from {before:.4g} to {after:.4g} {unit} in {within}; {limit} asks for"
                f" {needed:.3g} s (BenchFacts.{helper} gives it)"
            )


def _require_number(value: object, what: str) -> None:
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise ConfigurationError(f"{what} is {value!r}, it must be a finite number")
