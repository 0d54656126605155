"""Two names, or one law that says what both say: springs and a Stribeck curve, or springs that stretch to that curve.

A step of the search takes what predicts best by itself. A law that says more than its own effect is the best first step
also where nature has two effects, and two names take its place where it was passed over. So both are compared when
nothing more is found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from bench.mismatch.regression.beside import handicap_of, shaped
from bench.mismatch.regression.choosing import MOST_FORMS
from bench.mismatch.regression.description import description
from bench.mismatch.regression.model import Chosen
from bench.mismatch.regression.regressors import Named
from bench.mismatch.regression.state import Search
from bench.simulation.terms import LIBRARY, Form, Term


def one_or_two(search: Search) -> None:
    """Let one law take the place of two names of the model, or two names that of one law, where they predict points
    left out better.
    """
    for term, law in _laws(search.model.channel):
        present = [c for c in search.model.chosen if c.effect == term.effect]
        both = [c for c in search.model.chosen if c.effect in law.says]
        if len(present) != 1 or not (_is(present[0], law) or both):
            continue
        others = [c for c in search.model.chosen if c is not present[0] and c not in both]
        one, two = _best(search, others, term, law), _two(search, others, term, law)
        sets = [found for found in (one, two) if found is not None]
        now = [c for c in search.model.chosen if c not in others]
        best = max([now, *sets], key=lambda found: _worth(search, others, found))
        if best is not now:
            chosen = [*others, *best]
            search.model = replace(search.model, chosen=chosen, fit=search.model.refitted(chosen))


def _laws(channel: str) -> Iterator[tuple[Term, Form]]:
    for term in LIBRARY.values():
        for form in term.forms.get(channel, ()):
            if form.says:
                yield term, form


def _is(chosen: Chosen, form: Form) -> bool:
    regressor = chosen.main.regressor
    return isinstance(regressor, Named) and regressor.form is form


def _worth(search: Search, others: Sequence[Chosen], found: Sequence[Chosen]) -> float:
    """Log density at points left out of effects beside others, less what their descriptions cost."""
    cost = sum(description(search.model, c) + handicap_of(search, c) for c in found)
    return float(search.density([*others, *found]).sum()) - cost


def _best(search: Search, others: Sequence[Chosen], term: Term, *forms: Form) -> list[Chosen] | None:
    """The best of some forms of a term beside others, refined from the point that gains most; None where none is
    possible.
    """
    seen = search.scan(others, search.model.refitted(others))
    starts: dict[str, int] = {}
    for k in sorted(range(len(search.blocks)), key=lambda k: -float(seen.gain[k])):
        regressor = search.blocks[k].regressor
        if isinstance(regressor, Named) and regressor.term is term and regressor.form in forms:
            starts.setdefault(regressor.form.name, k)
    refined = (shaped(search, others, search.blocks[k].regressor) for k in list(starts.values())[:MOST_FORMS])
    possible = [c for c in refined if c is not None]
    best = max(possible, key=lambda c: _worth(search, others, [c]), default=None)
    return None if best is None else [best]


def _two(search: Search, others: Sequence[Chosen], term: Term, law: Form) -> list[Chosen] | None:
    """The effect in a form that says nothing else, and what the law says beside it; None where one is impossible."""
    plain = _best(search, others, term, *(form for form in term.forms[search.model.channel] if not form.says))
    found = plain
    for effect in law.says:
        if found is None:
            return None
        other = LIBRARY[effect]
        further = _best(search, [*others, *found], other, *other.forms[search.model.channel])
        found = None if further is None else [*found, *further]
    return found
