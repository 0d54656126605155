"""Findings: what was discovered in the channels, one finding an effect, with its figures."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from bench.mismatch import criteria
from bench.mismatch.discovery import AMBIGUOUS, NAMED, UNKNOWN, UNNAMED, ChannelOutcome, Discovery, RefittedAlternative
from bench.mismatch.equations import together
from bench.mismatch.recordings.dataset import Dataset
from bench.mismatch.regression.sensitivity import PARAMETER
from bench.mismatch.report import figures
from bench.mismatch.report.location import Location, location_of
from bench.mismatch.report.mirrored import mirrored
from bench.mismatch.report.shared_tone import shared_tones
from bench.mismatch.report.words import text
from bench.simulation.composed import parts_of
from bench.simulation.frame import FloatArray
from bench.simulation.quantities import AUXILIARY
from bench.simulation.terms import LIBRARY, LOAD_TORQUE, MOTOR_TORQUE

LEAST_WEIGHT = 0.001
"""smallest probability that two thousand draws of the points left out can tell"""
UNKNOWN_NAME = "structure that no term of the library explains"


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another explanation, refitted in the finding's place; ``rmse`` None where it was not evaluated on rows."""

    effect: str
    name: str
    rmse: float | None
    why_not: str
    as_good: bool


@dataclass(frozen=True, slots=True)
class NextExperiment:
    """Points to run next: why, the campaign file's name, the points as the report has them."""

    why: str
    file: str
    points: tuple[Mapping[str, Any], ...]


@dataclass(frozen=True, slots=True)
class Finding:
    """One finding of the report. Root mean squares are per sample, of held-out recordings (``held_out``) or, where none
    could be held out, of those fitted; None where they could not be computed.
    """

    discovery: Discovery
    """where it is strongest"""
    outcome: ChannelOutcome = field(repr=False)
    also_in: tuple[str, ...]
    location: Location
    text: str
    held_out: bool
    against: bool
    """whether recordings held out speak against it"""
    before: float | None
    after: float | None
    share_of_excess: float | None
    alternatives: tuple[Alternative, ...]
    next_experiment: NextExperiment | None = None

    @property
    def effect(self) -> str:
        """Id of the vocabulary, or ``unknown``."""
        return self.discovery.effect

    @property
    def name(self) -> str:
        """The effect in words."""
        if self.effect == PARAMETER:
            return f"wrong parameter {_symbol(self.discovery)}"
        beside = _auxiliary(self.discovery)
        return f"something that depends on {' and '.join(beside)}" if beside else name_of(self.effect)

    @property
    def status(self) -> str:
        """Named, ambiguous or unknown."""
        return self.discovery.status

    @property
    def channel(self) -> str:
        """Channel in which it is strongest."""
        return self.discovery.channel

    @property
    def open(self) -> bool:
        """Whether an experiment is to be proposed."""
        return self.status in (AMBIGUOUS, UNKNOWN)


def name_of(effect: str) -> str:
    """An effect in words."""
    if effect == UNNAMED:
        return UNKNOWN_NAME
    return LIBRARY[effect].name if effect in LIBRARY else effect


def conclude(outcomes: Sequence[ChannelOutcome], data: Dataset) -> tuple[Finding, ...]:
    """Findings of all channels, strongest first: by the energy of what they add, over the channel's noise floor.

    An effect that shows in several channels is one finding, reported where it is strongest. What has no name is one
    finding a channel: nothing says what of it belongs together, but for a load misread, which comes back in the motor
    torque, a tone that several channels have, and what an effect named in another channel explains as well. What
    depends on an auxiliary quantity is one by itself.
    """
    misread = mirrored(outcomes, data.ratio)
    tones = shared_tones(outcomes)
    groups: dict[object, list[tuple[float, Discovery, ChannelOutcome]]] = {}
    for outcome in outcomes:
        for found in _merged(outcome.discoveries):
            key: object = (found.effect, _symbol(found))
            if found.effect == UNNAMED:
                channel = LOAD_TORQUE if misread and outcome.channel == MOTOR_TORQUE else outcome.channel
                named = _named_elsewhere(found, outcomes)
                key = (named, "") if named else (tones.get(channel, channel), _auxiliary(found))
            groups.setdefault(key, []).append((figures.strength(found, outcome), found, outcome))
    # what has a name in one of its channels is told by that
    sorted_groups = [sorted(group, key=lambda one: (one[1].effect == UNNAMED, -one[0])) for group in groups.values()]
    sorted_groups.sort(key=lambda group: -group[0][0])
    return tuple(_finding([one[1] for one in group], group[0][2], data) for group in sorted_groups)


def _named_elsewhere(found: Discovery, outcomes: Sequence[ChannelOutcome]) -> str | None:
    """An effect that explains something without a name as well, and that has been found in another channel."""
    others = {d.effect for o in outcomes if o.channel != found.channel for d in o.discoveries if d.status == NAMED}
    return _as_good_among(found, others)


def _as_good_among(found: Discovery, effects: Collection[str]) -> str | None:
    """The first of its alternatives that is as good as a discovery and one of some effects."""
    return next((a.effect for a in found.alternatives if a.as_good and a.effect in effects), None)


def _symbol(found: Discovery) -> str:
    """The parameter of the simulation that was wrong; each is a finding by itself."""
    return str(found.parameters[0]["symbol"]) if found.effect == PARAMETER else ""


def _auxiliary(found: Discovery) -> tuple[str, ...]:
    """Auxiliary quantities that something without a name is a function of; none where it has a name."""
    return _auxiliaries(found.variables if found.effect == UNNAMED else ())


