"""What a bench can do next: points as they are found, after a warm-up, or after a cooling."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from bench.campaigns.planning.file import parse_campaign
from bench.campaigns.planning.plan import Plan, make_plan
from bench.configuration import BenchConfiguration
from bench.errors import LimitError
from bench.mismatch.report.candidates import Candidate, Range, candidates
from bench.mismatch.report.experiment import campaign
from bench.simulation.frame import Frame

WARMER, COOLER = 12.0, 6.0
"""K above the lubricant as it is that a warm-up goes at least; K above the surroundings that a cooling ends"""
LEAST_CHANGE = 4.0
"""K by which warming or cooling has to change something"""
SLOWER = 0.4
"""share of the largest speed below which only one speed was run"""
CLEAR_OF_LIMIT = 0.8
"""share of the bench's limit of torque or speed that an experiment goes to where the recordings did not"""
MORE_SPEED = 1.5
BEYOND = 2.0
"""how far beyond the bench it is looked, to say what it would need"""


@dataclass(frozen=True, slots=True)
class State:
    """State of the lubricant when the points begin.

    ``before`` brings it there (None: nothing has to be done); ``celsius`` is its temperature in °C; ``covered`` is the
    range of conditions for the rows of a candidate.
    """

    name: str
    before: Candidate | None
    celsius: float
    covered: Range


@dataclass(frozen=True, slots=True)
class Offered:
    """A point in a state, with the bench time it takes in s."""

    state: State
    point: Candidate
    takes_s: float


def extended_range(covered: Range, bench: BenchConfiguration) -> Range:
    """What experiments may cover: both ways and both signs of the torque, where only one was run; a second speed."""
    limits = bench.limits
    torque = min(covered.torque, CLEAR_OF_LIMIT * limits.load_torque) or CLEAR_OF_LIMIT * limits.load_torque
    fastest = covered.fastest
    if covered.slowest > SLOWER * fastest:
        fastest = max(fastest, min(MORE_SPEED * fastest, CLEAR_OF_LIMIT * limits.motor_speed / bench.gearbox.ratio))
    return replace(
        covered, torque=float(round(torque)), fastest=fastest, heats=True, sides=(1.0, -1.0), torque_sides=(1.0, -1.0)
    )


def last_celsius(frames: Sequence[Frame]) -> float:
    """Temperature of the lubricant at the end of the recordings."""
    frame = max(frames, key=lambda frame: float(frame.time.max()))
    return float(frame.temperature[int(frame.time.argmax())])


def states(covered: Range, bench: BenchConfiguration, celsius: float) -> Iterator[State]:
    """The lubricant as it is, at ``celsius``; warmer, as the limits allow; cooled down."""
    here = replace(covered, coldest=celsius, warmest=max(covered.warmest, celsius))
    yield State("as found", None, celsius, here)
    warm = float(round(max(covered.warmest, celsius + WARMER)))
    warm = min(warm, float(int(bench.limits.temperature - 2.0 * bench.heating.hysteresis)))
    cold = float(round(bench.nominal.ambient_temperature + COOLER))
    for name, sequence, aim in (("warmed up", "heating", warm), ("cooled down", "cooling", cold)):
        change = aim - celsius if sequence == "heating" else celsius - aim
        if change < LEAST_CHANGE:
            continue
        before = Candidate(sequence, 0.0, 0.0, aim)
        try:
            took = plan_points("before", (before,), bench, celsius).duration_s
        except LimitError:
            continue
        way = took * bench.heating.motor_speed / bench.gearbox.ratio if sequence == "heating" else 0.0
        after = replace(here, coldest=aim, end=covered.end + took, travel=covered.travel + way)
        yield State(name, before, aim, after)


def offered_points(state: State, bench: BenchConfiguration) -> tuple[list[Offered], list[str]]:
    """Points that the bench can run in a state, each planned; sentences of those that it refuses."""
    out: list[Offered] = []
    refused: list[str] = []
    for point in candidates(replace(state.covered, heats=False)):
        try:
            plan = plan_points("one", (point,), bench, state.celsius)
        except LimitError as error:
            refused.append(str(error))
            continue
        out.append(Offered(state, point, sum(t.duration_s for t in plan.tasks if not t.is_preparation)))
    return out, refused


def plan_points(title: str, points: Sequence[Candidate], bench: BenchConfiguration, celsius: float) -> Plan:
    """The plan of points, as ``bench plan`` makes it. Raises LimitError where the bench cannot do them."""
    return make_plan(parse_campaign(campaign(title, 1, points), title), bench, celsius)


def enlarged_range(covered: Range) -> Range:
    """A bench that could do more in torque and speed, to find what it would need."""
    return replace(covered, torque=BEYOND * covered.torque, fastest=BEYOND * covered.fastest)


def write_campaign(path: Path, title: str, number: int, points: Sequence[Candidate]) -> Path:
    """Write the campaign of an experiment."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(campaign(title, number, points), encoding="utf-8")
    return path
