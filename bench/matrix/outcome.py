"""What a fault led to, and whether that is what it should."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

from bench.configuration import BenchConfiguration


@dataclass(frozen=True, slots=True)
class Envelope:
    """What the true shafts must never exceed: motor and load speed in rad/s, torque at the sensor in N·m."""

    motor_speed: float
    load_speed: float
    torque: float

    @staticmethod
    def of(bench: BenchConfiguration) -> Envelope:
        """Return the envelope of a bench: a fifth above its speed limit, the load motor's top speed, rated torque."""
        return Envelope(
            1.2 * bench.limits.motor_speed,
            bench.load_motor.maximum_speed,
            min(bench.gearbox.rated_torque, bench.torque_sensor.rated_torque),
        )


@dataclass(slots=True)
class Outcome:
    """What one row led to; ``problems`` is empty where everything is as it should be.

    Times in s from the fault on; None where it did not happen. ``peaks`` are the largest true motor speed, load speed
    and torque, ``drives`` the states of the emulated drives at the end.
    """

    name: str
    text: str
    kind: str
    cause: str = ""
    told: str = ""
    found_s: float | None = None
    rest_s: float | None = None
    off_s: float | None = None
    rungs: tuple[str, ...] = ()
    drives: dict[str, str] = field(default_factory=dict)
    peaks: tuple[float, float, float] = (0.0, 0.0, 0.0)
    read_back: int = 0
    """Recordings that were read back whole."""
    problems: list[str] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether everything is as it should be."""
        return not self.problems

    @property
    def stopped_s(self) -> float | None:
        """From the fault to rest without torque."""
        return None if self.rest_s is None or self.off_s is None else max(self.rest_s, self.off_s)

    def stopped(self, end: Any, stop: Any, elapsed_s: float) -> None:
        """Take cause, sentence and rungs of a stop that was timed from outside."""
        self.cause, self.told = end.cause.name, end.text
        self.rest_s = self.off_s = elapsed_s
        if stop is not None:
            self.found_s = max(0.0, elapsed_s - stop.lasted_s)
            self.rungs = tuple(rung.rung for rung in stop.rungs)

    def require(self, right: bool, sentence: str) -> None:
        """Note a problem unless it is right."""
        if not right:
            self.problems.append(sentence)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {**asdict(self), "passed": self.passed, "stopped_s": self.stopped_s}
