"""The quality gate: is a recording what was asked for? Judged right after it was made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from bench.campaigns.recorder import SteadyFigures
from bench.configuration import BenchConfiguration
from bench.protocols import Point

_WITH_REVOLUTION = {"constant_velocity", "validation"}
_VELOCITY_BAND = 0.01
_TORQUE_BAND = 0.02


@dataclass(frozen=True, slots=True)
class Check:
    """One question to a recording, what was found and what is allowed (SI, °C)."""

    name: str
    value: float
    low: float
    high: float

    @property
    def passed(self) -> bool:
        """Whether the value lies within its bounds; not a number does not."""
        return self.low <= self.value <= self.high

    @property
    def text(self) -> str:
        """A sentence."""
        verdict = "within" if self.passed else "outside"
        return f"{self.name} {self.value:.6g} is {verdict} {self.low:.6g} … {self.high:.6g}"


@dataclass(frozen=True, slots=True)
class Gate:
    """The checks of one recording."""

    checks: tuple[Check, ...]

    @property
    def passed(self) -> bool:
        """Whether all checks passed."""
        return all(check.passed for check in self.checks)

    @property
    def failures(self) -> str:
        """The failed checks as a sentence, empty if there are none."""
        return "; ".join(check.text for check in self.checks if not check.passed)

    def as_dict(self) -> dict[str, Any]:
        """For the recording's and the manifest's ``quality``."""
        return {
            check.name: {
                "passed": check.passed,
                "value": _number(check.value),
                "low": _number(check.low),
                "high": _number(check.high),
            }
            for check in self.checks
        }


def judge(point: Point, kind: str, figures: SteadyFigures, bench: BenchConfiguration) -> Gate:
    """Return the checks that apply to a recording of this kind.

    The load runs open loop: the sensor sees the set torque up to the load side's friction and ripple, hence its band.
    """
    checks = [
        Check("lost_cycles", figures.lost_cycles, 0, 0),
        Check("saturated_samples", figures.saturated, 0, 0),
    ]
    if kind in _WITH_REVOLUTION:
        speed, torque = point.velocity, point.load_torque
        slack = 3.0 * bench.nominal.load_friction + _TORQUE_BAND * abs(torque)
        checks += [
            Check("travel", figures.travel, 2.0 * math.pi, math.inf),
            Check("velocity", figures.velocity, *sorted((speed * (1 - _VELOCITY_BAND), speed * (1 + _VELOCITY_BAND)))),
            Check("load_torque", figures.load_torque, torque - slack, torque + slack),
        ]
        if point.temperature is not None:
            # the band applies when the point starts; it may cool by half of it while it is measured
            band = 1.5 * bench.heating.band
            checks += [
                Check("temperature_low", figures.temperature_low, point.temperature - band, math.inf),
                Check("temperature_high", figures.temperature_high, -math.inf, point.temperature + band),
            ]
    return Gate(tuple(checks))


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
