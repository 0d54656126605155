"""The next experiment: the points that are expected to tell most about alternative explanations per hour of bench time.

The gain of points is that of :mod:`bench.mismatch.report.separating`: expected log-likelihood against a wrong
explanation that is refitted to all recordings and the new points together, the least over all pairs of a question, both
ways; of each point few rows count. It counts up to ``ENOUGH`` a question; questions add up. The cost is the plan's:
points, warming up or cooling down before, and what any experiment costs beside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from bench.configuration import BenchConfiguration
from bench.errors import LimitError
from bench.investigate.offer import Offered, State, enlarged_range, offered_points, plan_points, states
from bench.investigate.questions import Question
from bench.mismatch.report.candidates import Candidate, Range, candidates, frame_of
from bench.mismatch.report.rules import by_rule
from bench.mismatch.report.separating import ENOUGH, Look, Measured, both_ways, fitted_to
from bench.mismatch.report.truth import Truth, is_regressor, truth_of
from bench.simulation.terms import TEMPERATURE

LEAST_POINTS, MOST_POINTS = 4, 6
"""several points: one more operating point by itself says little of how sure it is"""
ROWS = 12
"""rows of a point that count, each with the noise of one sample: the rest of a recording repeats its errors, those of a
form that is not quite nature's among them"""
LEAST_GAIN = 3.0
"""expected gain below which an experiment is not worth the run: odds of twenty to one"""
BESIDE_S = 1800.0
"""time an experiment costs beside its own: tare, analysis, a person who comes and says yes"""
SECONDS_AN_HOUR = 3600.0


@dataclass(frozen=True, slots=True)
class Experiment:
    """What to run, in order; ``gains``: expected, by question, None where only a rule of the field speaks for it."""

    points: tuple[Candidate, ...]
    hours: float
    gains: tuple[tuple[Question, float | None], ...]
    why: str
    state: str

    @property
    def expected(self) -> float:
        """Expected gain of all questions together; 0 where none could be computed."""
        return sum(gain for _, gain in self.gains if gain is not None)


class Design:
    """The questions of one analysis of the recordings, ready to rate points."""

    def __init__(self, questions: Sequence[Question], ratio: float) -> None:
        self._ratio = ratio
        self._parts: list[tuple[Question, Measured, Truth]] = []
        for question in questions:
            # the temperature is an integral over the campaign: no rows of a point by themselves predict it
            if not question.alternatives or question.finding.channel == TEMPERATURE:
                continue
            measured = Measured.of(question.finding, question.finding.effect)
            truth = truth_of(question.finding.discovery) or nearest(question, measured)
            if truth is not None:
                # what a row leaves is less than what a form that is not quite nature's leaves of a point
                wide = replace(measured, variance=max(measured.variance, question.finding.outcome.floor**2))
                self._parts.append((question, wide, truth))

    def looks(self, points: Sequence[Offered]) -> list[tuple[Question, list[Look]]]:
        """For each question the pairs of explanations, with what they predict at the points."""
        frames = [frame_of(o.point, o.state.covered, self._ratio) for o in points]
        out = []
        for question, measured, truth in self._parts:
            looks = [
                look for effect in question.alternatives for look in both_ways(measured, truth, effect, frames, ROWS)
            ]
            if looks:
                out.append((question, looks))
        return out


def nearest(question: Question, measured: Measured) -> Truth | None:
    """The form of a finding's effect that comes nearest to what was found, where it stands as a table of numbers."""
    found = question.finding
    if not is_regressor(found.effect, found.channel):
        return None
    fit = fitted_to(measured, found.effect, found.discovery.added[:: int(measured.each)])
    return None if fit is None else Truth(fit.term, fit.term_coefficients())