def made_of(finding: Finding) -> tuple[str, ...]:
    """Auxiliary quantities that a finding depends on, alone or composed."""
    return _auxiliaries(finding.discovery.variables)


def _auxiliaries(variables: Sequence[str]) -> tuple[str, ...]:
    parts = [p for name in variables if name.startswith(AUXILIARY) for p in parts_of(name.removeprefix(AUXILIARY))]
    return tuple(dict.fromkeys(AUXILIARY + part for part in parts))


def _finding(found: Sequence[Discovery], outcome: ChannelOutcome, data: Dataset) -> Finding:
    scored, without = figures.Scored.of(outcome), figures.without(found[0], outcome)
    against = figures.against(found[0], outcome)
    first = with_earned_confidence(found[0], against)
    also = dict.fromkeys(c for d in found for c in (d.channel, *d.also_in) if c != first.channel)
    where = location_of(first, outcome, data)
    return Finding(
        first,
        outcome,
        tuple(also),
        where,
        text(where, data.linear),
        scored.held_out,
        against,
        without,
        scored.after,
        figures.share_of_excess(first, outcome),
        # those that are as good first, then by what they lose
        tuple(_alternative(r, outcome) for r in sorted(first.alternatives, key=lambda r: (not r.as_good, r.loss))),
    )


def with_earned_confidence(found: Discovery, against: bool = False) -> Discovery:
    """A discovery with the confidence that findings of its weight have earned; half of it where the recordings held
    out are ``against`` it.
    """
    if found.confidence is None:
        return found
    return replace(
        found, confidence=criteria.RIGHT_WHEN_SURE * found.confidence * (criteria.EITHER if against else 1.0)
    )


def _alternative(other: RefittedAlternative, outcome: ChannelOutcome) -> Alternative:
    return Alternative(
        other.effect, other.words, figures.with_alternative(other, outcome), _why_not(other), other.as_good
    )


def _why_not(other: RefittedAlternative) -> str:
    """What speaks against another explanation, from its own figures."""
    if not np.isfinite(other.loss):
        return "the recordings cannot tell the two apart: nothing in them differs between these"
    error = f" ± {other.error:.1f}" if np.isfinite(other.error) else ""
    more = "less" if other.loss >= 0 else "more"
    much = f"{abs(other.loss):.1f}{error} {more}"
    text = f"refitted in its place it gives points left out {much} log density"
    if other.of_fitted:
        text = f"refitted in its place it has {much} log-likelihood, its numbers paid for"
    elif np.isfinite(other.weight):
        sure = f"below {LEAST_WEIGHT:g}" if other.weight < LEAST_WEIGHT else f"{other.weight:.2g}"
        text += f"; probability {sure} that it predicts best, its numbers counted"
    if other.worse_by > 1.0:
        text += f"; it leaves {other.worse_by:.2g} times the squares at these points"
    return text + ("; the recordings cannot tell the two apart" if other.as_good else "")


def _effect_beside(discovery: Discovery, sure: Collection[str]) -> str:
    """The effect of a discovery; where it is ambiguous, that of its alternatives which is as good and ``sure`` beside
    it, if there is one and its own is not.
    """
    if discovery.status != AMBIGUOUS or discovery.effect in sure:
        return discovery.effect
    return _as_good_among(discovery, sure) or discovery.effect


def _together(excesses: Sequence[FloatArray | None]) -> FloatArray | None:
    known = [excess for excess in excesses if excess is not None]
    return np.asarray(np.sum(known, axis=0)) if known and len(known) == len(excesses) else None


def _excess(group: Sequence[Discovery]) -> FloatArray | None:
    """What counts of several discoveries together; None where it is what they add."""
    return None if all(d.excess is None for d in group) else np.asarray(np.sum([d.beyond for d in group], axis=0))


def _merged(discoveries: Iterable[Discovery]) -> list[Discovery]:
    """Discoveries of a channel, those of one effect as one: what they add is the sum, equations and parameters of all
    stand together. The strongest gives the rest, of those that have a name for sure if there are such: where the offset
    says which effect it is, an amplitude that cannot tell it from another follows the same.
    """
    found = list(discoveries)
    sure = {d.effect for d in found if d.status == NAMED}
    groups: dict[object, list[Discovery]] = {}
    for discovery in found:
        key = (_effect_beside(discovery, sure), _symbol(discovery), _auxiliary(discovery))
        groups.setdefault(key, []).append(discovery)
    out = []
    for group in groups.values():
        first = max(group, key=lambda d: (d.status == NAMED, d.gain))
        if len(group) == 1:
            out.append(first)
            continue
        # the strongest keeps its symbols
        ordered = [first, *(d for d in group if d is not first)]
        equation, parameters = together([(d.equation, d.parameters) for d in ordered])
        squares = [d.squares for d in group if d.squares is not None]
        more = sum(a - b for a, b in squares)
        out.append(
            replace(
                first,
                equation=equation,
                parameters=parameters,
                added=np.sum([d.added for d in group], axis=0),
                excess=_excess(group),
                everywhere=_together([d.everywhere for d in group]),
                simulation_rows=tuple(r for d in group for r in d.simulation_rows),
                orders=tuple(dict.fromkeys(f for d in group for f in d.orders)),
                angle_windows=tuple(w for d in group for w in d.angle_windows),
                table=tuple(row for d in group for row in d.table),
                numbers=sum(d.numbers for d in group),
                squares=(squares[0][1] + more, squares[0][1]) if len(squares) == len(group) else None,
            )
        )
    return out


__all__ = ["Alternative", "Finding", "NextExperiment", "conclude", "name_of"]
