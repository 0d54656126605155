"""Two names, or one law that says what both say: springs and a Stribeck curve, or springs that stretch to that curve.

A step of the search takes what predicts best by itself. A law that says more than its own effect can be the best first
step also where nature has two effects or one of them, and two names take its place where it was passed over. So all are
compared when nothing more is found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from bench.mismatch.regression.beside import handicap_of, in_its_form
from bench.mismatch.regression.choosing import possible_forms
from bench.mismatch.regression.description import description
from bench.mismatch.regression.model import Chosen
from bench.mismatch.regression.regressors import Named
from bench.mismatch.regression.scan import Scan
from bench.mismatch.regression.state import Search
from bench.simulation.terms import LIBRARY, Form, Term


def one_or_two(search: Search) -> None:
    """Let one law take the place of two names of the model, two names that of one law, or one name that of either,
    where they predict points left out better. What says two effects has to be better than one of them by the price of
    an effect: a law whose springs are stiff is a Stribeck curve.
    """
    channel = search.model.channel
    for term, laws in _laws(channel):
        present = [c for c in search.model.chosen if c.effect == term.effect and isinstance(c.main.regressor, Named)]
        both = [c for c in search.model.chosen if c.effect in laws[0].says]
        if not present or not (both or any(_also(c) for c in present)):
            continue
        now = [*present, *both]
        others = [c for c in search.model.chosen if not any(c is k for k in now)]
        terms = [term, *(LIBRARY[effect] for effect in laws[0].says)]
        seen = _scanned(search, others)
        alone = [_best(search, others, seen, one, _plain(one, channel)) for one in terms]
        sets = [now, _best(search, others, seen, term, laws), _two(search, others, alone[0], terms), *alone]
        formed = [_formed(search, others, found) for found in sets if found]
        best = max(formed, key=lambda found: _worth(search, others, found))
        if best is not formed[0]:
            chosen = [*others, *best]
            search.model = replace(search.model, chosen=chosen, fit=search.model.refitted(chosen))


def _laws(channel: str) -> Iterator[tuple[Term, list[Form]]]:
    """Terms of a channel with their forms that say other effects as well."""
    for term in LIBRARY.values():
        laws = [form for form in term.forms.get(channel, ()) if form.says]
        if laws:
            yield term, laws


def _plain(term: Term, channel: str) -> list[Form]:
    """Forms of a term that say nothing else."""
    return [form for form in term.forms[channel] if not form.says]


def _worth(search: Search, others: Sequence[Chosen], found: Sequence[Chosen]) -> float:
    """Log density at points left out of effects beside others, less what their descriptions cost, and the price of
    each effect beyond the first.
    """
    cost = sum(description(search.model, c) + handicap_of(search, c) for c in found)
    effects = sum(1 + len(_also(c)) for c in found)
    cost += (effects - 1) * search.model.price
    return float(search.density([*others, *found]).sum()) - cost


def _formed(search: Search, others: Sequence[Chosen], found: Sequence[Chosen]) -> list[Chosen]:
    """Effects beside others, each with the correction of its form or without it, by which points left out are predicted
    better: the correction of one can be the other effect.
    """
    out = list(found)
    for k, one in enumerate(out):
        rest = [*others, *(c for c in out if c is not one)]
        out[k] = in_its_form(search, rest, one, search.density([*rest, one]))[0]
    return out


def _also(chosen: Chosen) -> tuple[str, ...]:
    regressor = chosen.main.regressor
    return regressor.form.says if isinstance(regressor, Named) else ()


def _best(search: Search, others: Sequence[Chosen], seen: Scan, term: Term, forms: Sequence[Form]) -> list[Chosen]:
    """The best of some forms of a term beside others, each refined from the point that gains most of those ``seen``
    there; nothing where none is possible and strong enough.
    """
    starts: dict[str, int] = {}
    for k in sorted(range(len(search.blocks)), key=lambda k: -float(seen.gain[k])):
        regressor = search.blocks[k].regressor
        if isinstance(regressor, Named) and regressor.term is term and regressor.form in forms:
            starts.setdefault(regressor.form.name, k)
    at = replace(search, model=replace(search.model, chosen=list(others), fit=search.model.refitted(others)))
    best = max(possible_forms(at, starts.values()), key=lambda c: _worth(search, others, [c]), default=None)
    return [] if best is None else [best]


def _scanned(search: Search, others: Sequence[Chosen]) -> Scan:
    return search.scan(others, search.model.refitted(others))


def _two(search: Search, others: Sequence[Chosen], first: list[Chosen], terms: Sequence[Term]) -> list[Chosen]:
    """Each of some effects in a form that says nothing else, one beside the other, of which the ``first`` is known as
    it is without the others; nothing where one is impossible.
    """
    channel = search.model.channel
    found = list(first)
    for term in terms[1:]:
        beside = [*others, *found]
        further = _best(search, beside, _scanned(search, beside), term, _plain(term, channel)) if found else []
        found = [*found, *further] if further else []
    if not found:
        return []
    beside = [*others, *found[1:]]
    again = _best(search, beside, _scanned(search, beside), terms[0], _plain(terms[0], channel))
    return [*again, *found[1:]] if again else []
