"""Courses that orders may follow: functions of a recorded quantity, and states that are not recorded."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.mismatch.discovery import UNNAMED
from bench.mismatch.orders.revolutions import Revolution
from bench.simulation.formulas import evaluated
from bench.simulation.frame import FloatArray, Frame
from bench.simulation.quantities import OF_KIND, STATES, quantity, range_of, state_named, state_of

KINDS = ("risen", "recent_loss", "recent_speed", "recent_load", "recent_load_size", "recent_torque")
"""kinds of states that the orders are asked to follow"""
EFFECTS = {"temperature": "te.temperature_nonlinear", "speed": "te.velocity_nonlinear", "time": "te.drift_time"}
"""effects that any function of a quantity in the amplitudes is: the report's contract"""
MOVED = 1.0
"""logarithm of the factor by which a number of a course is refined at most, either way: a table's next one"""
SPACING = 0.15
"""of a range, by which the places in it that are asked are apart"""
EDGE = 0.05
"""of a range, from its ends, where a place may be: at an end a knee is a straight line"""


@dataclass(frozen=True, slots=True)
class Course:
    """A function of one quantity: its effect, the quantity or the kind of states, an expression of it (``x2``) with
    constants ``g1``, ``g2``, and their values; of a state, its scale. ``step``: how far ``g1`` is moved, where that is
    a place, 0 where it is none; ``within``: where it may be, or the scales that a state may have.
    """

    effect: str
    of: str
    text: str
    point: tuple[float, ...] = ()
    step: float = 0.0
    within: tuple[float, float] = (0.0, np.inf)

    @property
    def name(self) -> str:
        """The quantity, or the state with its scale."""
        return state_named(self.of, self.point[0]) if self.of in STATES else self.of

    @property
    def constants(self) -> tuple[tuple[str, float], ...]:
        """Symbols and values of the constants."""
        return () if self.of in STATES else tuple((f"g{k + 1}", v) for k, v in enumerate(self.point))

    def at(self, values: FloatArray) -> FloatArray:
        """The course at values of its quantity."""
        return np.asarray(evaluated(self.text, {"x2": values, **dict(self.constants)}), dtype=np.float64)

    def moved(self, logarithms: FloatArray) -> Course:
        """The same with other numbers, each times so much, a place moved by so many steps."""
        by = np.clip(logarithms, -MOVED, MOVED)
        point = np.asarray(self.point) * np.exp(by)
        if self.step:
            point[0] = self.point[0] + by[0] * self.step
        point[0] = np.clip(point[0], *self.within)
        return replace(self, point=tuple(float(v) for v in point))


class Means:
    """Courses over the revolutions: of a state its mean there, of what is recorded at the mean."""

    def __init__(self, frame: Frame, revolutions: Sequence[Revolution]) -> None:
        self.frame, self.revolutions = frame, revolutions
        self.known: dict[str, FloatArray] = {}

    def of(self, name: str) -> FloatArray:
        """Means of a quantity over the revolutions (revolutions,)."""
        if name not in self.known:
            values = quantity(name, self.frame)
            self.known[name] = np.array([values[t.rows].mean() for t in self.revolutions])
        return self.known[name]

    def __call__(self, course: Course) -> FloatArray:
        """A course (revolutions,)."""
        return course.at(self.of(course.name))


def courses_over(means: Means, banned: Sequence[str]) -> Iterator[Course]:
    """Courses that are asked: states slower than any revolution, and functions of what is recorded."""
    longest = max(t.duration for t in means.revolutions)
    for kind in KINDS:
        scales = (state[1] for name in OF_KIND[kind] if (state := state_of(name)) is not None)
        low, high = range_of(kind)
        within = (max(low, longest), high)
        yield from (Course(UNNAMED, kind, "x2", (scale,), within=within) for scale in scales if scale > longest)
    for name, shapes in _SHAPES.items():
        effect = EFFECTS.get(name, UNNAMED)
        if effect in banned:
            continue
        values = means.of(name)
        low, span = float(values.min()), float(np.ptp(values))
        for text, points in shapes:
            place = "x2 - g1" in text
            step, within = (SPACING * span if place else 0.0), (low + EDGE * span, low + (1.0 - EDGE) * span)
            within = within if place else (0.0, np.inf)
            yield from (Course(effect, name, text, point, step, within) for point in points(low, span))


def _places(low: float, span: float, widths: Sequence[float]) -> Iterator[tuple[float, ...]]:
    """Places over a range, each with some widths in parts of it."""
    for share in np.arange(0.1, 1.0, SPACING).tolist():
        yield from ((low + share * span, width * span) for width in widths)


def _knees(low: float, span: float) -> Iterator[tuple[float, ...]]:
    yield from ((low + share * span,) for share in np.arange(0.1, 1.0, SPACING).tolist())


Points = Callable[[float, float], Iterator[tuple[float, ...]]]
_TRANSITION: tuple[str, Points] = ("tanh((x2 - g1)/g2)", lambda low, span: _places(low, span, (0.05, 0.15)))
_BAND: tuple[str, Points] = ("exp(-((x2 - g1)/g2)**2)", lambda low, span: _places(low, span, (0.1, 0.25)))
_KNEE: tuple[str, Points] = ("abs(x2 - g1)", _knees)
_DECAY: tuple[str, Points] = (
    "exp(-x2/g1)",
    lambda low, span: iter([(share * (low + span),) for share in (0.1, 0.25, 0.6)]),
)
_ONSET: tuple[str, Points] = (
    "exp(-0.5*(x2 - g1 + abs(x2 - g1))/g2)",
    lambda low, span: _places(low, span, (0.03, 0.1, 0.3)),
)
"""nothing until a moment, then settling: something loosens, and beds in"""
_SHAPES: Mapping[str, Sequence[tuple[str, Points]]] = {
    "temperature": (_TRANSITION, _BAND, _KNEE),
    "speed": (_DECAY, _BAND, _KNEE),
    "time": (("x2", lambda low, span: iter([()])), _TRANSITION, _KNEE, _ONSET),
    "torque": (_TRANSITION, _BAND, _KNEE),
}
"""expressions of what is recorded, with the points of each that are asked, by lowest value and range"""