def best(
    questions: Sequence[Question],
    covered: Range,
    ratio: float,
    bench: BenchConfiguration,
    celsius: float,
    most_h: float,
) -> tuple[Experiment | None, list[str]]:
    """The experiment of the largest expected gain an hour that takes at most ``most_h``; and what the bench refused.

    None where no experiment is expected to separate anything.
    """
    design = Design(questions, ratio)
    found: list[Experiment] = []
    refused: list[str] = []
    for state in states(covered, bench, celsius):
        points, why = offered_points(state, bench)
        refused += why
        candidate = _in_state(design, state, points, bench, celsius)
        if candidate is not None and candidate.hours <= most_h:
            found.append(candidate)
    chosen = max(found, key=lambda e: e.expected / (e.hours + BESIDE_S / SECONDS_AN_HOUR), default=None)
    return chosen, list(dict.fromkeys(refused))


def _in_state(
    design: Design, state: State, points: Sequence[Offered], bench: BenchConfiguration, celsius: float
) -> Experiment | None:
    """The best points in a state, added one by one; None where the bench refuses all, or none separates anything."""
    looks = design.looks(points) if points else []
    if not looks:
        return None
    prepared = () if state.before is None else (state.before,)
    before_s = plan_points("before", prepared, bench, celsius).duration_s if prepared else 0.0

    def gains(chosen: Sequence[int]) -> list[tuple[Question, float]]:
        return [
            (question, min(min(look.gain(chosen) for look in pair_looks), ENOUGH)) for question, pair_looks in looks
        ]

    def rate(chosen: Sequence[int]) -> float:
        seconds = BESIDE_S + before_s + sum(points[k].takes_s for k in chosen)
        return sum(gain for _, gain in gains(chosen)) / seconds

    chosen: list[int] = []
    while len(chosen) < min(MOST_POINTS, len(points)):
        left = [k for k in range(len(points)) if k not in chosen]
        following = max(left, key=lambda k: rate([*chosen, k]))
        if len(chosen) >= LEAST_POINTS and rate([*chosen, following]) <= rate(chosen):
            break
        chosen.append(following)
    expected = gains(chosen)
    if sum(gain for _, gain in expected) < LEAST_GAIN:
        return None
    listed = (*prepared, *(points[k].point for k in chosen))
    hours = plan_points("whole", listed, bench, celsius).duration_s / SECONDS_AN_HOUR
    return Experiment(listed, hours, tuple(expected), "largest expected information an hour of bench time", state.name)


def by_rules(
    questions: Sequence[Question],
    covered: Range,
    bench: BenchConfiguration,
    celsius: float,
    most_h: float,
    done: set[tuple[str, ...]],
) -> Experiment | None:
    """An experiment of the field for the first question that has one which was not run for it (``done``)."""
    for question in questions:
        proposal = by_rule(question.finding, replace(covered, coldest=min(covered.coldest, celsius)))
        if proposal is None or (*question.key, proposal.why) in done:
            continue
        try:
            hours = plan_points("rule", proposal.points, bench, celsius).duration_s / SECONDS_AN_HOUR
        except LimitError:
            continue
        if hours <= most_h:
            return Experiment(proposal.points, hours, ((question, None),), proposal.why, "by rule")
    return None


def bench_needs(
    questions: Sequence[Question], covered: Range, ratio: float, bench: BenchConfiguration, celsius: float
) -> list[str]:
    """What the bench would need: why it refuses points, twice as far out, that would separate explanations."""
    design = Design(questions, ratio)
    refusals: dict[str, float] = {}
    state = next(iter(states(enlarged_range(covered), bench, celsius)))
    every = [Offered(state, point, 0.0) for point in candidates(replace(state.covered, heats=False))]
    looks = design.looks(every)
    for k, one in enumerate(every):
        gain = sum(min(min(look.gain([k]) for look in pair_looks), ENOUGH) for _, pair_looks in looks)
        if gain < LEAST_GAIN:
            continue
        try:
            plan_points("beyond", (one.point,), bench, celsius)
        except LimitError as error:
            words = str(error).split(" needs ", 1)[-1]
            refusals[words] = max(refusals.get(words, 0.0), gain)
    return [f"{words}: expected gain {gain:.0f}" for words, gain in sorted(refusals.items(), key=lambda p: -p[1])[:3]]
