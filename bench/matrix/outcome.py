"""What a fault led to, and whether that is what it should."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any, Self

from bench.configuration import BenchConfiguration

IN_MOTION, UNDER_LOAD = 0.25, 150.0
"""Load-side speed in rad/s and torque in N·m from which on a fault counts as struck in motion and under load."""
_KEYS = {"sentence": "told"}
"""Fields that have another key in files."""


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

    Times in s from the fault on; None where it did not happen or nobody looked. ``struck`` are the true load-side speed
    (rad/s) and torque at the sensor (N·m) when the fault struck, both as amounts; ``peaks`` the largest true motor
    speed, load speed and torque, judged against the envelope on samples ``sampled_s`` apart; each is None where nobody
    looked. ``drives`` are the states of the emulated drives at the end, ``reaction`` what was seen instead of a stop.
    """

    name: str
    text: str
    kind: str
    cause: str = ""
    sentence: str = ""
    """For the operator; its key in files is ``told``."""
    found_s: float | None = None
    rest_s: float | None = None
    off_s: float | None = None
    rungs: tuple[str, ...] = ()
    drives: dict[str, str] = field(default_factory=dict)
    reaction: str = ""
    struck: tuple[float, float] | None = None
    peaks: tuple[float, float, float] | None = None
    sampled_s: float | None = None
    tries: int = 1
    tries_right: int | None = None
    """None for a single try, of which ``problems`` say everything."""
    commit: str = ""
    """Of the program that made the row, with the day (UTC) in ``day``."""
    day: str = ""
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

    @property
    def right(self) -> int:
        """How many tries were as they should be."""
        return int(self.passed) if self.tries_right is None else self.tries_right

    @property
    def under_load(self) -> bool | None:
        """Whether the fault struck in motion and under load; None where nobody looked."""
        return None if self.struck is None else self.struck[0] >= IN_MOTION and self.struck[1] >= UNDER_LOAD

    def require(self, right: bool, sentence: str) -> None:
        """Note a problem unless it is right."""
        if not right:
            self.problems.append(sentence)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        content = {_KEYS.get(name, name): value for name, value in asdict(self).items()}
        return {**content, "passed": self.passed, "stopped_s": self.stopped_s}

    @classmethod
    def of(cls, content: Mapping[str, Any]) -> Self:
        """Read what :meth:`as_dict` wrote; raises KeyError where a value is missing."""
        values: dict[str, Any] = {entry.name: content[_KEYS.get(entry.name, entry.name)] for entry in fields(cls)}
        for name in ("rungs", "struck", "peaks"):
            values[name] = None if values[name] is None else tuple(values[name])
        return cls(**values)


def combine_tries(outcomes: Sequence[Outcome]) -> Outcome:
    """Return several tries of a row as one: right only if all are, with the longest times and the largest peaks.

    A time that one try did not see is None.
    """
    if len(outcomes) == 1:
        return outcomes[0]
    last = next((o for o in reversed(outcomes) if not o.passed), outcomes[-1])
    peaks = [o.peaks for o in outcomes if o.peaks is not None]
    return replace(
        last,
        found_s=_longest([o.found_s for o in outcomes]),
        rest_s=_longest([o.rest_s for o in outcomes]),
        off_s=_longest([o.off_s for o in outcomes]),
        struck=min((o.struck for o in outcomes if o.struck is not None), default=None),
        peaks=(max(p[0] for p in peaks), max(p[1] for p in peaks), max(p[2] for p in peaks)) if peaks else None,
        sampled_s=_longest([o.sampled_s for o in outcomes]),
        tries=len(outcomes),
        tries_right=sum(o.passed for o in outcomes),
        read_back=min(o.read_back for o in outcomes),
        problems=[f"try {n}: {problem}" for n, o in enumerate(outcomes, 1) for problem in o.problems],
    )


def _longest(values: Sequence[float | None]) -> float | None:
    seen = [value for value in values if value is not None]
    return max(seen) if len(seen) == len(values) else None
