"""Judging what a search has chosen: other names that say as much, rivals that say more, and what no name explains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bench.mismatch.bank import Fit
from bench.mismatch.columns import Entry
from bench.mismatch.refine import Refiner
from bench.mismatch.select import ECHO_SHARE, MINIMUM_T, Search, spread_t
from bench.simulation.frame import FloatArray
from bench.simulation.terms import TRANSMISSION_ERROR

UNKNOWN_SHARE = 0.08
"""a rival must beat named terms by this share of their gain before the names are doubted"""
UNKNOWN_GAIN = 40.0
REFINED_ALTERNATIVES = 4
COMPANION = 0.05
"""of a free function's gain: what a name has to gain beside it"""
ECHO_LOSS = 0.2
"""of a term's gain: what another effect may lose in its place and still be taken for its echo"""
NESTED = 2e-3
"""share of an entry's energy that another may leave over and still contain it"""
PREFERRED_NESTED = 0.05
OCCAM = 7.0
"""log-likelihood a chosen term must gain over a special case of it that goes by another name"""


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another effect in a chosen one's place: what it costs in log-likelihood, and the standard error of that."""

    entry: Entry
    loss: float
    error: float
    contains: bool
    """the alternative has the chosen term's regressors among its own: no rival, only a longer way to say it"""
    strained: bool = field(default=False, kw_only=True)
    """the alternative stands at the end of its parameters' range, where it turns into something else"""


@dataclass(slots=True)
class Found:
    """A term or rival chosen in a channel. ``gain`` is what the final model loses without it."""

    entry: Entry
    gain: float
    coefficients: FloatArray
    covariance: FloatArray
    alternatives: list[Alternative] = field(default_factory=list)


@dataclass(slots=True)
class Verdict:
    """What stands after judging: entries chosen, free-form corrections of their shape, and the findings."""

    chosen: list[Entry]
    correction: list[Entry] = field(default_factory=list)
    found: list[Found] = field(default_factory=list)


def judge(
    search: Search,
    refiner: Refiner,
    chosen: list[Entry],
    free: Sequence[Entry],
    channel: str,
    known: Sequence[Sequence[str]] = (),
) -> Verdict:
    """Alternatives of each chosen term, rivals that beat it, and rivals that find what no term explains.

    ``known`` holds the variables of each further term that the given simulation has.
    """
    start = search.fit(()).total
    plain = _without_echoes(search, refiner, _supported(search, _doubted(search, chosen, free)))
    out = Verdict(search.pruned(_simplest(search, refiner, plain)))
    named = [e for e in out.chosen if e.effect != "unknown"]
    whole = search.fit(out.chosen)
    for entry in out.chosen:
        # a free function beside a term of the nominal simulation may hold that term in itself: it is judged without
        beside = named if entry.effect in search.preferred else out.chosen
        own = search.fit(beside)
        others = [e for e in beside if e != entry]
        gain = own.total - search.fit(others).total
        found = Found(entry, gain, np.zeros(0), np.zeros((0, 0)))
        if entry.effect != "unknown":
            found.alternatives = _alternatives(search, refiner, others, entry, own)
        out.found.append(found)
    rival, gain = search.best(out.chosen, free)
    if rival is not None:
        after = search.fit([*out.chosen, rival])
        shaped = [f.entry.variables for f in out.found] + list(known)
        # a function of several quantities is no other form of an effect of one
        related = [own for own in shaped if quantities(rival.variables) <= quantities(own)]
        strongest = max((f.gain for f in out.found), default=search.credit)
        least = UNKNOWN_GAIN * (2.5 if channel == TRANSMISSION_ERROR else 1.0)
        price = max(least * _long_memory(search), 0.02 * (whole.total - start + search.credit))
        if related and gain > 10.0:
            out.correction.append(rival)  # nature's form differs a little from ours: the same effect
        elif gain > price and spread_t(after.likelihood - whole.likelihood) > 1.8 and gain > 0.05 * strongest:
            out.found.append(Found(rival, gain, np.zeros(0), np.zeros((0, 0))))
            out.chosen = _supported(search, [*out.chosen, rival])
            out.found = [f for f in out.found if f.entry in out.chosen]
    return out


def _long_memory(search: Search) -> float:
    """How much more a free function has to gain where noise remembers itself for many rows: 1 for ordinary noise.

    The noise of a torque sensor that wanders as slowly is in the regressors as well, and no likelihood knows of that.
    """
    rho = float(np.median(search.bank.noise.correlation))
    return max(1.0, 0.5 * (1.0 + rho) / (1.0 - rho))


def _doubted(search: Search, chosen: list[Entry], free: Sequence[Entry]) -> list[Entry]:
    """Named terms given up together for one free function of the same quantities that explains clearly more, or two and
    more of them for one of another quantity that says it alone.
    """
    whole = search.fit(chosen)
    best: tuple[float, list[Entry]] | None = None
    for rival in free:
        own = [
            e
            for e in chosen
            if quantities(e.variables) & quantities(rival.variables) and e.effect not in search.preferred
        ]
        strange = not own
        if strange:
            own = [e for e in chosen if e.effect not in search.preferred]
        rest = [e for e in chosen if e not in own]
        if not own or (strange and len(own) < 2):
            continue
        fit = search.fit([*rest, rival])
        gain = whole.total - search.fit(rest).total
        margin = fit.total - whole.total
        clear = margin > 10.0 + UNKNOWN_SHARE * gain and spread_t(fit.likelihood - whole.likelihood) > 1.5
        clear = clear or (strange and margin > 10.0)
        if clear and (best is None or fit.total > best[0]):
            best = fit.total, [*rest, rival]
    return chosen if best is None else best[1]


