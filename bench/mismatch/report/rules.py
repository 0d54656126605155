"""Experiments of the field, by what a finding is and depends on, where no two regressors stand against each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from bench.mismatch.report.candidates import Candidate, Range, reversals, stairs
from bench.mismatch.report.finding import Finding
from bench.mismatch.report.variables import TORQUE, VELOCITY
from bench.simulation.quantities import AUXILIARY
from bench.simulation.terms import TEMPERATURE as TEMPERATURE_CHANNEL

TEN_DEGREES = float(np.radians(10.0))
COOLER = 6.0
"""K above the coldest to which it is cooled: that takes no longer than it must"""
_PATH = ("te.lost_motion", "te.hysteresis", "te.stiffness_nonlinear", "sensor.torque_hysteresis")
_REST = (("duration", '"60 s"'),)


@dataclass(frozen=True, slots=True)
class Proposal:
    """Points to run in this order, and why."""

    why: str
    points: tuple[Candidate, ...]


@dataclass(frozen=True, slots=True)
class Rule:
    """Findings it is for, the points, and why these."""

    serves: Callable[[Finding], bool]
    points: Callable[[Range], Iterator[Candidate]]
    why: str


def by_rule(finding: Finding, covered: Range) -> Proposal | None:
    """The first rule that serves a finding and has points that this bench can run."""
    for rule in RULES:
        points = tuple(rule.points(covered)) if rule.serves(finding) else ()
        if points:
            return Proposal(rule.why, points)
    return None


def _names(finding: Finding) -> set[str]:
    return {finding.effect, *(a.effect for a in finding.alternatives if a.as_good)}


def _thermal(finding: Finding) -> bool:
    return finding.channel == TEMPERATURE_CHANNEL or any(name.startswith("thermal.") for name in _names(finding))


def _by_path(finding: Finding) -> bool:
    return bool(_names(finding) & set(_PATH)) or TORQUE in finding.location.depends


def _by_speed(finding: Finding) -> bool:
    return VELOCITY in finding.location.depends or bool(finding.discovery.orders)


def _by_auxiliary(finding: Finding) -> bool:
    return any(name.startswith(AUXILIARY) for name in finding.discovery.variables)


def _any(_: Finding) -> bool:
    return True


def _warm_and_rest(covered: Range) -> Iterator[Candidate]:
    if covered.warm is not None:
        yield Candidate("heating", 0.0, 0.0, covered.warm)
        yield Candidate("dwell", 0.0, 0.0, None, _REST)
        yield Candidate("cooling", 0.0, 0.0, float(round(covered.coldest + COOLER)))
        yield Candidate("heating", 0.0, 0.0, covered.warm)


def _run_and_rest(covered: Range) -> Iterator[Candidate]:
    fast = covered.fastest * covered.sides[0]
    for torque in covered.loads((1.0, 0.0, -1.0)):
        yield Candidate("constant_velocity", torque, fast)
        yield Candidate("dwell", 0.0, 0.0, None, _REST)


def _stairs_and_reversals(covered: Range) -> Iterator[Candidate]:
    yield from stairs(covered)
    yield from reversals(covered, TEN_DEGREES, covered.loads((0.0, 0.5)))


def _speeds(covered: Range) -> Iterator[Candidate]:
    for share in (0.1, 0.2, 0.5, 1.0):
        for side in covered.sides:
            yield Candidate("constant_velocity", 0.0, side * share * covered.fastest)


def _cold_warm_cold(covered: Range) -> Iterator[Candidate]:
    if covered.warm is None:
        return
    speed = 0.5 * covered.fastest * covered.sides[0]
    loads = covered.loads((0.0, 0.5))
    for temperature in (None, covered.warm):
        for torque in loads:
            yield Candidate("constant_velocity", torque, speed, temperature)
    yield Candidate("cooling", 0.0, 0.0, float(round(covered.coldest + COOLER)))
    for torque in loads:
        yield Candidate("constant_velocity", torque, speed)


def _again(covered: Range) -> Iterator[Candidate]:
    speed = 0.5 * covered.fastest * covered.sides[0]
    for number in range(2):
        for torque in covered.loads((0.0, 0.5, 1.0)):
            yield Candidate("constant_velocity", torque, speed)
        if number == 0:
            yield Candidate("dwell", 0.0, 0.0, None, _REST)


RULES = (
    Rule(
        _thermal,
        _warm_and_rest,
        "warm up, rest, cool down and warm up again: sensor, housing and surroundings answer at different times",
    ),
    Rule(_thermal, _run_and_rest, "run under load and rest in turn: heat goes in and out at known times"),
    Rule(
        _by_path,
        _stairs_and_reversals,
        "a torque staircase up and down, reversals under preload: path dependence shows, a function of torque not",
    ),
    Rule(
        _by_speed,
        _speeds,
        "slow and fast points close together, both ways where the bench turns both ways: the laws of speed part, "
        "resonances stand at f·speed",
    ),
    Rule(
        _by_auxiliary,
        _again,
        "the same points twice: change the auxiliary quantity in the rest between, and nothing else",
    ),
    Rule(
        _any,
        _cold_warm_cold,
        "the same points cold, warm, and cold again after a cooling: time goes on, the temperature comes back",
    ),
    Rule(_any, _again, "the same points twice, a rest between: what comes back is no course of time"),
)
