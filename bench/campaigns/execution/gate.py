"""The quality gate: is a recording what was asked for? Judged right after it was made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from bench.campaigns.records.recorder import SteadyFigures
from bench.configuration import BenchConfiguration
from bench.protocols import Point

_WITH_REVOLUTION = {"constant_velocity", "validation"}
_VELOCITY_BAND = 0.01
_TORQUE_BAND = 0.02


@dataclass(frozen=True, slots=True)
class Check:
    """One question to a recording, what was found and what is allowed (SI, °C).

    ``value`` is None where nobody looked: this kind of recording, or this point, has nothing to compare it with.
    """

    name: str
    value: float | None
    low: float = -math.inf
    high: float = math.inf

    @property
    def passed(self) -> bool | None:
        """Whether the value lies within its bounds; None where it was not checked, False for NaN."""
        return None if self.value is None else self.low <= self.value <= self.high

    @property
    def text(self) -> str:
        """A sentence."""
        if self.value is None:
            return f"{self.name} was not looked at"
        verdict = "within" if self.passed else "outside"
        return f"{self.name} {self.value:.6g} is {verdict} {self.low:.6g} … {self.high:.6g}"


@dataclass(frozen=True, slots=True)
class Gate:
    """The checks of one recording, including those that could not be made."""

    checks: tuple[Check, ...]

    @property
    def passed(self) -> bool:
        """Whether every check that was made passed; without any check a recording does not pass."""
        made = [check.passed for check in self.checks if check.passed is not None]
        return bool(made) and all(made)

    @property
    def failures(self) -> str:
        """The failed checks as a sentence, empty if there are none."""
        return "; ".join(check.text for check in self.checks if check.passed is False)

    def as_dict(self) -> dict[str, Any]:
        """For the recording's and the manifest's ``quality``; ``passed`` is None where nothing was checked."""
        return {
            check.name: {
                "passed": check.passed,
                "value": None if check.value is None else _number(check.value),
                "low": _number(check.low),
                "high": _number(check.high),
            }
            for check in self.checks
        }


def judge(point: Point, kind: str, figures: SteadyFigures, bench: BenchConfiguration) -> Gate:
    """Return every check, made where it applies to a recording of this kind.

    The load runs open loop: the sensor sees the set torque up to the load side's friction and ripple, hence its band.
    """
    revolves = kind in _WITH_REVOLUTION
    speed, torque, temperature = point.velocity, point.load_torque, point.temperature
    slack = 3.0 * bench.nominal.load_friction + _TORQUE_BAND * abs(torque)
    # the band applies when the point starts; it may cool by half of it while it is measured
    warm = (temperature or 0.0) - 1.5 * bench.heating.band, (temperature or 0.0) + 1.5 * bench.heating.band
    # of a recording without rows nothing is known, which is no pass
    lost, saturated = (float(count) if figures.rows else math.nan for count in (figures.lost_cycles, figures.saturated))
    slow, fast = sorted((speed * (1 - _VELOCITY_BAND), speed * (1 + _VELOCITY_BAND)))
    table: tuple[tuple[str, bool, float, float, float], ...] = (
        ("lost_cycles", True, lost, 0.0, 0.0),
        ("saturated_samples", True, saturated, 0.0, 0.0),
        ("travel", revolves, figures.travel, 2.0 * math.pi, math.inf),
        ("velocity", revolves, figures.velocity, slow, fast),
        ("load_torque", revolves, figures.load_torque, torque - slack, torque + slack),
        ("temperature_low", revolves and temperature is not None, figures.temperature_low, warm[0], math.inf),
        ("temperature_high", revolves and temperature is not None, figures.temperature_high, -math.inf, warm[1]),
    )
    return Gate(
        tuple(
            Check(name, value, low, high) if applies else Check(name, None) for name, applies, value, low, high in table
        )
    )


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