def _supported(search: Search, chosen: list[Entry]) -> list[Entry]:
    """Entries without the names that, beside a free function, only mend it: in a few recordings, or by a small share.

    Where nature has no form of ours, any name that is left beside it has to stand in most of the recordings it touches.
    """
    free = [e for e in chosen if e.effect == "unknown"]
    current = list(chosen)
    if not free:
        return current
    main = search.fit(current).total - search.fit([e for e in current if e not in free]).total
    for entry in chosen:
        if entry in free or entry.effect in search.preferred:
            continue
        gain = search.fit(current).likelihood - search.fit([e for e in current if e != entry]).likelihood
        if spread_t(gain) < MINIMUM_T or gain.sum() < COMPANION * main:
            current.remove(entry)
    return current


def _without_echoes(search: Search, refiner: Refiner, chosen: list[Entry]) -> list[Entry]:
    """Terms without those that gain little beside another which their own effect could have stood for.

    Where two effects can hardly be told apart, the second one only mends the form of the first.
    """
    current = list(chosen)
    for weak in chosen:
        for strong in chosen:
            if weak not in current or strong not in current or weak.effect == strong.effect:
                continue
            others = [e for e in current if e not in (weak, strong)]
            alone = search.fit([*others, strong]).total
            gain = alone - search.fit(others).total
            if "unknown" in (weak.effect, strong.effect) or search.fit(current).total - alone > ECHO_SHARE * gain:
                continue
            rival = refiner.effect(others, weak.effect)
            if rival is not None and alone - search.fit([*others, rival]).total < ECHO_LOSS * gain:
                current.remove(weak)
                again = refiner.effect(others, strong.effect) or strong
                current[current.index(strong)] = again
    return current


def _simplest(search: Search, refiner: Refiner, chosen: list[Entry]) -> list[Entry]:
    """Terms with those replaced that another effect's says as well with fewer parameters, as a special case."""
    for place, entry in enumerate(chosen):
        if entry.effect in search.preferred:
            continue  # a term of the nominal simulation is the likelier name, many as its parameters may be
        others = chosen[:place] + chosen[place + 1 :]
        taken = {e.effect for e in chosen}
        plain = [e for e in search.entries if e.effect not in taken and e.numbers < entry.numbers]
        best, _ = search.best(others, plain)
        if best is not None and search.fit([*others, best]).total > search.fit(chosen).total - 10.0 * OCCAM:
            best = refiner.effect(others, best.effect) or best
            loss = search.fit(chosen).total - search.fit([*others, best]).total
            if loss < OCCAM and best.numbers < entry.numbers and nested(search, best, entry):
                chosen[place] = best
    return chosen


def _alternatives(search: Search, refiner: Refiner, others: list[Entry], entry: Entry, whole: Fit) -> list[Alternative]:
    """The effects that come nearest in a chosen term's place, each refitted and refined there."""
    totals: dict[str, float] = {}
    taken = {e.effect for e in others}
    for candidate in search.entries:
        if candidate.effect != entry.effect and candidate.effect not in taken:
            total = search.fit([*others, candidate]).total
            totals[candidate.effect] = max(total, totals.get(candidate.effect, -np.inf))
    out: list[Alternative] = []
    for effect in sorted(totals, key=lambda e: -totals[e])[:REFINED_ALTERNATIVES]:
        longer: set[str] = set()
        first: Alternative | None = None
        while (rival := refiner.effect(others, effect, longer)) is not None:
            difference = whole.likelihood - search.fit([*others, rival]).likelihood
            error = float(np.std(difference, ddof=1) * np.sqrt(difference.size)) if difference.size > 1 else 0.0
            # a term of the nominal simulation is not doubted for a curve that comes near it
            special = NESTED if entry.effect not in search.preferred or not rival.point else PREFERRED_NESTED
            # an order is one of a few numbers, no parameter that bends a curve towards another
            numbers = len(rival.index) if effect in search.repeated else rival.numbers
            contains = numbers > entry.numbers and nested(search, entry, rival, special)
            found = Alternative(rival, float(difference.sum()), error, contains, strained=refiner.strained(rival))
            if not contains:
                first = found
                break
            # a longer way to say the same is no rival; a form of the effect that stands for itself may be one
            longer.add(rival.form)
            first = first or found
        if first is not None:
            out.append(first)
    return sorted(out, key=lambda a: a.loss)


def nested(search: Search, inner: Entry, outer: Entry, most: float = NESTED) -> bool:
    """Whether an entry's regressors lie in the span of another's (and the simulation's): no rival, a special case."""
    beyond = search.bank.explained(inner.index, [*search.base, *outer.index])
    return beyond < most * search.bank.explained(inner.index, search.base)


def quantities(variables: Sequence[str]) -> set[str]:
    """Quantities a term depends on; the two torques of the load side count as one."""
    return {{"load_motor_torque": "torque", "torque_path": "torque", "velocity": "speed"}.get(v, v) for v in variables}
